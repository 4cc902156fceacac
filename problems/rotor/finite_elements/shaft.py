"""The Timoshenko shaft element.

Bending, shear, rotary inertia and gyroscopic effect of a circular shaft.

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
from problems.rotor.finite_elements.mesh import Element
from problems.rotor.finite_elements.sections import cowper, right_end, rings
from problems.rotor.finite_elements.segments import CouplingSegment, Disk, ShaftSegment

IN_X_PLANE, IN_Y_PLANE = [0, 3], [1, 2]  # of a node's (x, y, φ_x, φ_y)
# Which degrees of freedom of the element each bending plane uses, and with which sign: (4, 8).
X_PLANE = np.zeros((4, 8))
X_PLANE[[0, 1, 2, 3], [0, 3, 4, 7]] = [1, 1, 1, 1]
Y_PLANE = np.zeros((4, 8))
Y_PLANE[[0, 1, 2, 3], [1, 2, 5, 6]] = [1, -1, 1, -1]

# Four Gauss points integrate polynomials up to degree 7 exactly; products of two cubics have degree 6.
GAUSS_POINTS, GAUSS_WEIGHTS = (np.polynomial.legendre.leggauss(4)[0] + 1) / 2, np.polynomial.legendre.leggauss(4)[1] / 2


Shapes = Callable[[float, float, Array | float], Array]  # of length, Φ and fractions
BETWEEN_ENDS = np.array([[1.0, -1.0], [-1.0, 1.0]])
MAX_KEPT = 1024  # integrals and rows that are made again and again


@dataclass(frozen=True)
class ElementMatrices:
    """Matrices of M q̈ + Ω G q̇ + K q = f, each (8, 8)."""

    mass: Array
    gyroscopic: Array
    stiffness: Array


def shear_coefficient(segment: ShaftSegment) -> float:
    """κ of a cylinder: Cowper's if none is given."""
    ratio_squared = (segment.inner_radius / segment.outer_radius) ** 2
    return segment.shear_coefficient or float(cowper(segment.material.poisson_ratio, ratio_squared))


def shear_parameter(element: Element) -> float:
    """Φ = 12EI/(κGAl²), the flexibility in shear relative to that in bending; 0 for Euler–Bernoulli."""
    segment = cylinder(element)
    shear_stiffness = shear_coefficient(segment) * segment.material.shear_modulus * segment.area
    of_timoshenko = 12 * segment.material.young_modulus * segment.second_moment / (shear_stiffness * element.length**2)
    return segment.shear_flexibility * of_timoshenko


def deflection_shapes(length: float, phi: float, fraction: Array | float) -> Array:
    """Deflection w at fractions ξ (…) of an element's length (m) per degree of freedom, (…, 4).

    The degrees of freedom are of one bending plane, m per m and per rad, with its shear parameter Φ.
    """
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


def cylinder(element: Element) -> ShaftSegment:
    """The segment of an element, one constant ring."""
    assert isinstance(element.segment, ShaftSegment) and element.segment.is_cylinder, (
        "a coupling, cone or layered shaft"
    )
    return element.segment


def is_cylinder(element: Element) -> bool:
    return isinstance(element.segment, ShaftSegment) and element.segment.is_cylinder


@lru_cache(maxsize=MAX_KEPT)
def element_matrices(element: Element) -> ElementMatrices:
    """Consistent matrices of an element, both bending planes and their gyroscopic coupling.

    They are kept, and not to be written to.
    """
    found = _element_matrices(element)
    for matrix in (found.mass, found.gyroscopic, found.stiffness):
        matrix.flags.writeable = False
    return found


def _element_matrices(element: Element) -> ElementMatrices:
    if isinstance(element.segment, CouplingSegment):
        return _coupling_matrices(element.segment)
    segment = element.segment
    if segment.is_cylinder:
        density = segment.material.density
        translation = density * segment.area * _integral_of_products(deflection_shapes, element)
        rotation = density * segment.second_moment * _integral_of_products(rotation_shapes, element)
        stiffness = stiffness_under_hubs(element) if element.hubs else plane_stiffness(element)
    else:
        own = rings(element)
        inertia = np.sum([ring.inertia for ring in own if ring.has_mass], axis=0)
        translation, rotation = inertia
        stiffness = np.sum([ring.stiffness for ring in own if ring.has_stiffness], axis=0)
    polar = 2 * rotation  # a circular section's polar moment is twice that about a diameter
    mass = translation + rotation if segment.rotary_inertia else translation
    gyroscopic = X_PLANE.T @ polar @ Y_PLANE - Y_PLANE.T @ polar @ X_PLANE
    return ElementMatrices(
        mass=_in_both_planes(mass),
        # Spin Ω turns a rotation rate φ̇_y into a moment I_p Ω φ̇_y about x, and φ̇_x into −I_p Ω φ̇_x about y.
        gyroscopic=gyroscopic if segment.gyroscopic else np.zeros_like(gyroscopic),
        stiffness=_in_both_planes(stiffness),
    )


