"""An unknown with its interval as records have it."""

from __future__ import annotations

from ksmea.intervals import Interval
from ksmea.parameters import Parameter
from ksmea.records.estimate import EstimateRecord
from ksmea.records.record import finite

AT_LIMIT = 1e-3  # parts of the range within which a value lies on its limit


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
