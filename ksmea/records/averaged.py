"""Explanations that data do not tell apart, and what they say together, as records have them."""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.records.estimate import EstimateRecord
from ksmea.records.extension import EffectRecord
from ksmea.records.record import Record


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
    """The unknowns of the baseline model averaged over the explanations (ksmea.diagnosis.averaging); `interval` is 'mixture'."""

    level: float
    coefficients: tuple[EstimateRecord, ...]


@dataclass(frozen=True)
class BandRecord(Record):
    """Averaged amplitudes and the ends of their intervals, (n_speed, n_channel) m."""

    value: tuple[tuple[float, ...], ...]
    low: tuple[tuple[float, ...], ...]
    high: tuple[tuple[float, ...], ...]