def _coupling_matrices(coupling: CouplingSegment) -> ElementMatrices:
    """Springs between its two ends, and what its ends carry."""
    mass, gyroscopic = np.zeros((8, 8)), np.zeros((8, 8))
    for start, end in zip((0, 4), coupling.ends()):
        here = slice(start, start + 4)
        mass[here, here], gyroscopic[here, here] = disk_mass(end), disk_gyroscopic(end)
    springs = np.diag([*coupling.stiffness, *coupling.angular_stiffness])
    return ElementMatrices(mass, gyroscopic, np.kron(BETWEEN_ENDS, springs))


def segment_damping(element: Element) -> Array:
    """Damping of an element on the ground, (8, 8) N s/m.

    It is of a coupling, or in proportion to the mass and stiffness of a shaft.
    """
    if isinstance(element.segment, CouplingSegment):
        dampers = np.diag([*element.segment.damping, *element.segment.angular_damping])
        return np.asarray(np.kron(BETWEEN_ENDS, dampers))
    of_mass, of_stiffness = element.segment.standing_damping
    if not of_mass and not of_stiffness:
        return np.zeros((8, 8))
    own = element_matrices(element)
    return of_mass * own.mass + of_stiffness * own.stiffness


def segment_internal_damping(element: Element) -> Array:
    """Internal damping of the turning shaft, (8, 8) N s/m."""
    if isinstance(element.segment, CouplingSegment) or not element.segment.internal_damping:
        return np.zeros((8, 8))
    return element.segment.internal_damping * element_matrices(element).stiffness


def segment_loss(element: Element) -> Array:
    """Its loss factor times its stiffness, (8, 8) N/m."""
    if isinstance(element.segment, CouplingSegment) or not element.segment.loss_factor:
        return np.zeros((8, 8))
    return element.segment.loss_factor * element_matrices(element).stiffness


def segment_tension(element: Element) -> Array:
    """Stiffness by the tension of its own segment, (8, 8) N/m."""
    if isinstance(element.segment, CouplingSegment) or not element.segment.axial_force:
        return np.zeros((8, 8))
    return element.segment.axial_force * geometric_stiffness(element)


def drag(element: Element) -> Array:
    """Damping per N s/m² of what surrounds the shaft and stands still, (8, 8) m.

    The force −c ẇ on each length.
    """
    if isinstance(element.segment, CouplingSegment):
        return np.zeros((8, 8))
    if not is_cylinder(element):
        return _in_both_planes(rings(element)[0].products(0))
    return _in_both_planes(_integral_of_products(deflection_shapes, element))


def geometric_stiffness(element: Element) -> Array:
    """Stiffness per N of tension, (8, 8) 1/m.

    An axial force does the work ½ N ∫ (dw/dz)² dz (Nelson 1980).
    """
    if isinstance(element.segment, CouplingSegment):
        return np.zeros((8, 8))
    if not is_cylinder(element):
        return _in_both_planes(rings(element)[0].products(2))
    return _in_both_planes(_integral_of_products(slope_shapes, element))


def disk_mass(disk: Disk) -> Array:
    """(4, 4): translation and rotation about a diameter."""
    return np.diag([disk.mass, disk.mass, disk.diametral_inertia, disk.diametral_inertia])


def disk_gyroscopic(disk: Disk) -> Array:
    """(4, 4), multiplied by Ω in M q̈ + Ω G q̇ + K q = f.

    The disk's angular momentum about its own axis, I_p Ω, turns with the axis (φ_y, −φ_x, 1); its rate of change
    is I_p Ω (φ̇_y, −φ̇_x).
    """
    gyroscopic = np.zeros((4, 4))
    gyroscopic[2, 3], gyroscopic[3, 2] = disk.polar_inertia, -disk.polar_inertia
    return gyroscopic


def plane_stiffness(element: Element) -> Array:
    """Stiffness of one bending plane, (4, 4), with shear (Nelson 1980, appendix)."""
    length, phi = element.length, shear_parameter(element)
    near, far = (4 + phi) * length**2, (2 - phi) * length**2
    segment = cylinder(element)
    bending = segment.material.young_modulus * segment.second_moment
    return (bending / (length**3 * (1 + phi))) * np.array(
        [
            [12, 6 * length, -12, 6 * length],
            [6 * length, near, -6 * length, far],
            [-12, -6 * length, 12, -6 * length],
            [6 * length, far, -6 * length, near],
        ]
    )


