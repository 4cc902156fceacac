"""Shaft elements of any circular section.

Cones, layers, and diameters that differ for mass and for stiffness.

Each ring of an element has shape functions of its own, of a beam loaded at its nodes. With the left end held, the end load (P, M) bends
a section at s by ψ′ = (P (l − s) + M)/EI and shears it by P/(κGA), so that stiffness, deflection w and rotation ψ follow from integrals
of 1/EI and 1/(κGA) along the ring, whatever its radii do; inertia uses these shapes. Of a ring of constant section this is
the element of Nelson (`problems/rotor/finite_elements/shaft.py`), of a cone the static deflection is exact.

Rings between the same two nodes share the motion of the nodes alone: their matrices add, as in other programs' layered models.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ksmea.arrays import Array
from problems.rotor.finite_elements.mesh import Element
from problems.rotor.finite_elements.segments import Layer, Material, ShaftSegment

# Ten Gauss points on each piece: of a cone whose radius doubles over one element the integrals are right within 1e-11
POINTS, WEIGHTS = (np.polynomial.legendre.leggauss(10)[0] + 1) / 2, np.polynomial.legendre.leggauss(10)[1] / 2
MAX_KEPT = 512  # rings whose integrals are kept

Ends = tuple[float, float]  # at the left and at the right end of an element


def cowper(poisson_ratio: float, ratio_squared: Array | float) -> Array | float:
    """Cowper's shear coefficient κ of a solid or hollow circular section, J. Appl. Mech.

    33 (1966) 335–340, doi 10.1115/1.3625046: 6(1 + ν)(1 + m²)² / ((7 + 6ν)(1 + m²)² + (20 + 12ν)m²) with m = r_i/r_o.
    """
    nu, m2 = poisson_ratio, ratio_squared
    return 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)


@dataclass(frozen=True)
class Ring:
    """A ring of an element: radii (m) at both ends, straight between them."""

    length: float  # m
    outer: Ends
    inner: Ends
    stiff_outer: Ends  # outer radius as stiffness has it
    material: Material
    shear_flexibility: float
    shear_coefficient: float | None  # None: Cowper's
    has_mass: bool
    has_stiffness: bool
    hubs: tuple[tuple[float, float, float], ...] = ()

    @cached_property
    def _edges(self) -> list[float]:
        return sorted({0.0, 1.0, *(edge for hub in self.hubs for edge in hub[:2])})

    def points(self, until: float = 1.0) -> tuple[Array, Array]:
        """Fractions of the length from 0 to `until` at which integrands are met, and their weights."""
        edges = [edge for edge in self._edges if edge < until] + [until]
        starts, widths = np.array(edges[:-1]), np.diff(edges)
        return (starts[:, None] + widths[:, None] * POINTS).ravel(), (widths[:, None] * WEIGHTS).ravel()

    def _section(self, fraction: Array, outer: Ends) -> tuple[Array, Array, Array]:
        """Area m², second moment m⁴ and the square of the ratio of radii."""
        large, small = (ends[0] + (ends[1] - ends[0]) * fraction for ends in (outer, self.inner))
        return np.pi * (large**2 - small**2), np.pi / 4 * (large**4 - small**4), (small / large) ** 2

    def flexibilities(self, fraction: Array) -> tuple[Array, Array]:
        """1/EI, hubs included, and 1/(κGA) times the flexibility in shear that is counted."""
        area, second_moment, ratio = self._section(fraction, self.stiff_outer)
        stiffer = np.ones_like(fraction)
        for low, high, rise in self.hubs:
            stiffer = stiffer * np.where((low <= fraction) & (fraction <= high), 1 + rise, 1.0)
        kappa = cowper(self.material.poisson_ratio, ratio) if self.shear_coefficient is None else self.shear_coefficient
        shear = self.shear_flexibility / (kappa * self.material.shear_modulus * area)
        return 1 / (self.material.young_modulus * second_moment * stiffer), shear

    def end_motion(self, fraction: float) -> Array:
        """Deflection, rotation and slope at a fraction of the length per load at the right end, (3, 2).

        Loads are a force and a moment; the left end is held.
        """
        points, weights = self.points(fraction)
        bent, sheared = self.flexibilities(points)
        step, arm = self.length * weights, self.length * (1 - points)
        moment = np.stack([arm, np.ones_like(arm)], axis=1)  # per P and per M
        rotation = (step * bent) @ moment
        deflection = (step * bent * self.length * (fraction - points)) @ moment + [step @ sheared, 0.0]
        here = self.flexibilities(np.array([fraction]))[1][0]
        return np.array([deflection, rotation, [rotation[0] + here, rotation[1]]])

    @cached_property
    def flexibility(self) -> Array:
        """Deflection and rotation of the right end per force and moment there, (2, 2)."""
        return self.end_motion(1.0)[:2]

    @cached_property
    def _end_loads(self) -> Array:
        """Force and moment at the right end per degree of freedom of a bending plane, (2, 4)."""
        return np.asarray(np.linalg.solve(self.flexibility, right_end(self.length)))

    def shapes(self, fraction: float) -> Array:
        """Deflection, rotation and slope at a fraction of the length per degree of freedom, (3, 4).

        The degrees of freedom are of one bending plane.
        """
        rigid = np.array([[1, self.length * fraction, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0]])
        return np.asarray(rigid + self.end_motion(fraction) @ self._end_loads)

    @cached_property
    def stiffness(self) -> Array:
        """Stiffness in one bending plane, (4, 4)."""
        relative = right_end(self.length)
        return np.asarray(relative.T @ np.linalg.solve(self.flexibility, relative))

    @cached_property
    def _at_points(self) -> Array:
        return np.array([self.shapes(float(point)) for point in self.points()[0]])  # (n_point, 3, 4)

    def products(self, which: int, density: Array | float = 1.0) -> Array:
        """∫ density Nᵀ N dz of deflections (0), rotations (1) or slopes (2), (4, 4)."""
        shapes, weights = self._at_points[:, which], self.length * self.points()[1] * density
        return np.asarray((shapes.T * weights) @ shapes)

    @cached_property
    def inertia(self) -> tuple[Array, Array]:
        """Mass matrices of deflection and of rotation about a diameter, (4, 4) each."""
        area, second_moment, _ = self._section(self.points()[0], self.outer)
        density = self.material.density
        return self.products(0, density * area), self.products(1, density * second_moment)


def right_end(length: float) -> Array:
    """Deflection and rotation of the right end of an element as seen from the left one, (2, 4).

    They are in one bending plane.
    """
    return np.array([[-1, -length, 1, 0], [0, -1, 0, 1]])


def rings(element: Element) -> tuple[Ring, ...]:
    """Rings of an element, from the shaft itself outwards."""
    segment = element.segment
    assert isinstance(segment, ShaftSegment), "a coupling"
    return _rings(segment, element.length, element.ends, element.hubs)


@lru_cache(MAX_KEPT)
def _rings(
    segment: ShaftSegment, length: float, ends: Ends, hubs: tuple[tuple[float, float, float], ...]
) -> tuple[Ring, ...]:
    def radii(left: float, right: float | None) -> Ends:
        last = left if right is None else right
        first, second = (left + (last - left) * end for end in ends)
        return first, second

    def ring(part: ShaftSegment | Layer, stiff_outer: Ends, coefficient: float | None, carries: str) -> Ring:
        return Ring(
            length,
            radii(part.outer_radius, part.outer_radius_right),
            radii(part.inner_radius, part.inner_radius_right),
            stiff_outer,
            part.material,
            part.shear_flexibility,
            coefficient,
            carries != "stiffness",
            carries != "mass",
            hubs,
        )

    outer = radii(segment.outer_radius, segment.outer_radius_right)
    stiff = outer if segment.stiffness_outer_radius is None else (segment.stiffness_outer_radius,) * 2
    own = ring(segment, stiff, segment.shear_coefficient, "both")
    further = (
        ring(layer, radii(layer.outer_radius, layer.outer_radius_right), None, layer.carries)
        for layer in segment.layers
    )
    return (own, *further)
