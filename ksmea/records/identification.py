"""The record of an identification.

The values that a method found from one measurement, and all that is known of them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from statistics import NormalDist
from typing import Any, ClassVar, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.notation import Notation
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.records.campaign import BothWaysRecord, RepeatsRecord
from ksmea.records.curves import FitCurves, Matrix, ResponseCurves, check_shape, matrix
from ksmea.records.estimate import NoiseLevelRecord, Shown, StabilityRecord
from ksmea.records.hidden import HiddenEffect
from ksmea.records.in_notation import InNotation, without_default_notation
from ksmea.records.inputs import InputRecord, Origin
from ksmea.records.location import LocationRecord
from ksmea.records.record import renamed
from ksmea.records.trace import TraceRecord
from ksmea.records.weights import WeightsRecord
from ksmea.units import TURN, OfUnknown, Speed, Time, Vibration

# Fields of a parameter that had other names in records before schema 3.
RENAMED = {"at_bound": "at_limit", "bound": "crlb", "interval": "kind", "likely": "most_likely"}
SHORT = 0.1  # parts of an interval's width between a method's value and the maximum, above which its search ended short


@dataclass(frozen=True)
class ParameterRecord:
    """One unknown. All values are SI; divided by `si_per_unit` they are in `unit`, which people read.

    `identified` is where the method's search ended. The interval, the noise and `most_likely` belong to a maximum of the
    likelihood, which may lie elsewhere; `value` is reported together with an interval.
    """

    IN_UNIT: ClassVar = ("value", "low", "high", "identified", "most_likely", "crlb", "true")

    name: str
    unit: str
    si_per_unit: float
    identified: float  # by the method
    at_limit: bool  # whether `value` lies at a search limit, within a thousandth of the range
    true: float | None = None  # None where nobody knows it
    low: float | None = None  # ends of the interval; None where that side is open
    high: float | None = None
    kind: str | None = None  # of the interval (`ksmea.inference.intervals.Interval`); None where there is none
    most_likely: float | None = None  # at the maximum of the likelihood that the interval belongs to
    crlb: float | None = None  # CRLB (1 σ) at the reported values; None where infinite or not computed
    origin: Origin | None = None  # of its uncertainty; None where all numbers of the model are exact

    def in_unit(self, value: float | None) -> float:
        """One of its values in its unit; NaN for None."""
        return np.nan if value is None else value / self.si_per_unit

    @property
    def shown(self) -> Shown:
        return Shown(self.in_unit(self.value), self.in_unit(self.low), self.in_unit(self.high), self.unit)

    @property
    def value(self) -> float:
        """The most likely value where it is known, else the method's."""
        return self.identified if self.most_likely is None else self.most_likely

    @property
    def ended_short(self) -> bool:
        """Whether the method's value is not the one that the interval belongs to."""
        if self.most_likely is None or (self.low is None and self.high is None):
            return False
        ends = [abs(end - self.most_likely) for end in (self.low, self.high) if end is not None]
        return abs(self.identified - self.most_likely) > SHORT * 2 * float(np.mean(ends))

    @property
    def error_pct(self) -> float | None:
        """Deviation from the true value, %; None if the true value is 0 or not known."""
        return 100 * (self.identified / self.true - 1) if self.true else None

    @property
    def is_covered(self) -> bool | None:
        """Whether the interval holds the true value; None if nobody knows that. An open side holds everything."""
        if self.true is None:
            return None
        low = -np.inf if self.low is None else self.low
        high = np.inf if self.high is None else self.high
        return bool(low <= self.true <= high)


@dataclass(frozen=True)
class SearchStageRecord:
    """A part of a search on the surrogate as it ended (`ksmea.plugins.identification.SearchStage`)."""

    name: str
    x: tuple[OfUnknown, ...]  # (d,) SI
    misfit: float | None  # on the surrogate; None where it is not finite


