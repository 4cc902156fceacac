"""The layout of a rotor for drawings: its sections, disks, bearings, unbalance and probes.

A disk is known by its mass and inertias alone. The ring on its shaft that has the same ones (`Disk.from_geometry`) has
r_o² = 2I_p/m − r_i² and h² = 12(I_d − I_p/2)/m, which is the disk itself where it was given as a ring that sits on the shaft.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.channel import Channel
from ksmea.rotordynamics.layout import BearingPlace, DiskOutline, EffectMark, RotorLayout, ShaftSection, UnbalanceMark
from problems.rotor.finite_elements.bearing import Support
from problems.rotor.finite_elements.data import SAME_PLACE, Rotor
from problems.rotor.finite_elements.segments import CouplingSegment, Disk, Layer, Segment, ShaftSegment


def layout_of(
    rotor: Rotor,
    channels: Sequence[Channel],
    stiffness: Array,
    damping: Array,
    supports: Sequence[Support] = (),
    effects: Sequence[EffectMark] = (),
) -> RotorLayout:
    """The layout of a rotor whose bearings and seals have coefficients (n_supported, 2, 2), N/m and N s/m."""
    ends = np.cumsum([0.0, *(segment.length for segment in rotor.segments)]).tolist()
    spans = list(zip(ends, ends[1:], rotor.segments))
    sections = tuple(_section(start, end, segment) for start, end, segment in spans)
    tolerance, n_bearing = SAME_PLACE * rotor.length, len(rotor.bearings)
    places = tuple(
        BearingPlace(bearing.position, k, c, bearing.pedestal is not None)
        for bearing, k, c in zip(rotor.supported, stiffness, damping)
    )
    return RotorLayout(
        sections,
        tuple(_outline(disk, sections, tolerance) for disk in rotor.disks),
        places[:n_bearing],
        tuple(UnbalanceMark(plane.position, plane.magnitude, plane.phase) for plane in rotor.unbalance),
        tuple(channels),
        rotor.node_positions,
        rotor.mass,
        "; ".join(map(_in_words, supports)),
        tuple(effects),
        tuple(_ring(start, end, layer) for start, end, segment in spans for layer in segment.layers),
        places[n_bearing:],
        tuple(_outline(each, sections, tolerance) for each in rotor.masses),
        rotor.couplings,
        tuple(map(rotor.housing_of, channels)),
    )


def _section(start: float, end: float, segment: Segment) -> ShaftSection:
    if isinstance(segment, CouplingSegment):
        return ShaftSection(start, end, segment.outer_radius, 0.0, kind="coupling")
    return _ring(start, end, segment)


def _ring(start: float, end: float, ring: ShaftSegment | Layer) -> ShaftSection:
    kind: Literal["layer", "shaft"] = "layer" if isinstance(ring, Layer) else "shaft"
    radii = ring.outer_radius, ring.inner_radius, ring.outer_radius_right, ring.inner_radius_right
    return ShaftSection(start, end, *radii, kind)


def _outline(disk: Disk, sections: Sequence[ShaftSection], tolerance: float) -> DiskOutline:
    touching = [
        each.largest_radius for each in sections if each.start - tolerance <= disk.position <= each.end + tolerance
    ]
    bore = max(touching)
    if not disk.mass:
        return DiskOutline(disk.position, 0.0, disk.polar_inertia, disk.diametral_inertia, bore, None, 0.0)
    outer_squared = 2 * disk.polar_inertia / disk.mass - bore**2
    thickness_squared = 12 * (disk.diametral_inertia - disk.polar_inertia / 2) / disk.mass
    return DiskOutline(
        position=disk.position,
        mass=disk.mass,
        polar_inertia=disk.polar_inertia,
        diametral_inertia=disk.diametral_inertia,
        bore_radius=bore,
        outer_radius=float(np.sqrt(outer_squared)) if outer_squared > bore**2 else None,
        thickness=float(np.sqrt(max(thickness_squared, 0.0))),
    )


def _in_words(support: Support) -> str:
    what = "all bearings stand on one support" if support.is_common else "each bearing stands on a support"
    return (
        f"{what}: {support.mass[0]:.4g} kg, compliance {support.spring[0, 0] * 1e9:.3g} (x) and"
        f" {support.spring[1, 0] * 1e9:.3g} (y) µm/kN"
    )
