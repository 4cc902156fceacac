"""Segments of a shaft, their materials, and what sits on it.

Cylinders and cones with layers, couplings in line, disks and lumped masses; SI.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar

from ksmea.errors import SettingError, unknown
from problems.rotor.finite_elements.bearing import LARGEST

CARRIES = ("both", "mass", "stiffness")
COUPLING_UNITS = {
    "stiffness": "N/m",
    "angular_stiffness": "N m/rad",
    "damping": "N s/m",
    "angular_damping": "N m s/rad",
    "masses": "kg",
    "polar_inertias": "kg m²",
    "diametral_inertias": "kg m²",
}


@dataclass(frozen=True)
class Material:
    """An isotropic elastic material."""

    young_modulus: float  # Pa
    density: float  # kg/m³
    poisson_ratio: float

    def __post_init__(self) -> None:
        require_positive("Young's modulus", self.young_modulus, "Pa")
        require_positive("density", self.density, "kg/m³")
        if not -1 < self.poisson_ratio <= 0.5:
            raise SettingError(
                f"Poisson's ratio: expected above -1 and at most 0.5, got {self.poisson_ratio}; steel has 0.3"
            )

    @property
    def shear_modulus(self) -> float:  # Pa
        return self.young_modulus / (2 * (1 + self.poisson_ratio))


@dataclass(frozen=True)
class Layer:
    """A further ring around a shaft segment, over its whole length, which shares the motion of its nodes."""

    outer_radius: float  # m
    material: Material
    inner_radius: float = 0.0  # m
    outer_radius_right: float | None = None  # m, of a cone; None: as at its left end
    inner_radius_right: float | None = None
    carries: str = "both"  # or mass alone, or stiffness alone
    shear_flexibility: float = 1.0

    def __post_init__(self) -> None:
        require_rings("layer", self)
        if self.carries not in CARRIES:
            raise unknown("part that a layer carries", self.carries, CARRIES)


@dataclass(frozen=True)
class ShaftSegment:
    """A length of shaft of circular section, cut into equal elements.

    A cylinder or cone, with or without layers around it.
    """

    length: float  # m
    outer_radius: float  # m
    material: Material
    n_element: int = 1
    inner_radius: float = 0.0  # m
    shear_flexibility: float = 1.0  # of that of Timoshenko's theory; 0: Euler–Bernoulli
    outer_radius_right: float | None = None  # m, of a cone; None: as at its left end
    inner_radius_right: float | None = None
    stiffness_outer_radius: float | None = None  # m; None: stiffness and mass have one
    layers: tuple[Layer, ...] = ()
    shear_coefficient: float | None = None  # None: Cowper's
    rotary_inertia: bool = True
    gyroscopic: bool = True
    axial_force: float = 0.0  # N, tension
    internal_damping: float = 0.0  # s, of the turning shaft in proportion to its stiffness
    loss_factor: float = 0.0  # η of hysteretic damping of the turning shaft
    standing_damping: tuple[float, float] = (0.0, 0.0)  # 1/s and s: in proportion to mass and stiffness, on the ground

    def __post_init__(self) -> None:
        require_positive("length of a shaft segment", self.length, "m")
        require_rings("shaft segment", self)
        require_not_negative("shear flexibility of a shaft segment", self.shear_flexibility, "times Timoshenko's")
        require_not_negative("internal damping of a shaft segment", self.internal_damping, "s")
        if not 0 <= self.loss_factor <= 1:
            raise SettingError(f"loss factor of a shaft segment: expected a number from 0 to 1, got {self.loss_factor}")
        for value, unit in zip(self.standing_damping, ("1/s", "s"), strict=True):
            require_not_negative("standing damping of a shaft segment", value, unit)
        if self.stiffness_outer_radius is not None:
            inner = max(self.inner_radius, self.inner_radius_right or 0.0)
            require_ring("shaft segment's stiffness", inner, self.stiffness_outer_radius)
        if self.shear_coefficient is not None:
            require_positive("shear coefficient of a shaft segment", self.shear_coefficient, "")
        if self.n_element < 1:
            raise SettingError(
                f"elements of a shaft segment: expected at least 1, got {self.n_element}; refine the mesh"
            )

    @property
    def is_cylinder(self) -> bool:
        """Whether one constant ring is all of it."""
        apart = (self.outer_radius_right, self.inner_radius_right, self.stiffness_outer_radius)
        return not self.layers and apart == (None, None, None)

    @property
    def area(self) -> float:  # m², at the left end, without layers
        return math.pi * (self.outer_radius**2 - self.inner_radius**2)

    @property
    def second_moment(self) -> float:
        """Second moment of area about a diameter, m⁴; the polar one is twice as large."""
        return math.pi / 4 * (self.outer_radius**4 - self.inner_radius**4)

    @property
    def mass(self) -> float:  # kg
        if self.is_cylinder:
            return self.material.density * self.area * self.length
        of_layers = (each.material.density * _volume(each) for each in self.layers if each.carries != "stiffness")
        return self.length * (self.material.density * _volume(self) + sum(of_layers))


def _volume(ring: ShaftSegment | Layer) -> float:
    """m³ per m of length."""
    parts = []
    for left, right in (
        (ring.outer_radius, ring.outer_radius_right),
        (ring.inner_radius, ring.inner_radius_right),
    ):
        last = left if right is None else right
        parts.append(math.pi / 3 * (left**2 + left * last + last**2))
    return parts[0] - parts[1]


@dataclass(frozen=True)
class CouplingSegment:
    """Coupling in line: springs and dampers between the two nodes at its ends, and lumped inertias.

    Deflection and rotation each have their own; masses and inertias are lumped at the ends. Pairs are (x, y) or (left,
    right).
    """

    length: float  # m
    stiffness: tuple[float, float]  # N/m
    angular_stiffness: tuple[float, float]  # N m/rad, about x and y
    damping: tuple[float, float] = (0.0, 0.0)  # N s/m
    angular_damping: tuple[float, float] = (0.0, 0.0)  # N m s/rad
    masses: tuple[float, float] = (0.0, 0.0)  # kg
    polar_inertias: tuple[float, float] = (0.0, 0.0)  # kg m²
    diametral_inertias: tuple[float, float] = (0.0, 0.0)  # kg m²
    outer_radius: float = 0.0  # m, for drawings

    n_element: ClassVar[int] = 1

    def __post_init__(self) -> None:
        require_positive("length of a coupling", self.length, "m")
        for name, unit in COUPLING_UNITS.items():
            for value in getattr(self, name):
                require_not_negative(f"{name.replace('_', ' ')} of a coupling", value, unit)

    @property
    def mass(self) -> float:  # kg
        return sum(self.masses)

    @property
    def layers(self) -> tuple[Layer, ...]:
        return ()

    def ends(self) -> tuple[Disk, Disk]:
        """Masses and inertias at its ends."""
        left, right = (
            Disk(0.0, *parts, is_lumped=True)
            for parts in zip(self.masses, self.polar_inertias, self.diametral_inertias, strict=True)
        )
        return left, right


Segment = ShaftSegment | CouplingSegment


@dataclass(frozen=True)
class RingSize:
    """A homogeneous ring: lengths in m, density in kg/m³."""

    outer_radius: float
    inner_radius: float
    thickness: float
    density: float


@dataclass(frozen=True)
class Disk:
    """A rigid disk fixed to a node of the shaft, or a lumped mass, which may have inertias alone.

    With an `offset` it sits off its node, and moves as the shaft there.
    """

    position: float  # m, of its node
    mass: float  # kg
    polar_inertia: float  # kg m², about the shaft
    diametral_inertia: float  # kg m², about a diameter through the centre of mass
    is_lumped: bool = False
    standing_damping: float = 0.0  # 1/s: in proportion to mass and diametral inertia, on the ground
    ring: RingSize | None = None  # that mass and inertias were computed of; None: they are given
    offset: float = 0.0  # m

    def __post_init__(self) -> None:
        if self.is_lumped:
            require_not_negative("lumped mass", self.mass, "kg")
        else:
            require_positive("mass of a disk", self.mass, "kg")
        require_not_negative("standing damping of a disk", self.standing_damping, "1/s")
        require_not_negative("polar inertia of a disk", self.polar_inertia, "kg m²")
        require_not_negative("diametral inertia of a disk", self.diametral_inertia, "kg m²")

    @classmethod
    def from_geometry(
        cls, position: float, *, outer_radius: float, inner_radius: float, thickness: float, density: float
    ) -> Disk:
        """A homogeneous ring, lengths in m and density in kg/m³.

        M = ρπ(r_o² − r_i²)h, I_p = m(r_o² + r_i²)/2, I_d = m(3r_o² + 3r_i² + h²)/12.

        >>> round(Disk.from_geometry(0.2, outer_radius=0.12, inner_radius=0.05, thickness=0.05, density=7800).mass, 3)
        14.58
        """
        require_ring("disk", inner_radius, outer_radius)
        require_positive("thickness of a disk", thickness, "m")
        require_positive("density of a disk", density, "kg/m³")
        mass = density * math.pi * (outer_radius**2 - inner_radius**2) * thickness
        radii_squared = outer_radius**2 + inner_radius**2
        inertias = mass * radii_squared / 2, mass * (3 * radii_squared + thickness**2) / 12
        return cls(position, mass, *inertias, ring=RingSize(outer_radius, inner_radius, thickness, density))

    def resized(self, ring: RingSize) -> Disk:
        """With mass and inertias of another ring."""
        made = Disk.from_geometry(self.position, **dataclasses.asdict(ring))
        return dataclasses.replace(made, standing_damping=self.standing_damping, offset=self.offset)


@dataclass(frozen=True)
class MassChange(Disk):
    """Mass and inertias of a place of the shaft in addition to a drawing, all negative for less."""

    def __post_init__(self) -> None:
        for name in ("mass", "polar_inertia", "diametral_inertia"):
            if not abs(getattr(self, name)) <= LARGEST:
                raise SettingError(f"{name.replace('_', ' ')}: expected a number, got {getattr(self, name)}")


def require_positive(what: str, value: float, unit: str) -> None:
    if not 1 / LARGEST <= value <= LARGEST:
        raise SettingError(f"{what}: expected a number above 0 {unit}, got {value}")


def require_not_negative(what: str, value: float, unit: str) -> None:
    if not 0 <= value <= LARGEST:
        raise SettingError(f"{what}: expected a number of at least 0 {unit}, got {value}")


def require_rings(what: str, ring: ShaftSegment | Layer) -> None:
    require_ring(what, ring.inner_radius, ring.outer_radius)
    if (ring.outer_radius_right, ring.inner_radius_right) != (None, None):
        inner, outer = (
            left if right is None else right
            for left, right in (
                (ring.inner_radius, ring.inner_radius_right),
                (ring.outer_radius, ring.outer_radius_right),
            )
        )
        require_ring(f"{what}'s right end", inner, outer)


def require_ring(what: str, inner_radius: float, outer_radius: float) -> None:
    if not (1 / LARGEST <= outer_radius <= LARGEST and 0 <= inner_radius < outer_radius):
        raise SettingError(
            f"radii of a {what}: expected 0 <= inner < outer (m), got inner {inner_radius} and outer {outer_radius}"
        )
