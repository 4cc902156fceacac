"""Balancing results of a campaign.

Weights that were not known, influence coefficients, and the weights that cancel the unbalance. All values are SI;
angles count from the same mark as the angles of known weights.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from ksmea.records.curves import Matrix, Row
from ksmea.records.record import Record
from ksmea.units import ANGLE, GRAM_MILLIMETRE, SPEED, Angle, Length, Quantity, Unbalance, Vibration

INFLUENCE = Quantity("m/(kg m)")


@dataclass(frozen=True)
class VectorRecord(Record):
    """An unbalance in one plane, with intervals of its size and its angle."""

    position: Length
    plane: str  # what sits there, as the model names it; empty: nothing
    run: str  # that it belongs to; empty: all
    x: Unbalance
    y: Unbalance
    size: Unbalance
    size_low: Unbalance
    size_high: Unbalance
    angle: Angle
    angle_low: Angle | None  # None: any
    angle_high: Angle | None
    weight_unit: str = "g mm"  # that texts show sizes in, and how many kg m it is
    weight_unit_si: Unbalance = GRAM_MILLIMETRE


@dataclass(frozen=True)
class InfluenceRecord(Record):
    """Change of the response per unbalance in one plane, m/(kg m), (n_speed, n_channel).

    Amplitude and phase (rad), and their standard errors.
    """

    position: Length
    plane: str
    amplitude: Annotated[Matrix, INFLUENCE]
    phase: Annotated[Matrix, ANGLE]
    amplitude_sd: Annotated[Matrix, INFLUENCE]
    phase_sd: Annotated[Matrix, ANGLE]
    weight_unit: str = "g mm"
    weight_unit_si: Unbalance = GRAM_MILLIMETRE


@dataclass(frozen=True)
class WeightsRecord(Record):
    """Weights found by a campaign fit, and corrections.

    `corrections` cancel the identified unbalance. `before` is the largest 1X amplitude (m) of the model at the measured
    speeds in each channel, without weights; `after` that which is left with the corrections, as the root of its
    expected square.
    """

    level: float
    weights: tuple[VectorRecord, ...]
    corrections: tuple[VectorRecord, ...]
    speed: Annotated[Row, SPEED]  # of the influence
    channels: tuple[str, ...]
    influence: tuple[InfluenceRecord, ...]
    before: tuple[Vibration, ...]
    after: tuple[Vibration, ...]
