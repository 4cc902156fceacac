"""The Timoshenko shaft element: bending, shear, rotary inertia and gyroscopic effect of a circular shaft.

H. D. Nelson, "A finite rotating shaft element using Timoshenko beam theory", J. Mech. Design 102 (1980) 793–803,
doi 10.1115/1.3254824. Each bending plane has the degrees of freedom (w₁, ψ₁, w₂, ψ₂) with ψ the rotation of the
section, ψ = dw/dz without shear: x–z holds (x, φ_y), y–z holds (y, −φ_x). An element's degrees of freedom are
(x, y, φ_x, φ_y) of its left node, then of its right one. Its shape functions solve the equations of a beam loaded
at its nodes, so that static deflections are exact and nothing locks in shear.

Order of convergence: shear is constant in an element, while inertia makes it vary, so natural frequencies converge
with the square of the element's length; for a slender shaft, where shear does not count, with its fourth power.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.channel import cosines
from problems.rotor.finite_elements.data import ShaftSegment
from problems.rotor.finite_elements.mesh import Element

IN_X_PLANE, IN_Y_PLANE = [0, 3], [1, 2]  # of a node's (x, y, φ_x, φ_y)
# Which degrees of freedom of the element each bending plane uses, and with which sign: (4, 8).
X_PLANE = np.zeros((4, 8))
X_PLANE[[0, 1, 2, 3], [0, 3, 4, 7]] = [1, 1, 1, 1]
Y_PLANE = np.zeros((4, 8))
Y_PLANE[[0, 1, 2, 3], [1, 2, 5, 6]] = [1, -1, 1, -1]

# Four Gauss points integrate polynomials up to degree 7 exactly; products of two cubics have degree 6.
GAUSS_POINTS, GAUSS_WEIGHTS = (np.polynomial.legendre.leggauss(4)[0] + 1) / 2, np.polynomial.legendre.leggauss(4)[1] / 2


Shapes = Callable[[float, float, Array | float], Array]  # of length, Φ and fractions
MAX_KEPT = 1024  # integrals and rows that are made again and again


@dataclass(frozen=True)
class ElementMatrices:
    """Matrices of M q̈ + Ω G q̇ + K q = f, each (8, 8)."""

    mass: Array
    gyroscopic: Array
    stiffness: Array


def shear_coefficient(segment: ShaftSegment) -> float:
    """Cowper's shear coefficient κ of a solid or hollow circular section, J. Appl. Mech. 33 (1966) 335–340,
    doi 10.1115/1.3625046: 6(1 + ν)(1 + m²)² / ((7 + 6ν)(1 + m²)² + (20 + 12ν)m²) with m = r_i/r_o."""
    nu = segment.material.poisson_ratio
    m2 = (segment.inner_radius / segment.outer_radius) ** 2
    return 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)


def shear_parameter(element: Element) -> float:
    """Φ = 12EI/(κGAl²), the flexibility in shear relative to that in bending; 0 for Euler–Bernoulli."""
    segment = element.segment
    shear_stiffness = shear_coefficient(segment) * segment.material.shear_modulus * segment.area
    of_timoshenko = 12 * segment.material.young_modulus * segment.second_moment / (shear_stiffness * element.length**2)
    return segment.shear_flexibility * of_timoshenko


def deflection_shapes(length: float, phi: float, fraction: Array | float) -> Array:
    """Deflection w at fractions ξ (…) of an element's length (m) per degree of freedom of one bending plane, (…, 4), m per m and
    per rad, with its shear parameter Φ."""
    xi = np.asarray(fraction)
    return np.stack(
        [
            1 + phi * (1 - xi) - 3 * xi**2 + 2 * xi**3,
            length * (xi - 2 * xi**2 + xi**3 + phi / 2 * (xi - xi**2)),
            phi * xi + 3 * xi**2 - 2 * xi**3,
            length * (xi**3 - xi**2 - phi / 2 * (xi - xi**2)),
        ],
        axis=-1,
    ) / (1 + phi)


def rotation_shapes(length: float, phi: float, fraction: Array | float) -> Array:
    """Rotation ψ of the section likewise; rad per m, per rad."""
    xi = np.asarray(fraction)
    return np.stack(
        [
            6 / length * (xi**2 - xi),
            1 - 4 * xi + 3 * xi**2 + phi * (1 - xi),
            6 / length * (xi - xi**2),
            3 * xi**2 - 2 * xi + phi * xi,
        ],
        axis=-1,
    ) / (1 + phi)


def slope_shapes(length: float, phi: float, fraction: Array | float) -> Array:
    """Slope dw/dz likewise; rad per m, per rad."""
    xi = np.asarray(fraction)
    return np.stack(
        [
            (6 * (xi**2 - xi) - phi) / length,
            1 - 4 * xi + 3 * xi**2 + phi / 2 * (1 - 2 * xi),
            (6 * (xi - xi**2) + phi) / length,
            3 * xi**2 - 2 * xi - phi / 2 * (1 - 2 * xi),
        ],
        axis=-1,
    ) / (1 + phi)


def element_matrices(element: Element) -> ElementMatrices:
    """Consistent matrices of an element, both bending planes and their gyroscopic coupling."""
    segment = element.segment
    density = segment.material.density
    translation = density * segment.area * _integral_of_products(deflection_shapes, element)
    rotation = density * segment.second_moment * _integral_of_products(rotation_shapes, element)
    polar = 2 * rotation  # a circular section's polar moment is twice that about a diameter
    stiffness = stiffness_under_hubs(element) if element.hubs else plane_stiffness(element)
    return ElementMatrices(
        mass=_in_both_planes(translation + rotation),
        # Spin Ω turns a rotation rate φ̇_y into a moment I_p Ω φ̇_y about x, and φ̇_x into −I_p Ω φ̇_x about y.
        gyroscopic=X_PLANE.T @ polar @ Y_PLANE - Y_PLANE.T @ polar @ X_PLANE,
        stiffness=_in_both_planes(stiffness),
    )


def drag(element: Element) -> Array:
    """Damping per N s/m² of what surrounds the shaft and stands still, (8, 8) m: the force −c ẇ on each length."""
    return _in_both_planes(_integral_of_products(deflection_shapes, element))


def geometric_stiffness(element: Element) -> Array:
    """Stiffness per N of tension, (8, 8) 1/m: an axial force does the work ½ N ∫ (dw/dz)² dz (Nelson 1980)."""
    return _in_both_planes(_integral_of_products(slope_shapes, element))


def plane_stiffness(element: Element) -> Array:
    """Stiffness of one bending plane, (4, 4), with shear (Nelson 1980, appendix)."""
    length, phi = element.length, shear_parameter(element)
    near, far = (4 + phi) * length**2, (2 - phi) * length**2
    bending = element.segment.material.young_modulus * element.segment.second_moment
    return (bending / (length**3 * (1 + phi))) * np.array(
        [
            [12, 6 * length, -12, 6 * length],
            [6 * length, near, -6 * length, far],
            [-12, -6 * length, 12, -6 * length],
            [6 * length, far, -6 * length, near],
        ]
    )


def stiffness_under_hubs(element: Element) -> Array:
    """The same, (4, 4), where hubs make parts of the element stiffer in bending."""
    relative = motion_of_right_end(element)
    return np.asarray(relative.T @ np.linalg.solve(flexibility_under_hubs(element), relative))


def motion_of_right_end(element: Element) -> Array:
    """Deflection and rotation of the right end of an element as seen from the left one, (2, 4), in one bending plane."""
    return np.array([[-1, -element.length, 1, 0], [0, -1, 0, 1]])


def flexibility_under_hubs(element: Element) -> Array:
    """That motion per force and moment at the right end, (2, 2), the sum of an element's parts': with its left end held and P, M at
    its right one, the bending moment is P a + M at a distance a from there."""
    length, segment = element.length, element.segment
    bending = segment.material.young_modulus * segment.second_moment
    flexibility = np.diag([shear_parameter(element) * length**3 / (12 * bending), 0.0])
    for left, right in pairwise(sorted({0.0, 1.0, *(edge for hub in element.hubs for edge in hub[:2])})):
        stiffer = np.prod([1 + rise for low, high, rise in element.hubs if low <= left and right <= high])
        first, second, third = (((1 - left) ** n - (1 - right) ** n) * length**n / n for n in (1, 2, 3))  # ∫ aⁿ⁻¹ da
        flexibility += np.array([[third, second], [second, first]]) / (bending * stiffer)
    return flexibility


def displacement_row(element: Element, fraction: float, direction: str) -> Array:
    """The row (8,) that reads the deflection in a direction at a fraction of the element from its degrees of freedom."""
    return _deflection_row(element.length, shear_parameter(element), fraction, direction)


@lru_cache(MAX_KEPT)
def _deflection_row(length: float, phi: float, fraction: float, direction: str) -> Array:
    along_x, along_y = cosines(direction)
    row = np.asarray(deflection_shapes(length, phi, fraction) @ (along_x * X_PLANE + along_y * Y_PLANE))
    row.flags.writeable = False
    return row


def _integral_of_products(shapes: Shapes, element: Element) -> Array:
    """∫ Nᵀ N dz over the element, (4, 4)."""
    return _integral(shapes, element.length, shear_parameter(element))


@lru_cache(MAX_KEPT)
def _integral(shapes: Shapes, length: float, phi: float) -> Array:
    """The same: a rotor whose material changes has elements of the same shapes."""
    at_points = shapes(length, phi, GAUSS_POINTS)  # (4 points, 4)
    integral = np.asarray(length * (at_points.T * GAUSS_WEIGHTS) @ at_points)
    integral.flags.writeable = False
    return integral


def _in_both_planes(plane: Array) -> Array:
    return X_PLANE.T @ plane @ X_PLANE + Y_PLANE.T @ plane @ Y_PLANE