@dataclass(frozen=True)
class UpdateRecord:
    """One updating step (`ksmea.plugins.identification.Update`); None if a number is not finite."""

    x: tuple[OfUnknown, ...]  # (d,) SI, the surrogate's optimum
    predicted_misfit: float | None = None
    misfit: float | None = None
    smc: float | None = None
    sdf: Vibration | None = None
    polish_gain: float | None = None
    search: tuple[SearchStageRecord, ...] = ()  # the optimiser, then the polish; none in older records


@dataclass(frozen=True)
class Seconds:
    """Wall time of the method, s, by part.

    The true model, fits of the surrogate, the search, and all together.
    """

    model: Time = 0.0
    surrogate: Time = 0.0
    search: Time = 0.0
    total: Time = 0.0


@dataclass(frozen=True)
class NoiseLevel(NoiseLevelRecord):
    """Noise that the intervals were made with; root mean squares where each datum or run has its own."""

    estimated: bool = field(kw_only=True)  # from the same data, or known beforehand


@dataclass(frozen=True)
class IntervalEffort:
    """Confidence level of the intervals, their noise, and their evaluations of the true model."""

    level: float
    noise: NoiseLevel
    model_evaluations: int
    model_jacobians: int
    seconds: float


@dataclass(frozen=True)
class LackOfFit:
    """Test of the fit: chance of so large a statistic if the model is right, and whether it is too small."""

    p: float
    statistic: str  # that speaks the most against the fit
    rejected: bool


@dataclass(frozen=True)
class DataDescription:
    """Description of the measurement for reports; speeds in rad/s."""

    source: str
    kind: str  # amplitude or complex
    n_speed: int
    speed_from: Speed
    speed_to: Speed
    channels: tuple[str, ...]
    remarks: tuple[str, ...] = ()
    reference: str = ""  # run from which the others' differences were taken; empty: all data counted
    too_few_to_test: bool = False  # the fit: a model with so many unknowns follows whatever was measured


