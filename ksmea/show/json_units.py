"""Record as JSON for people and other programs: every number with its unit, and as texts show it.

The fields of the record stay as they are, so that `from_data` reads it back, and neighbours are added to them:
`floor` (m) has `floor_unit` ("m") and `floor_um`; a value in SI with `unit` and `si_per_unit` is in `in_unit` too. The top of a
file states which of the two holds for its unknowns. Units of fields are in `UNITS`; a field that is not there has no unit, has a
field `unit` beside it, or has it in its name (`seconds`, `reduction_pct`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, is_dataclass
from typing import Any

from ksmea.problem.load import FORCE
from ksmea.records import (
    balancing,
    curves,
    diagnosis,
    estimate,
    identifiability,
    identification,
    location,
    planning,
    trace,
)
from ksmea.records.campaign import RepeatsRecord
from ksmea.records.estimate import StabilityRecord
from ksmea.records.extension import BandRecord, PredictiveGainRecord
from ksmea.records.record import Record
from ksmea.records.weights import InfluenceRecord, VectorRecord, WeightsRecord
from ksmea.units import DEGREE, GRAM_MILLIMETRE, MICROMETRE, RPM

OTHERS = "other numbers have theirs beside them (`floor_unit`) or in their name (`floor_um`), or have none"
IN_SI = f"values of unknowns are in SI, and under `in_unit` in their `unit`; {OTHERS}"
BESIDE_UNIT = f"values of unknowns are in the `unit` beside them; {OTHERS}"

PAIR = 2  # numbers up to which a list is told in the units of texts too; curves are not


def with_units(record: Record) -> dict[str, Any]:
    """Data of `record.shown_data()` with units, preceded by how they are given; unchanged if no unit is known.

    >>> from ksmea.records.estimate import NoiseLevelRecord
    >>> with_units(NoiseLevelRecord(0.05, 2e-8))["floor_um"]
    0.02
    """
    data: dict[str, Any] = record.shown_data()
    labelled = _labelled(record, data)
    is_si = any(type(each) in IN_UNIT for each in getattr(record, "parameters", ()))
    return data if labelled == data else {"units": IN_SI if is_si else BESIDE_UNIT, **labelled}


def _labelled(value: Any, data: Any) -> Any:
    """JSON data of a value, with the neighbours of every field in it that is a record."""
    if isinstance(value, Mapping) and isinstance(data, dict):
        return {name: _labelled(value.get(name), part) for name, part in data.items()}
    if isinstance(value, tuple) and isinstance(data, (list, tuple)):
        return [_labelled(*each) for each in zip(value, data)] if any(map(is_dataclass, value)) else data
    if not is_dataclass(value) or not isinstance(data, dict):
        return data
    found: dict[str, Any] = {}
    for name, part in data.items():
        found[name] = _labelled(getattr(value, name, None), part)
        if part not in (None, [], ()) and (quantity := _quantity(value, name)) is not None:
            found[f"{name}_unit"] = quantity.unit
            if quantity.shown and (shown := _in_unit(part, quantity.size)) is not None:
                found[f"{name}_{quantity.shown}"] = shown
        if status := STATUS.get((type(value), name)):
            found[f"{name}_status"] = status(value)
    if names := IN_UNIT.get(type(value), ()):
        found["in_unit"] = {name: _in_unit(getattr(value, name), data["si_per_unit"]) for name in names}
    return found


def _quantity(record: Any, name: str) -> Quantity | None:
    rule = UNITS.get(type(record), {}).get(name)
    return rule if rule is None or isinstance(rule, Quantity) else rule(record)


def _in_unit(value: Any, size: float) -> Any:
    """A number, or one of a pair, in a unit of this size in SI; None of what is neither."""
    if isinstance(value, (list, tuple)):
        parts = [_in_unit(each, size) for each in value] if 0 < len(value) <= PAIR else [None]
        return None if None in parts else parts
    return None if value is None or isinstance(value, (bool, str)) else value / size


@dataclass(frozen=True)
class Quantity:
    """The unit of a number, and what texts show it in: the end of a name (`um` in `floor_um`) and its size in that unit."""

    unit: str
    shown: str = ""
    size: float = 1.0


LENGTH, TIME, WORK, STIFFNESS = Quantity("m"), Quantity("s"), Quantity("J"), Quantity("N/m")
VIBRATION = Quantity("m", "um", MICROMETRE)
SPEED = Quantity("rad/s", "rpm", RPM)
ANGLE = Quantity("rad", "deg", DEGREE)
UNBALANCE = Quantity("kg m", "g_mm", GRAM_MILLIMETRE)
PART = Quantity("1", "pct", 0.01)
OF_NOISE = Quantity("standard deviations of the noise")
OF_UNKNOWNS = Quantity("SI")  # a number for each unknown: divided by its `si_per_unit` it is in its `unit`
OF_TARGET = Quantity("SI, of the target")  # a number for each candidate
MICROMETRES, GRAM_MILLIMETRES, DEGREES = Quantity("µm"), Quantity("g mm"), Quantity("deg")

QuantityRule = Quantity | Callable[[Any], Quantity | None]


def _of_variation(record: Any) -> Quantity | None:
    return {"band": SPEED, "position": LENGTH}.get(record.variation)


def _of_law(record: Any) -> Quantity:
    return Quantity("N" if record.kind == FORCE else "N m")


def _each(names: str, rule: QuantityRule) -> dict[str, QuantityRule]:
    return dict.fromkeys(names.split(), rule)


def _of_run_time(record: Any) -> Quantity | None:
    """None where the runs are counted, since no time is known."""
    is_counted = record.run_time == tuple(range(len(record.run_time)))
    return None if is_counted else TIME


NOISE = {"relative": PART, "floor": VIBRATION, "by_run": Quantity("name, part, m")}
ADDED = {"speed": SPEED, "position": LENGTH, "magnitude": UNBALANCE, "phase": ANGLE}

UNITS: Mapping[type, Mapping[str, QuantityRule]] = {
    # estimates, noise, curves
    estimate.NoiseLevelRecord: NOISE,
    identification.NoiseLevel: NOISE,
    RepeatsRecord: {"relative": PART, "floor": VIBRATION},
    PredictiveGainRecord: _each("rmse_before rmse_after", VIBRATION),
    StabilityRecord: _each("threshold low high measured searched", SPEED),
    curves.Polar: {"amplitude": VIBRATION, "phase": ANGLE},
    curves.FineCurve: {"speed": SPEED, "amplitude": VIBRATION, "phase": ANGLE},
    curves.FitCurves: {"speed": SPEED, "sd": VIBRATION},
    curves.ResponseCurves: {"speed": SPEED, **_each("measured identified predicted modelled true", VIBRATION)},
    BandRecord: _each("value low high", VIBRATION),
    # diagnosis
    diagnosis.FitQualityRecord: {"band": SPEED},
    diagnosis.CurvesRecord: {"speed": SPEED},
    diagnosis.ResponsesRecord: _each("measured before after", VIBRATION),
    diagnosis.ResidualsRecord: _each("before after", OF_NOISE),
    # location
    location.SiteRecord: _each("position second", LENGTH),
    location.ForceRecord: {**_each("position second", LENGTH), "work": WORK},
    location.StiffnessRecord: _each("real imaginary", STIFFNESS),
    location.LawRecord: {"position": LENGTH, **_each("amplitude amplitude_sd", _of_law)},
    location.LocationRecord: {"speed": SPEED, "work": WORK, **_each("shaft landmarks planes", LENGTH)},
    # identification
    identification.SearchStageRecord: {"x": OF_UNKNOWNS},
    identification.UpdateRecord: {"x": OF_UNKNOWNS, "sdf": VIBRATION},
    identification.Seconds: _each("model surrogate search total", TIME),
    identification.DataDescription: _each("speed_from speed_to", SPEED),
    trace.StageRecord: {"x": OF_UNKNOWNS},
    trace.TraceRecord: {"x": OF_UNKNOWNS},
    VectorRecord: {
        "position": LENGTH,
        **_each("x y size size_low size_high", UNBALANCE),
        **_each("angle angle_low angle_high", ANGLE),
    },
    InfluenceRecord: {
        "position": LENGTH,
        **_each("amplitude amplitude_sd", Quantity("m/(kg m)")),
        **_each("phase phase_sd", ANGLE),
    },
    WeightsRecord: {"speed": SPEED, **_each("before after", VIBRATION)},
    # before anything is measured
    identifiability.DataDescription: {
        **_each("speed_from speed_to", SPEED),
        "positions": LENGTH,
        "relative": PART,
        "floor": VIBRATION,
    },
    identifiability.Direction: {"crlb": PART},
    identifiability.Variation: {"value": _of_variation, "crlb": OF_UNKNOWNS},
    planning.Candidates: {**ADDED, "crlb": OF_TARGET},
    planning.Step: {**ADDED, **_each("crlb unplanned_crlb", OF_UNKNOWNS)},
    planning.PlanningRecord: {**_each("speed_from speed_to", SPEED), "crlb": OF_UNKNOWNS},
    # balancing
    balancing.PolarRecord: _each("angle angle_low angle_high", DEGREES),  # sizes: beside it
    balancing.EntryRecord: {"speed": SPEED},
    balancing.PlaneRecord: {"position": LENGTH, "coefficients": Quantity("µm/(g mm)")},
    balancing.WeightRecord: {"position": LENGTH, **_each("weight known", GRAM_MILLIMETRES)},
    balancing.EntryMisfitRecord: _each("measured expected", MICROMETRES),
    balancing.SpreadRecord: _each("spread drift repeats", MICROMETRES),
    balancing.DriftRecord: _each("real imaginary", MICROMETRES),
    balancing.CorrectionRecord: {"position": LENGTH, "weight": GRAM_MILLIMETRES, **_each("bare left", MICROMETRES)},
    balancing.LeftOutRecord: {**_each("rms_size mean_size least_of_angle", GRAM_MILLIMETRES), "mean_angle": DEGREES},
    balancing.BalanceRecord: {
        "bare": MICROMETRES,
        "growth_scale": GRAM_MILLIMETRES,
        **_each("time_constant run_time", _of_run_time),
    },
}

# Fields in SI beside `unit` and `si_per_unit`, which are told in that unit too.
IN_UNIT: Mapping[type, tuple[str, ...]] = {
    identification.ParameterRecord: ("value", "low", "high", "identified", "most_likely", "crlb", "true"),
    identifiability.Unknown: ("true", "lower", "upper", "crlb"),
    planning.Unknown: ("true", "range_sd"),
}


def _law_status(record: location.LocationRecord) -> str:
    """What null stands for: laws are sought where some place explains the data and, in a diagnosis, no effect does."""
    return "found" if record.law else "none holds" if record.laws else "not sought"


# Fields of which null alone would not say why there is nothing.
STATUS: Mapping[tuple[type, str], Callable[[Any], str]] = {(location.LocationRecord, "law"): _law_status}
