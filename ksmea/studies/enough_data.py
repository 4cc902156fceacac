"""Whether there are enough data for the unknowns: real numbers measured against unknowns.

Records of estimates.
"""

from __future__ import annotations

import numpy as np

from ksmea.errors import SettingError
from ksmea.inference.intervals import Interval
from ksmea.measurement.measurement import Layout, Measurement
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.measurement.speeds import COMMON_SPEED, equal_speeds
from ksmea.problem.parameters import Parameter
from ksmea.records.estimate import EstimateRecord, NoiseLevelRecord
from ksmea.records.record import finite

N_NOISE = 2  # unknowns of a noise that is estimated along: its relative part and its floor
TO_TEST = 2  # real data per unknown below which the fit is not tested: it follows whatever was measured


def n_real(layout: Layout) -> int:
    """Measured real numbers: one for an amplitude, two for an amplitude and its phase.

    Differences between runs count one run less."""
    is_by_differences = layout.campaign is not None and layout.campaign.reference
    n_cancelled = len(equal_speeds(layout.speed, COMMON_SPEED)) if is_by_differences else 0
    return (len(layout.speed) - n_cancelled) * len(layout.channels) * Observable(layout.kind).dimensions


def n_noise(layout: Layout, *, with_noise: bool) -> int:
    """Unknowns of the noise, of each run that has its own; none where it is not estimated."""
    return N_NOISE * len(layout.noise_rows) if with_noise else 0


def require_enough(layout: Layout, n_unknown: int, *, with_noise: bool) -> None:
    """Raise `SettingError` for fewer real data than numbers sought: infinitely many answers fit them."""
    found, needed = n_real(layout), n_unknown + n_noise(layout, with_noise=with_noise)
    if found >= needed:
        return
    n_speed, n_channel = len(layout.speed), len(layout.channels)
    said = f"{n_speed} speed{_s(n_speed)} × {n_channel} channel{_s(n_channel)}"
    said += " × amplitude and phase" if Observable(layout.kind) is Observable.COMPLEX else ""
    noise = f" and {needed - n_unknown} of the noise" if with_noise else ""
    remedy = ", or state the noise (sigma_um)" if with_noise else ""
    raise SettingError(
        f"{layout.source}: expected at least {needed} data for {n_unknown} unknown{_s(n_unknown)}{noise}, got {found}"
        f" ({said}); measure more speeds or channels{remedy}"
    )


def can_be_tested(layout: Layout, n_unknown: int, *, with_noise: bool) -> bool:
    """Whether there are enough data for a wrong model to show in the residuals."""
    return n_real(layout) >= TO_TEST * (n_unknown + n_noise(layout, with_noise=with_noise))


def _s(count: int) -> str:
    return "" if count == 1 else "s"


AT_LIMIT, REACHED = 1e-3, 1e-6  # parts of the range within which a value lies on its limit, and an interval ends there


def noise_record(noise: Noise, measurement: Measurement) -> NoiseLevelRecord:
    """The noise of a fit to a measurement."""
    return NoiseLevelRecord(float(np.median(noise.relative)), float(np.median(noise.floor)), measurement.by_run(noise))


def estimate_record(parameter: Parameter, value: float, interval: Interval) -> EstimateRecord:
    """A value with its interval (both SI) in the parameter's unit.

    An angle that may be any between −180° and 180°. A value near a limit of a wide range is not at it if its interval
    ends before.
    """
    turn = value - parameter.turned(value)
    width = parameter.upper - parameter.lower
    sides = (
        (value - parameter.lower, interval.low - parameter.lower),
        (parameter.upper - value, parameter.upper - interval.high),
    )
    return EstimateRecord(
        name=parameter.name,
        unit=parameter.unit,
        value=(value - turn) / parameter.si_per_unit,
        low=finite((interval.low - turn) / parameter.si_per_unit),
        high=finite((interval.high - turn) / parameter.si_per_unit),
        interval=interval.basis,
        at_limit=any(bool(near <= AT_LIMIT * width and end <= REACHED * width) for near, end in sides),
    )
