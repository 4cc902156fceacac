"""An unknown with its interval, and the noise, as records have them."""

from __future__ import annotations

import numpy as np

from ksmea.intervals import Interval
from ksmea.measurement import Measurement, Noise
from ksmea.parameters import Parameter
from ksmea.records.estimate import EstimateRecord, NoiseLevelRecord
from ksmea.records.record import finite

AT_LIMIT = 1e-3  # parts of the range within which a value lies on its limit


def noise_record(noise: Noise, measurement: Measurement) -> NoiseLevelRecord:
    """The noise of a fit to a measurement."""
    return NoiseLevelRecord(float(np.median(noise.relative)), float(np.median(noise.floor)), measurement.by_run(noise))


def estimate_record(parameter: Parameter, value: float, interval: Interval) -> EstimateRecord:
    """A value with its interval (both SI) in the parameter's unit; an angle that may be any between −180° and 180°."""
    turn = value - parameter.turned(value)
    near = AT_LIMIT * (parameter.upper - parameter.lower)
    return EstimateRecord(
        name=parameter.name,
        unit=parameter.unit,
        value=(value - turn) / parameter.si_per_unit,
        low=finite((interval.low - turn) / parameter.si_per_unit),
        high=finite((interval.high - turn) / parameter.si_per_unit),
        interval=interval.kind,
        at_limit=bool(min(value - parameter.lower, parameter.upper - value) <= near),
    )
