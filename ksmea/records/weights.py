"""What a campaign tells a balancer: weights that were not known, influence coefficients, and the weights that cancel the
unbalance. All values are SI; angles count from where those of known weights do."""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.records.curves import Matrix, Row
from ksmea.records.record import Record


@dataclass(frozen=True)
class VectorRecord(Record):
    """An unbalance in one plane, with intervals of its size and its angle."""

    position: float  # m
    plane: str  # what sits there, as the model names it; empty: nothing
    run: str  # that it belongs to; empty: all
    x: float  # kg m
    y: float
    size: float  # kg m
    size_low: float
    size_high: float
    angle: float  # rad
    angle_low: float | None  # None: any
    angle_high: float | None


@dataclass(frozen=True)
class InfluenceRecord(Record):
    """Change of the response per unbalance in one plane, m/(kg m), (n_speed, n_channel): amplitude and phase (rad), and their
    standard errors."""

    position: float
    plane: str
    amplitude: Matrix
    phase: Matrix
    amplitude_sd: Matrix
    phase_sd: Matrix


@dataclass(frozen=True)
class WeightsRecord(Record):
    """`corrections` cancel the identified unbalance. `before` is the largest 1X amplitude (m) of the model at the measured
    speeds in each channel, without weights; `after` that which is left with the corrections, as the root of its expected
    square."""

    level: float
    weights: tuple[VectorRecord, ...]
    corrections: tuple[VectorRecord, ...]
    speed: Row  # rad/s, of the influence
    channels: tuple[str, ...]
    influence: tuple[InfluenceRecord, ...]
    before: tuple[float, ...]
    after: tuple[float, ...]
