"""Parts of a rotor and their positions for a drawing to scale.

SI, positions along the shaft from its left end.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ksmea.arrays import Array
from ksmea.measurement.channel import Channel


@dataclass(frozen=True)
class ShaftSection:
    """A length of shaft, of a layer around it or of a coupling in line, from `start` to `end` (m).

    A cylinder, or a cone whose radii at the right end differ.
    """

    start: float
    end: float
    outer_radius: float  # m
    inner_radius: float  # m
    outer_radius_right: float | None = None  # m; None: as at the left end
    inner_radius_right: float | None = None
    kind: Literal["shaft", "layer", "coupling"] = "shaft"

    @property
    def largest_radius(self) -> float:  # m
        return max(self.outer_radius, self.outer_radius_right or 0.0)


@dataclass(frozen=True)
class DiskOutline:
    """Rigid disk, drawn as the ring on its shaft with the same mass and inertias, if one exists."""

    position: float  # m
    mass: float  # kg
    polar_inertia: float  # kg m²
    diametral_inertia: float  # kg m²
    bore_radius: float  # m, the shaft's
    outer_radius: float | None  # m; None: no ring has its inertias, such as those of a point mass
    thickness: float  # m; 0: a thin disk


@dataclass(frozen=True, eq=False)
class BearingPlace:
    """A bearing or seal with its coefficients at the speed that they are shown for, (2, 2) each."""

    position: float  # m
    stiffness: Array  # N/m
    damping: Array  # N s/m
    has_pedestal: bool = False
    load: float | None = None  # N, static, upwards; None: the bearings do not hold the rotor


@dataclass(frozen=True)
class UnbalanceMark:
    """An unbalance at a position (m): kg m, rad past +x towards +y."""

    position: float
    magnitude: float
    phase: float


@dataclass(frozen=True)
class EffectMark:
    """An effect next to the rotor itself.

    Its location in words, and positions on the shaft (m) if it sits at any.
    """

    name: str
    where: str
    positions: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class RotorLayout:
    """A rotor with what sits on it, what carries it and what looks at it."""

    sections: tuple[ShaftSection, ...]
    disks: tuple[DiskOutline, ...]
    bearings: tuple[BearingPlace, ...]
    unbalance: tuple[UnbalanceMark, ...]
    probes: tuple[Channel, ...]
    node_positions: Array  # (n_node,) m
    mass: float  # kg, of shaft and disks
    support: str = ""  # what carries the bearings, in words; '': rigid ground
    effects: tuple[EffectMark, ...] = ()
    layers: tuple[ShaftSection, ...] = ()  # around the sections
    seals: tuple[BearingPlace, ...] = ()
    masses: tuple[DiskOutline, ...] = ()  # lumped
    couplings: tuple[float, ...] = ()  # places, m
    housings: tuple[int | None, ...] = ()  # of each probe: the bearing or seal, from 0, that carries it; None: ground
    sag: Array | None = None  # (n_node,) m below the line through the outer bearings, under the weight

    @property
    def length(self) -> float:  # m
        return self.sections[-1].end

    @property
    def largest_radius(self) -> float:  # m
        outlines = [section.largest_radius for section in (*self.sections, *self.layers)]
        return max([*outlines, *(disk.outer_radius for disk in self.disks if disk.outer_radius is not None)])

    def shaft_radius(self, position: float) -> float:
        """Outer radius (m) of the shaft at a position (m), the larger one where two sections meet."""
        touching = [each.largest_radius for each in self.sections if each.start <= position <= each.end]
        return max(touching or [self.sections[-1].largest_radius])
