"""The layout of a rotor for drawings: its sections, disks, bearings, unbalance and probes.

A disk is known by its mass and inertias alone. The ring on its shaft that has the same ones (`Disk.from_geometry`) has
r_o² = 2I_p/m − r_i² and h² = 12(I_d − I_p/2)/m, which is the disk itself where it was given as a ring that sits on the shaft.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.channel import Channel
from ksmea.rotordynamics.layout import BearingPlace, DiskOutline, EffectMark, RotorLayout, ShaftSection, UnbalanceMark
from problems.rotor.finite_elements.data import SAME_PLACE, Disk, Rotor
from problems.rotor.free_motion.support import Support


def layout_of(
    rotor: Rotor,
    channels: Sequence[Channel],
    stiffness: Array,
    damping: Array,
    supports: Sequence[Support] = (),
    effects: Sequence[EffectMark] = (),
) -> RotorLayout:
    """The layout of a rotor whose bearings have coefficients (n_bearing, 2, 2), N/m and N s/m."""
    ends = np.cumsum([0.0, *(segment.length for segment in rotor.segments)]).tolist()
    sections = tuple(
        ShaftSection(start, end, segment.outer_radius, segment.inner_radius)
        for start, end, segment in zip(ends, ends[1:], rotor.segments)
    )
    shaft_mass = sum(each.length * each.area * each.material.density for each in rotor.segments)
    return RotorLayout(
        sections,
        tuple(_outline(disk, sections, SAME_PLACE * rotor.length) for disk in rotor.disks),
        tuple(BearingPlace(bearing.position, *parts) for bearing, *parts in zip(rotor.bearings, stiffness, damping)),
        tuple(UnbalanceMark(plane.position, plane.magnitude, plane.phase) for plane in rotor.unbalance),
        tuple(channels),
        rotor.node_positions,
        shaft_mass + sum(disk.mass for disk in rotor.disks),
        "; ".join(map(_in_words, supports)),
        tuple(effects),
    )


def _outline(disk: Disk, sections: Sequence[ShaftSection], tolerance: float) -> DiskOutline:
    touching = [
        each.outer_radius for each in sections if each.start - tolerance <= disk.position <= each.end + tolerance
    ]
    bore = max(touching)
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
