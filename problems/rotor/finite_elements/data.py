"""Rotor as data: its parts and their positions, in SI units, independent of the solver.

Axes: z runs along the shaft from its left end, x and y are the lateral directions, and the shaft turns from x to y.
Disks and bearings sit at nodes of the mesh; unbalance and probes may lie anywhere on the shaft. Matrices over the two lateral axes,
one for each of many sets and speeds, have these axes first: (2, 2, …).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.units import RPM
from problems.rotor.finite_elements.bearing import LARGEST, Bearing
from problems.rotor.finite_elements.segments import Disk, Segment, require_not_negative, require_positive

SAME_PLACE = 1e-9  # of the shaft's length: positions closer than this are one (rounding of summed lengths)
MAX_MESHES = 64  # kept


@dataclass(frozen=True)
class UnbalancePlane:
    """An unbalance m·e at a position on the shaft; at t = 0 it points `phase` past +x towards +y."""

    position: float  # m
    magnitude: float = 0.0  # kg m
    phase: float = 0.0  # rad

    def __post_init__(self) -> None:
        require_not_negative("magnitude of an unbalance", self.magnitude, "kg m")
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
    """Hub that stiffens the shaft beneath it in bending, EI (1 + `stiffening`).

    It has a width about a position.
    """

    position: float  # m
    width: float  # m
    stiffening: float

    def __post_init__(self) -> None:
        require_positive("width of a hub", self.width, "m")
        if not -1 < self.stiffening <= LARGEST:
            raise SettingError(f"stiffening of a hub: expected a number above -1, got {self.stiffening}")


@lru_cache(maxsize=MAX_MESHES)
def _node_positions(segments: tuple[tuple[float, int], ...]) -> Array:
    """Positions of the nodes of segments with these lengths (m) and numbers of elements.

    They are kept: numbers of a rotor that change leave its mesh as it is.
    """
    ends = np.cumsum([0.0] + [length for length, _ in segments])
    inside = [
        np.linspace(start, end, n_element, endpoint=False)
        for start, end, (_, n_element) in zip(ends[:-1], ends[1:], segments, strict=True)
    ]
    found = np.concatenate([*inside, ends[-1:]])
    found.flags.writeable = False
    return found


@dataclass(frozen=True)
class Rotor:
    """Shaft segments from left to right, and what sits on them.

    `internal_damping` (s) of the turning shaft is proportional to its stiffness, C_i = β K_s: it damps motion as the
    shaft sees it (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, section 7.3). `external_damping`
    (N s/m per m of shaft) comes from what surrounds the shaft and stands still, and `axial_force` (N) is a constant
    tension of the whole shaft.
    """

    segments: tuple[Segment, ...]
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
    masses: tuple[Disk, ...] = ()  # lumped, beside the disks

    def __post_init__(self) -> None:
        require_not_negative("internal damping", self.internal_damping, "s")
        require_not_negative("external damping", self.external_damping, "N s/m²")
        if not abs(self.axial_force) <= LARGEST:
            raise SettingError(f"axial force: expected a number in N, got {self.axial_force}")
        if not self.segments:
            raise SettingError("shaft: expected at least one segment, got none")
        for disk in self.disks:
            self.node_at(disk.position, "disk")
        for lumped in self.masses:
            self.node_at(lumped.position, "lumped mass")
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
        """The bearing, by its index in `supported`, whose housing carries a probe.

        None: it is fixed to the ground.
        """
        for probe in self.housing_probes:
            is_there = abs(channel.position - probe.position) <= SAME_PLACE * self.length
            if is_there and probe.direction in (None, channel.direction):
                return probe.bearing
        return None

    def tables_beyond(self, speed: Array) -> tuple[str, ...]:
        """Sentences on tables of bearings, seals and supports that do not reach all of these speeds.

        Speeds are (n,) rad/s; there is a sentence for each range.
        """
        names = [f"{thing} {number}" for thing, number in self._numbered]
        tables = [(name, bearing.table) for name, bearing in zip(names, self.supported)]
        pedestals = ((name, bearing.pedestal) for name, bearing in zip(names, self.supported))
        tables += [(f"support of {name}", each.dynamic_stiffness) for name, each in pedestals if each is not None]
        short: dict[tuple[float, float], list[str]] = {}
        for name, table in tables:
            if table is not None and table.beyond(speed):
                short.setdefault((table.speed[0], table.speed[-1]), []).append(name)
        reached = f"{np.min(speed) / RPM:.5g} to {np.max(speed) / RPM:.5g} rpm"
        return tuple(
            f"{', '.join(names)}: the table from {low / RPM:.5g} to {high / RPM:.5g} rpm does not reach all speeds, {reached}; its values"
            " at the nearest end are taken there"
            for (low, high), names in short.items()
        )

    @property
    def _numbered(self) -> list[tuple[str, int]]:
        """Names and numbers for `supported`, as rotor files count."""
        parts = (("bearing", self.bearings), ("seal", self.seals))
        return [(thing, number) for thing, those in parts for number in range(1, len(those) + 1)]

    @property
    def mass(self) -> float:
        """Mass of all that turns, kg."""
        of_shaft = sum(segment.mass for segment in self.segments)
        return of_shaft + sum(part.mass for part in (*self.disks, *self.masses))

    @cached_property
    def length(self) -> float:  # m
        return sum(segment.length for segment in self.segments)

    @cached_property
    def node_positions(self) -> Array:
        """Positions of the nodes, (n_node,) m."""
        return _node_positions(tuple((segment.length, segment.n_element) for segment in self.segments))

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
