"""Search limits of unknowns, given in engineering units, made into parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ksmea.errors import SettingError, unknown
from ksmea.parameters import Parameter
from ksmea.units import GRAM_MILLIMETRE, KILONEWTON_SECOND_PER_METRE, MEGANEWTON_PER_METRE

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
    """One parameter per name in `units`, in that order; a name that is not in `limits` has its default limits."""
    for name in limits:
        if name not in units:
            raise unknown("name in limits:", name, units)
    return [_parameter(name, *units[name], limits.get(name, defaults[name])) for name in units]


def _parameter(name: str, unit: str, si_per_unit: float, limits: Sequence[float]) -> Parameter:
    if len(limits) != 2:
        raise SettingError(f"limits of {name}: expected [lower, upper] in {unit}, got {list(limits)}")
    return Parameter(name, unit, si_per_unit, limits[0] * si_per_unit, limits[1] * si_per_unit)
