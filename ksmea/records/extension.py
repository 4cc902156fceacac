"""Records of a model extended by effects: its gain on left-out data, and averages over indistinguishable explanations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from ksmea.records.elpd import ElpdDifference
from ksmea.records.estimate import EstimateRecord
from ksmea.records.record import Record
from ksmea.units import Vibration


@dataclass(frozen=True)
class EffectRecord(Record):
    """An effect at its location, with the settings that a problem file needs to have it there."""

    name: str
    location: str
    settings: Mapping[str, Any]


@dataclass(frozen=True)
class PredictiveGainRecord(Record):
    """How much better the extended model predicts blocks of speeds that are left out; `is_supported` by the rule of
    ksmea.records.elpd."""

    elpd_difference: float  # sum over blocks
    standard_error: float
    by_block: tuple[float, ...]
    median: float  # of the blocks
    n_better: int  # blocks that the extended model predicts better
    p_sign: float  # exact, one-sided
    p_wilcoxon: float  # exact, one-sided
    is_supported: bool
    rmse_before: Vibration
    rmse_after: Vibration

    @classmethod
    def of(cls, elpd: ElpdDifference, rmse_before: float, rmse_after: float) -> Self:
        return cls(
            elpd_difference=elpd.total,
            standard_error=elpd.standard_error,
            by_block=tuple(elpd.by_block.tolist()),
            median=elpd.median,
            n_better=elpd.n_better,
            p_sign=elpd.p_sign,
            p_wilcoxon=elpd.p_wilcoxon,
            is_supported=elpd.is_supported,
            rmse_before=rmse_before,
            rmse_after=rmse_after,
        )


@dataclass(frozen=True)
class ExtensionRecord(Record):
    """One effect that extends a model, and all unknowns as fitted with it, in their units."""

    effect: EffectRecord
    values: Mapping[str, float]
    units: Mapping[str, str]


@dataclass(frozen=True)
class ExplanationRecord(Record):
    """Effects that together explain the data."""

    label: str
    effects: tuple[EffectRecord, ...]
    deviance_drop: float  # against the baseline model
    delta_bic: float
    weight: float | None = None  # in the average; None: it is not averaged


@dataclass(frozen=True)
class AveragedRecord(Record):
    """The unknowns of the baseline model averaged over the explanations (ksmea.diagnosis.model_averaging); `interval` is 'mixture'."""

    level: float
    coefficients: tuple[EstimateRecord, ...]


@dataclass(frozen=True)
class BandRecord(Record):
    """Averaged amplitudes and the ends of their intervals, (n_speed, n_channel) m."""

    value: tuple[tuple[Vibration, ...], ...]
    low: tuple[tuple[Vibration, ...], ...]
    high: tuple[tuple[Vibration, ...], ...]
