"""Rotor as data: its parts and their positions, in SI units, independent of the solver.

Axes: z runs along the shaft from its left end, x and y are the lateral directions, and the shaft turns from x to y.
Disks and bearings sit at nodes of the mesh; unbalance and probes may lie anywhere on the shaft. Matrices over the two lateral axes,
one for each of many sets and speeds, have these axes first: (2, 2, …).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from problems.rotor.finite_elements.bearing import LARGEST, Bearing

SAME_PLACE = 1e-9  # of the shaft's length: positions closer than this are one (rounding of summed lengths)


@dataclass(frozen=True)
class Material:
    """An isotropic elastic material."""

    young_modulus: float  # Pa
    density: float  # kg/m³
    poisson_ratio: float

    def __post_init__(self) -> None:
        _require_positive("Young's modulus", self.young_modulus, "Pa")
        _require_positive("density", self.density, "kg/m³")
        if not -1 < self.poisson_ratio <= 0.5:
            raise SettingError(
                f"Poisson's ratio: expected above -1 and at most 0.5, got {self.poisson_ratio}; steel has 0.3"
            )

    @property
    def shear_modulus(self) -> float:  # Pa
        return self.young_modulus / (2 * (1 + self.poisson_ratio))


@dataclass(frozen=True)
class ShaftSegment:
    """A length of shaft of constant circular section, cut into equal elements."""

    length: float  # m
    outer_radius: float  # m
    material: Material
    n_element: int = 1
    inner_radius: float = 0.0  # m
    shear_flexibility: float = 1.0  # of that of Timoshenko's theory; 0: Euler–Bernoulli

    def __post_init__(self) -> None:
        _require_positive("length of a shaft segment", self.length, "m")
        _require_ring("shaft segment", self.inner_radius, self.outer_radius)
        _require_not_negative("shear flexibility of a shaft segment", self.shear_flexibility, "times Timoshenko's")
        if self.n_element < 1:
            raise SettingError(
                f"elements of a shaft segment: expected at least 1, got {self.n_element}; refine the mesh"
            )

    @property
    def area(self) -> float:  # m²
        return math.pi * (self.outer_radius**2 - self.inner_radius**2)

    @property
    def second_moment(self) -> float:
        """Second moment of area about a diameter, m⁴; the polar one is twice as large."""
        return math.pi / 4 * (self.outer_radius**4 - self.inner_radius**4)


@dataclass(frozen=True)
class Disk:
    """A rigid disk fixed to a node of the shaft."""

    position: float  # m
    mass: float  # kg
    polar_inertia: float  # kg m², about the shaft
    diametral_inertia: float  # kg m², about a diameter through the centre of mass

    def __post_init__(self) -> None:
        _require_positive("mass of a disk", self.mass, "kg")
        _require_not_negative("polar inertia of a disk", self.polar_inertia, "kg m²")
        _require_not_negative("diametral inertia of a disk", self.diametral_inertia, "kg m²")

    @classmethod
    def from_geometry(
        cls, position: float, *, outer_radius: float, inner_radius: float, thickness: float, density: float
    ) -> Disk:
        """A homogeneous ring, lengths in m and density in kg/m³:
        m = ρπ(r_o² − r_i²)h, I_p = m(r_o² + r_i²)/2, I_d = m(3r_o² + 3r_i² + h²)/12.

        >>> round(Disk.from_geometry(0.2, outer_radius=0.12, inner_radius=0.05, thickness=0.05, density=7800).mass, 3)
        14.58
        """
        _require_ring("disk", inner_radius, outer_radius)
        _require_positive("thickness of a disk", thickness, "m")
        _require_positive("density of a disk", density, "kg/m³")
        mass = density * math.pi * (outer_radius**2 - inner_radius**2) * thickness
        radii_squared = outer_radius**2 + inner_radius**2
        return cls(position, mass, mass * radii_squared / 2, mass * (3 * radii_squared + thickness**2) / 12)


@dataclass(frozen=True)
class UnbalancePlane:
    """An unbalance m·e at a position on the shaft; at t = 0 it points `phase` past +x towards +y."""

    position: float  # m
    magnitude: float = 0.0  # kg m
    phase: float = 0.0  # rad

    def __post_init__(self) -> None:
        _require_not_negative("magnitude of an unbalance", self.magnitude, "kg m")
        if not abs(self.phase) <= LARGEST:
            raise SettingError(f"phase of an unbalance: expected an angle in rad, got {self.phase}")


@dataclass(frozen=True)
class HousingProbe:
    """A place whose probes are fixed to the housing of a bearing: they read the shaft against it."""

    position: float  # m
    direction: str | None  # None: all directions
    bearing: int  # index in `Rotor.supported`


@dataclass(frozen=True)
class Hub:
    """What makes the shaft beneath it stiffer in bending, EI (1 + `stiffening`), over a width about a position."""

    position: float  # m
    width: float  # m
    stiffening: float

    def __post_init__(self) -> None:
        _require_positive("width of a hub", self.width, "m")
        if not -1 < self.stiffening <= LARGEST:
            raise SettingError(f"stiffening of a hub: expected a number above -1, got {self.stiffening}")


@dataclass(frozen=True)
class Rotor:
    """Shaft segments from left to right, and what sits on them.

    `internal_damping` (s) is that of the turning shaft in proportion to its stiffness, C_i = β K_s: it damps motion as
    the shaft sees it, (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, section 7.3).
    `external_damping` (N s/m per m of shaft) is that of what surrounds the shaft and stands still, and `axial_force` (N) a
    constant tension of the whole shaft.
    """

    segments: tuple[ShaftSegment, ...]
    disks: tuple[Disk, ...] = ()
    bearings: tuple[Bearing, ...] = ()
    unbalance: tuple[UnbalancePlane, ...] = ()
    internal_damping: float = 0.0
    external_damping: float = 0.0
    axial_force: float = 0.0
    hubs: tuple[Hub, ...] = ()
    seals: tuple[
        Bearing, ...
    ] = ()  # forces as those of bearings, but they carry no weight, and effects on bearings leave them alone
    couplings: tuple[float, ...] = ()  # positions, m
    housing_probes: tuple[HousingProbe, ...] = ()

    def __post_init__(self) -> None:
        _require_not_negative("internal damping", self.internal_damping, "s")
        _require_not_negative("external damping", self.external_damping, "N s/m²")
        if not abs(self.axial_force) <= LARGEST:
            raise SettingError(f"axial force: expected a number in N, got {self.axial_force}")
        if not self.segments:
            raise SettingError("shaft: expected at least one segment, got none")
        for disk in self.disks:
            self.node_at(disk.position, "disk")
        for bearing in self.bearings:
            self.node_at(bearing.position, "bearing")
        for seal in self.seals:
            self.node_at(seal.position, "seal")
        for coupling in self.couplings:
            self.require_on_shaft(coupling, "coupling")
        for plane in self.unbalance:
            self.require_on_shaft(plane.position, "unbalance")
        for hub in self.hubs:
            self.require_on_shaft(hub.position, "hub")

    @property
    def supported(self) -> tuple[Bearing, ...]:
        """All bearings, then all seals."""
        return (*self.bearings, *self.seals)

    def housing_of(self, channel: Channel) -> int | None:
        """The bearing, by its index in `supported`, whose housing carries a probe; None: it is fixed to the ground."""
        for probe in self.housing_probes:
            is_there = abs(channel.position - probe.position) <= SAME_PLACE * self.length
            if is_there and probe.direction in (None, channel.direction):
                return probe.bearing
        return None

    @cached_property
    def length(self) -> float:  # m
        return sum(segment.length for segment in self.segments)

    @cached_property
    def node_positions(self) -> Array:
        """Where the nodes lie, (n_node,) m."""
        ends = np.cumsum([0.0] + [segment.length for segment in self.segments])
        inside = [
            np.linspace(start, end, segment.n_element, endpoint=False)
            for start, end, segment in zip(ends[:-1], ends[1:], self.segments, strict=True)
        ]
        return np.concatenate([*inside, ends[-1:]])

    def node_at(self, position: float, what: str) -> int:
        """The node at a position (m); `what` names the thing that needs it in the error."""
        self.require_on_shaft(position, what)
        node = int(np.argmin(np.abs(self.node_positions - position)))
        nearest = self.node_positions[node]
        if abs(nearest - position) > SAME_PLACE * self.length:
            raise SettingError(
                f"{what} at {position:g} m: expected a node of the mesh there, the nearest is at {nearest:g} m;"
                " end a shaft segment there or change its number of elements"
            )
        return node

    def require_on_shaft(self, position: float, what: str) -> None:
        tolerance = SAME_PLACE * self.length
        if not -tolerance <= position <= self.length + tolerance:
            raise SettingError(
                f"{what} at {position:g} m: expected a position on the shaft, from 0 to {self.length:g} m"
            )


def _require_positive(what: str, value: float, unit: str) -> None:
    if not 1 / LARGEST <= value <= LARGEST:
        raise SettingError(f"{what}: expected a number above 0 {unit}, got {value}")


def _require_not_negative(what: str, value: float, unit: str) -> None:
    if not 0 <= value <= LARGEST:
        raise SettingError(f"{what}: expected a number of at least 0 {unit}, got {value}")


def _require_ring(what: str, inner_radius: float, outer_radius: float) -> None:
    if not (1 / LARGEST <= outer_radius <= LARGEST and 0 <= inner_radius < outer_radius):
        raise SettingError(
            f"radii of a {what}: expected 0 <= inner < outer (m), got inner {inner_radius} and outer {outer_radius}"
        )


def product(one: ComplexArray | Array, other: ComplexArray | Array) -> ComplexArray:
    """Matrix products (2, 2, …)."""
    return np.asarray(one[:, 0, None] * other[None, 0] + one[:, 1, None] * other[None, 1])


def inverse(matrices: ComplexArray | Array) -> ComplexArray:
    """Inverse matrices (2, 2, …)."""
    (a, b), (c, d) = matrices
    return np.array([[d, -b], [-c, a]]) / (a * d - b * c)