@dataclass(frozen=True)
class IdentificationRecord(InNotation):
    """Result of a method for one measurement.

    `status` is 'done', or 'budget' if the budget cut it short; `stop` says why it ended
    (`ksmea.plugins.identification.Identification`).
    """

    status: str
    stop: str
    parameters: tuple[ParameterRecord, ...]
    misfit: float | None  # likelihood misfit of what was identified, whatever form the method minimised
    updates: int
    model_evaluations: int
    model_jacobians: int
    surrogate_evaluations: int
    seconds: Seconds
    history: tuple[UpdateRecord, ...] = ()
    notes: dict[str, float | None] = field(default_factory=dict)  # of the surrogate
    remarks: tuple[str, ...] = ()  # of the method, such as that another surrogate took over
    intervals: IntervalEffort | None = None  # None where none were asked for or none could be made
    interval_error: str | None = None  # why none could be made
    deviance: float | None = None  # −2 ln L at the maximum of the likelihood that the intervals belong to
    search_excess: float | None = None  # what it is higher where the method's search ended, at the same noise
    lack_of_fit: LackOfFit | None = None
    correlation: Matrix | None = None  # of the estimates, (d, d); None where the data cannot tell
    data: DataDescription | None = None
    fit: FitCurves | None = None
    curves: ResponseCurves | None = None
    basin_excess: float | None = None  # `deviance` less that of the maximum nearest to the true values
    hidden: tuple[HiddenEffect, ...] = ()  # effects that synthetic data hide
    location: LocationRecord | None = (
        None  # of what the model lacks, and the unknowns beside it; None where not asked for
    )
    repeats: RepeatsRecord | None = None  # of a campaign, with details
    both_ways: BothWaysRecord | None = None  # of a campaign whose runs differ at common speeds
    weights: WeightsRecord | None = None  # of a campaign with weights on the shaft, with details
    stability: StabilityRecord | None = None  # None without details, and where the problem cannot tell
    trace: TraceRecord | None = None  # None in older records
    inputs: tuple[InputRecord, ...] = ()  # numbers that are known to a tolerance; values and intervals allow for these
    notation: Notation = field(default_factory=Notation)  # of the measurement's own file

    def check(self) -> None:
        """Raise `SettingError` if values, updates, correlations or curves do not belong to the parameters."""
        names = [parameter.name for parameter in self.parameters]
        if not names or len(set(names)) < len(names) or not set(names).isdisjoint(("status", "error", "cell", "key")):
            raise SettingError("parameters: expected one or more, each with a name of its own, got others")
        if not all(0 < part.si_per_unit < np.inf for part in self.parameters):
            raise SettingError("parameters: expected units above 0, got another")
        if any(len(update.x) != len(names) for update in self.history):
            raise SettingError("history: expected a value for each parameter, got another number of them")
        check_shape("correlation", self.correlation, len(names), len(names))
        if self.trace is not None:
            self.trace.check(len(names))
        for curves in (self.fit, self.curves):
            if curves is not None:
                curves.check()

    def to_data(self) -> dict[str, Any]:
        return without_default_notation(super().to_data(), self.notation)

    @property
    def x(self) -> Array:
        """Values that the method found (d,) SI."""
        return np.array([parameter.identified for parameter in self.parameters])

    @property
    def values(self) -> Array:
        """Reported values (d,) SI: the most likely ones if they are known, else the method's."""
        return np.array([parameter.value for parameter in self.parameters])

    @property
    def covariance(self) -> Array | None:
        """Covariance (d, d) SI of the estimates, from half the width of their intervals and their correlation.

        None if an interval is open or missing, or the data cannot tell.
        """
        if self.intervals is None or self.correlation is None:
            return None
        ends = [(part.low, part.high) for part in self.parameters if part.low is not None and part.high is not None]
        correlation = np.array(self.correlation, dtype=float)
        if len(ends) < len(self.parameters) or not np.all(np.isfinite(correlation)):
            return None
        half_width = np.array([(high - low) / 2 for low, high in ends])
        sd = half_width / NormalDist().inv_cdf((1 + self.intervals.level) / 2)
        return np.asarray(correlation * np.outer(sd, sd))

    @property
    def stage(self) -> str:
        """The stage of the method that the identified values are of; '' where it tells none."""
        return self.trace.stages[-1].name if self.trace is not None and self.trace.stages else ""

    @property
    def ended_short(self) -> bool:
        """Whether the method stopped elsewhere than at the maximum that intervals and noise belong to.

        Never if that is of a joint fit, since the method took numbers as stated that are not exact.
        """
        return not self.inputs and any(parameter.ended_short for parameter in self.parameters)

    def with_truth(
        self, parameters: Parameters, truth: Mapping[str, float], response: ComplexArray | None = None
    ) -> Self:
        """This record with the true values and curves, if known.

        For an angle that is free to turn, the true value is given in the turn nearest to the identified value.

        Args:
            parameters: unknowns of the problem, in the order of the record.
            truth: true values by name, SI.
            response: response without noise (n_speed, n_channel), m.
        """
        known = tuple(
            dataclasses.replace(part, true=_nearest_turn(parameter, truth.get(part.name), part.identified))
            for parameter, part in zip(parameters, self.parameters, strict=True)
        )
        curves = self.curves
        if curves is not None and response is not None:
            curves = dataclasses.replace(curves, true=matrix(np.abs(response)))
        return dataclasses.replace(self, parameters=known, curves=curves)

    @classmethod
    def upgraded(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        """Rename the fields of parameters that had other names before schema 3, and split `interval`.

        It was then either the present `intervals` or {'error': why intervals are missing}.
        """
        if not any("at_bound" in parameter for parameter in data.get("parameters", ())):
            return data
        parameters = [renamed(parameter, RENAMED) for parameter in data["parameters"]]
        interval = data.get("interval", {})
        error = interval.get("error")
        effort = interval if interval and error is None else None
        return {**data, "parameters": parameters, "intervals": effort, "interval_error": error}


def _nearest_turn(parameter: Parameter, true: float | None, identified: float) -> float | None:
    """True value; of an angle that is free to turn, on the turn nearest to the identified value."""
    if true is None or not parameter.is_full_turn:
        return true
    return true + TURN * round((identified - true) / TURN)
