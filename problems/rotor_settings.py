"""Settings of rotor problems.

Band of speeds, search limits in engineering units, probes, and the largest model accepted.

A model takes a dynamic stiffness matrix of n_dof = 4 (n_element + 1) rows per speed, and n_dof³ operations to solve it: an input
error in a file must neither fill the memory nor take hours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError, unknown
from ksmea.measurement.channel import Channel, require_direction
from ksmea.problem.parameters import Parameter
from ksmea.units import GRAM_MILLIMETRE, KILONEWTON_SECOND_PER_METRE, MEGANEWTON_PER_METRE
from problems.rotor.finite_elements.mesh import DOF_PER_NODE

FASTEST = 1e7  # in any unit: no shaft turns as fast


def check_band(speed_from: float, speed_to: float, n_speed: int) -> None:
    """Raise `SettingError` if the ends are swapped, or are one while several speeds are requested."""
    if speed_to > FASTEST:
        raise SettingError(f"speed_to: expected at most {FASTEST:g}, got {speed_to:g}; check it and its unit")
    if speed_to < speed_from or (speed_to == speed_from and n_speed > 1):
        raise SettingError(f"speed_to: expected more than speed_from ({speed_from:g}), got {speed_to:g}; swap them")


def band(speed_from: float, speed_to: float, n_speed: int, rad_per_s: float) -> Array:
    """(n_speed,) rad/s, from ends in a unit of `rad_per_s`."""
    return rad_per_s * np.linspace(speed_from, speed_to, n_speed)


Units = Mapping[str, tuple[str, float]]  # of each unknown: the unit people read and its size in SI

FIVE_UNKNOWNS: Units = {  # of the reference paper: two equal bearings and one unbalance
    "kxx": ("MN/m", MEGANEWTON_PER_METRE),
    "kyy": ("MN/m", MEGANEWTON_PER_METRE),
    "cxx": ("kN s/m", KILONEWTON_SECOND_PER_METRE),
    "cyy": ("kN s/m", KILONEWTON_SECOND_PER_METRE),
    "u": ("g mm", GRAM_MILLIMETRE),
}


def limited_parameters(
    units: Units, defaults: Mapping[str, Sequence[float]], limits: Mapping[str, Sequence[float]]
) -> list[Parameter]:
    """One parameter per name in `units`, in that order.

    A name that is not in `limits` has its default limits.
    """
    for name in limits:
        if name not in units:
            raise unknown("name in limits:", name, units)
    return [_parameter(name, *units[name], limits.get(name, defaults[name])) for name in units]


def _parameter(name: str, unit: str, si_per_unit: float, limits: Sequence[float]) -> Parameter:
    if len(limits) != 2:
        raise SettingError(f"limits of {name}: expected [lower, upper] in {unit}, got {list(limits)}")
    return Parameter(name, unit, si_per_unit, limits[0] * si_per_unit, limits[1] * si_per_unit)


def check_probes(sensors: Sequence[float], directions: Sequence[str]) -> None:
    """Raise `SettingError` if a list is empty, holds an entry twice or a direction that is not one."""
    for name, entries in (("sensors", sensors), ("directions", directions)):
        if not entries or len(set(entries)) < len(entries):
            raise SettingError(f"{name}: expected at least one entry and none twice, got {list(entries)}")
    for direction in directions:
        require_direction(direction, "directions")


def channels_of(sensors: Sequence[float], directions: Sequence[str]) -> tuple[Channel, ...]:
    """Every probe (m) in every direction, probe by probe."""
    return tuple(Channel(position, direction) for position in sensors for direction in directions)


MAX_ELEMENTS = 1000  # of a shaft; a detailed turbine model has a hundred
MAX_SPEEDS = 100_000
MAX_SUPPORTS = 200  # bearings, and as many unbalance planes
MAX_THINGS = 1000  # disks, probes, unknowns, materials: of each
MAX_MOTIONS = 10**7  # n_speed n_dof: some 30 s, and 3.5 GB of bands while slopes of a changed shaft are taken
COMPLEX_BYTES, GIGABYTE = 16, 1e9
BYTES_PER_MOTION = 22 * COMPLEX_BYTES  # of a band, by degree of freedom and speed
MAX_RECEPTANCES = (
    2 * 10**7
)  # complex numbers from forces to readings at all speeds: 0.3 GB, of which an update makes copies


def check_size(n_element: int, n_speed: int) -> None:
    """Raise `SettingError` if a model with so many elements and speeds is larger than any use of it.

    The limit is for the banded route, whose cost is proportional to both.
    """
    if n_element > MAX_ELEMENTS:
        raise SettingError(f"mesh: expected at most {MAX_ELEMENTS} elements in all, got {n_element}; take fewer")
    n_dof = DOF_PER_NODE * (max(n_element, 1) + 1)
    most = min(MAX_MOTIONS // n_dof, MAX_SPEEDS)
    if n_speed > most:
        size = n_speed * n_dof * BYTES_PER_MOTION / GIGABYTE
        raise SettingError(
            f"speeds: expected at most {most} with {n_element} elements, got {n_speed} ({size:.1f} GB); take fewer of either"
        )


def check_ports(n_speed: int, *, n_bearing: int, n_plane: int, n_probe: int) -> None:
    """Raise `SettingError` if the motions per force at all speeds would fill the memory."""
    n_port = 2 * n_bearing
    of_speed = (n_port + n_probe) * max(n_port + n_plane, 1)
    most = MAX_RECEPTANCES // max(of_speed, 1)  # of a rotor to draw there are none
    if n_speed > most:
        raise SettingError(
            f"speeds: expected at most {most} with {n_probe} probes, {n_bearing} bearings, {n_plane} planes, got {n_speed}"
            f" ({n_speed * of_speed * COMPLEX_BYTES / GIGABYTE:.1f} GB); take fewer of any"
        )
