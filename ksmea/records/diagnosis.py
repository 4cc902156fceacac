"""Record of a diagnosis: errors of a model, the cause that explains them, and the evidence.

Values of unknowns are in the unit given with them, speeds in rad/s and lengths in m. `before` is the baseline model,
`after` the model extended by the effects in `applied`; None without an extended model. Names of fields in records of
earlier versions are translated when they are read.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from ksmea.measurement.notation import Notation
from ksmea.records.campaign import BothWaysRecord, RepeatsRecord
from ksmea.records.curves import FineCurve, check_shape
from ksmea.records.estimate import EstimateRecord, NoiseLevelRecord, StabilityRecord
from ksmea.records.extension import (
    AveragedRecord,
    BandRecord,
    EffectRecord,
    ElpdDifference,
    ExplanationRecord,
    PredictiveGainRecord,
)
from ksmea.records.hidden import HiddenEffect
from ksmea.records.in_notation import InNotation
from ksmea.records.inputs import InputRecord
from ksmea.records.location import LocationRecord
from ksmea.records.record import Record
from ksmea.units import VIBRATION, Quantity, Speed

OF_NOISE = Quantity("standard deviations of the noise")

Values = tuple[tuple[float | tuple[float, float], ...], ...]  # (n_speed, n_channel), complex as (real, imaginary)


@dataclass(frozen=True)
class TrialRecord(Record):
    """One effect at one location, fitted jointly with all unknowns."""

    effect: str
    location: str
    deviance_drop: float  # against the baseline model
    delta_bic: float  # above 0: evidence for the effect
    p: float  # of as large a drop where the effect is absent, corrected for the number of candidates
    parameters: tuple[EstimateRecord, ...]  # the effect's own
    words: str = ""  # the effect as a noun; '' in older records


@dataclass(frozen=True)
class FitQualityRecord(Record):
    """The lack-of-fit test of one fit, and where most of its misfit sits."""

    p: float
    p_by_statistic: Mapping[str, float]
    statistic: str  # the one with the smallest p
    reduced_chi2: float
    band: tuple[Speed, Speed]
    channel: str
    excess: float  # mean square in that band and channel relative to that of all residuals
    whirl: Mapping[str, tuple[float, float]]  # by position in m: mean squares of forward and backward residuals
    deviance: float | None = None  # of the fit; None in older records


@dataclass(frozen=True)
class LackOfFitRecord(Record):
    before: FitQualityRecord
    after: FitQualityRecord | None
    level: float  # p below which a model is rejected


@dataclass(frozen=True)
class NoiseRecord(Record):
    known: bool
    by_datum: bool  # a known standard deviation datum by datum
    before: NoiseLevelRecord
    after: NoiseLevelRecord | None


@dataclass(frozen=True)
class CoefficientRecord(Record):
    """An unknown in both models; unknowns of effects have no `before`."""

    name: str
    before: EstimateRecord | None
    after: EstimateRecord | None


@dataclass(frozen=True)
class DetectableRecord(Record):
    """The smallest size of one unknown of an effect that would be detected in nine of ten cases."""

    location: str
    parameter: str
    unit: str
    size: float | None  # None: none would
    largest: float  # that is physical, and leaves the rotor stable at the measured speeds
    observable: bool  # size is below largest


MAX_SPLIT = 6  # explanations that a further measurement is sought for, the best first


@dataclass(frozen=True)
class SplitRecord(Record):
    """Further measurement that separates explanations, with the expected deviance difference.

    The difference is between the least separated two of these explanations, now and with the measurement.
    """

    measurement: str
    now: float
    then: float
    together: tuple[tuple[str, str], ...] = ()  # pairs of explanations that it does not tell apart
    run: str = ""  # a further run with a weight as `measurement.runs` has it; '': it is another measurement


@dataclass(frozen=True)
class ResponsesRecord(Record):
    """m"""

    measured: Annotated[Values, VIBRATION]
    before: Annotated[Values, VIBRATION]
    after: Annotated[Values | None, VIBRATION] = None


@dataclass(frozen=True)
class ResidualsRecord(Record):
    """In units of the noise."""

    before: Annotated[Values, OF_NOISE]
    after: Annotated[Values | None, OF_NOISE] = None


@dataclass(frozen=True)
class CurvesRecord(Record):
    """Curves for figures, to five digits.

    `breaks` are the indices at which the speeds of a further run begin.
    """

    speed: tuple[Speed, ...]
    channels: tuple[str, ...]
    responses: ResponsesRecord
    residuals: ResidualsRecord
    breaks: tuple[int, ...] = ()
    averaged: BandRecord | None = None  # None where nothing is averaged, and in older records
    fine_before: FineCurve | None = None  # the models at more speeds, where they were wanted
    fine_after: FineCurve | None = None

    def check(self) -> None:
        """Raise `SettingError` where a curve is not as long as its speeds, or not of each channel."""
        for curve in (self.fine_before, self.fine_after):
            if curve is not None:
                check_shape("curves.fine.amplitude", curve.amplitude, len(curve.speed), len(self.channels))
                check_shape("curves.fine.phase", curve.phase, len(curve.speed), len(self.channels))


@dataclass(frozen=True)
class DiagnosisRecord(InNotation):
    """A diagnosis (ksmea.diagnosis.diagnosis.Diagnosis says what its parts mean) as plain data.

    `hidden`, `hidden_deviance_drop` and `seconds` belong to a benchmark: what synthetic data hide is added once the
    diagnosis has been made without it. The drop is from the baseline model to the fit started from the true values.
    """

    verdict: str  # adequate, not observable, named, ambiguous, located, unknown or misread
    named: tuple[str, ...]
    ambiguity_group: tuple[str, ...]  # the named effects and those that explain the data about as well
    locations: tuple[str, ...]  # where the best effect explains the data about as well
    applied: tuple[EffectRecord, ...]
    ranking: tuple[TrialRecord, ...]  # highest ΔBIC first
    lack_of_fit: LackOfFitRecord
    noise: NoiseRecord
    coefficients: tuple[CoefficientRecord, ...]
    predictive_gain: PredictiveGainRecord | None
    min_detectable: Mapping[str, tuple[DetectableRecord, ...]]  # by effect
    split: SplitRecord | None
    collinearity: Mapping[str, float]  # of each other effect with the best one, 0 to 1
    aliases: Mapping[str, str]  # effects that can look like those in `applied`, and what would tell
    effects: tuple[str, ...]  # names of all that were fitted
    curves: CurvesRecord | None = None
    hidden: tuple[HiddenEffect, ...] = ()
    hidden_deviance_drop: float | None = None
    seconds: float | None = None  # of a core
    left_out: Mapping[str, str] = field(default_factory=dict)  # effects that were not fitted, and why
    source: str = ""  # of the measurement; older records do not say
    remarks: tuple[str, ...] = ()  # on the data: what was left out of them, and what looks like a slip
    repeats: RepeatsRecord | None = None  # of a campaign
    both_ways: BothWaysRecord | None = None  # of a campaign whose runs differ at common speeds
    stability: StabilityRecord | None = None  # of the model that is believed; None in older records
    location: LocationRecord | None = (
        None  # without the library; None where the model is adequate or the data are too few
    )
    explanations: tuple[
        ExplanationRecord, ...
    ] = ()  # the best one and those as near; none where none is believed, or older
    averaged: AveragedRecord | None = None  # over these, where there are several and an average is wanted
    inputs: tuple[InputRecord, ...] = ()  # numbers known to a tolerance, by the model that is believed
    notation: Notation = field(default_factory=Notation)  # of the measurement's own file
    reading: str = ""  # where the verdict is misread: how the data look to have been given, and what mends it; all else is of data read so
    is_split_sought: bool = True  # whether a measurement that would tell them apart is wanted

    @classmethod
    def upgraded(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        if not is_older(data):
            return data
        data = renamed(data)
        if (gain := data["predictive_gain"]) is not None:  # earlier ones had no tests of the blocks
            elpd = ElpdDifference(np.array(gain["by_block"], dtype=float))
            gain = PredictiveGainRecord.of(elpd, gain["rmse_before"], gain["rmse_after"]).to_data()
        return {**data, "predictive_gain": gain}

    def shown_data(self) -> dict[str, Any]:
        data = self.to_data()
        return data if self.location is None else data | {"location": self.location.shown_data()}

    @property
    def is_rejected(self) -> bool:
        """Whether the model as given is."""
        return self.verdict not in ("adequate", "not observable", "misread")

    @property
    def is_explained(self) -> bool:
        """Whether the extended model is accepted."""
        return self.verdict in ("named", "ambiguous")

    @property
    def is_unexplained(self) -> bool:
        """Whether neither the model as given nor one with effects is accepted."""
        return self.is_rejected and not self.is_explained


FIELDS = {  # at any depth of a record
    "class": "ambiguity_group",
    "places": "locations",
    "place": "location",
    "gain": "predictive_gain",
    "likeness": "collinearity",
    "tried": "effects",
    "fall": "deviance_drop",
    "hidden_fall": "hidden_deviance_drop",
    "at_bound": "at_limit",
    "log_score": "elpd_difference",
}
STATISTICS = {
    "neighbours": "autocorrelation over speed",
    "channels together": "cross-channel correlation",
    "largest": "largest residual",
    "level": "χ²",
}
VERBATIM = ("settings", "curves")  # what holds no names of these


def is_older(data: Mapping[str, Any]) -> bool:
    return "class" in data


def renamed(data: Mapping[str, Any]) -> dict[str, Any]:
    """Older data with the present names of fields and statistics."""
    found: dict[str, Any] = _renamed(data)
    tests = found["lack_of_fit"]
    for when in ("before", "after"):
        if tests[when] is not None:
            tests[when] = _with_statistics(tests[when])
    return found


def _renamed(data: Any) -> Any:
    if isinstance(data, Mapping):
        return {FIELDS.get(name, name): value if name in VERBATIM else _renamed(value) for name, value in data.items()}
    return [_renamed(value) for value in data] if isinstance(data, list) else data


def _with_statistics(test: Mapping[str, Any]) -> dict[str, Any]:
    by_statistic = {STATISTICS.get(name, name): p for name, p in test["p_by_statistic"].items()}
    return {**test, "statistic": STATISTICS.get(test["statistic"], test["statistic"]), "p_by_statistic": by_statistic}