def stiffness_under_hubs(element: Element) -> Array:
    """Bending stiffness (4, 4) of an element with parts that hubs make stiffer in bending."""
    relative = right_end(element.length)
    return np.asarray(relative.T @ np.linalg.solve(flexibility_under_hubs(element), relative))


def flexibility_under_hubs(element: Element) -> Array:
    """Motion of the right end per force and moment there, (2, 2), the sum over an element's parts.

    With its left end held and P, M at its right one, the bending moment is P a + M at a distance a from there.
    """
    if not is_cylinder(element):
        stiffnesses = (np.linalg.inv(ring.flexibility) for ring in rings(element) if ring.has_stiffness)
        return np.asarray(np.linalg.inv(sum(stiffnesses)))
    length, segment = element.length, cylinder(element)
    bending = segment.material.young_modulus * segment.second_moment
    flexibility = np.diag([shear_parameter(element) * length**3 / (12 * bending), 0.0])
    for left, right in pairwise(sorted({0.0, 1.0, *(edge for hub in element.hubs for edge in hub[:2])})):
        stiffer = np.prod([1 + rise for low, high, rise in element.hubs if low <= left and right <= high])
        first, second, third = (((1 - left) ** n - (1 - right) ** n) * length**n / n for n in (1, 2, 3))  # ∫ aⁿ⁻¹ da
        flexibility += np.array([[third, second], [second, first]]) / (bending * stiffer)
    return flexibility


def displacement_row(element: Element, fraction: float, direction: str) -> Array:
    """Row (8,) that reads the deflection in a direction at a fraction of the element.

    It applies to the degrees of freedom of the element.
    """
    if is_cylinder(element):
        shapes = _deflection(element.length, shear_parameter(element), fraction)
    elif isinstance(element.segment, CouplingSegment):  # straight between its ends
        shapes = np.array([1 - fraction, 0.0, fraction, 0.0])
    else:
        shapes = rings(element)[0].shapes(fraction)[0]
    along_x, along_y = cosines(direction)
    return np.asarray(shapes @ (along_x * X_PLANE + along_y * Y_PLANE))


def deflection_along(element: Element, fractions: Array) -> Array:
    """Deflection at fractions (n,) of an element per degree of freedom of one bending plane, (n, 4)."""
    if is_cylinder(element):
        return deflection_shapes(element.length, shear_parameter(element), fractions)
    if isinstance(element.segment, CouplingSegment):
        nothing = np.zeros_like(fractions)
        return np.stack([1 - fractions, nothing, fractions, nothing], axis=-1)
    ring = rings(element)[0]
    return np.array([ring.shapes(float(fraction))[0] for fraction in fractions])


def rotation_rows(element: Element, fraction: float) -> Array:
    """The rows (2, 8) that read the rotations φ_x and φ_y of the section at a fraction of the element."""
    if isinstance(element.segment, CouplingSegment):  # of its left end, then of its right one
        shapes = np.array([0.0, 1 - fraction, 0.0, fraction])
    elif is_cylinder(element):
        shapes = rotation_shapes(element.length, shear_parameter(element), fraction)
    else:
        shapes = rings(element)[0].shapes(fraction)[1]
    return np.stack([-shapes @ Y_PLANE, shapes @ X_PLANE])


@lru_cache(MAX_KEPT)
def _deflection(length: float, phi: float, fraction: float) -> Array:
    shapes = deflection_shapes(length, phi, fraction)
    shapes.flags.writeable = False
    return shapes


def _integral_of_products(shapes: Shapes, element: Element) -> Array:
    """∫ Nᵀ N dz over the element, (4, 4)."""
    return _integral(shapes, element.length, shear_parameter(element))


@lru_cache(MAX_KEPT)
def _integral(shapes: Shapes, length: float, phi: float) -> Array:
    """∫ Nᵀ N dz, kept: a rotor whose material changes has elements of the same shapes."""
    at_points = shapes(length, phi, GAUSS_POINTS)  # (4 points, 4)
    integral = np.asarray(length * (at_points.T * GAUSS_WEIGHTS) @ at_points)
    integral.flags.writeable = False
    return integral


def _in_both_planes(plane: Array) -> Array:
    return X_PLANE.T @ plane @ X_PLANE + Y_PLANE.T @ plane @ Y_PLANE
