"""Amplification factors of a response to unbalance, and the separation margins that API 617 requires.

The amplification factor of a peak at N_c is N_c / (N_2 − N_1), its width at 1/√2 of its height; of a peak whose one side does not fall so
far, twice the other side. API 617, 7th edition (2002), chapter 1, clause 2.6.2.10 (8th edition: part 1, 4.8.2.10): a peak with a
factor below 2.5 is critically damped and needs no margin; one below the operating range needs 17 (1 − 1/(AF − 1.5)) % of the least
speed, one above it 10 + 17 (1 − 1/(AF − 1.5)) % of the largest continuous speed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ksmea.arrays import Array, peak_indices
from ksmea.measurement.channel import Channel
from ksmea.rotordynamics.half_power import HALF_POWER

CLAUSE = "API 617, 7th edition, chapter 1, 2.6.2.10"
CRITICALLY_DAMPED = 2.5  # amplification factor below which no margin is asked for
BELOW, ABOVE = 0.17, 0.10  # parts of the speed

Side = Literal["below", "above", "inside"]


@dataclass(frozen=True)
class Peak:
    """A peak of the response of one probe: its speed (rad/s) and amplification factor."""

    channel: Channel
    speed: float
    amplification_factor: float


@dataclass(frozen=True)
class SeparationMargin:
    """A peak and its separation from an operating range; margins are parts of the nearer end of the range."""

    peak: Peak
    side: Side
    actual: float
    required: float

    @property
    def is_met(self) -> bool:
        return self.actual >= self.required


def peaks(speed: Array, amplitude: Array, channels: Sequence[Channel]) -> tuple[Peak, ...]:
    """The peaks of amplitudes (n_speed, n_channel) at rising speeds (rad/s), by speed.

    Peaks without a side that falls to half power are left out.
    """
    found = []
    for column, channel in zip(amplitude.T, channels):
        for index in peak_indices(column):
            top, height = _vertex(speed[index - 1 : index + 2], column[index - 1 : index + 2])
            sides = [
                _crossing(speed[index::-1], column[index::-1], height),
                _crossing(speed[index:], column[index:], height),
            ]
            widths = [abs(each - top) for each in sides if each is not None]
            if widths:
                found.append(Peak(channel, top, top / (2 * sum(widths) / len(widths))))
    return tuple(sorted(found, key=lambda each: each.speed))


def separation_margins(found: Sequence[Peak], low: float, high: float) -> tuple[SeparationMargin, ...]:
    """Separation margins of peaks from an operating range (rad/s)."""
    return tuple(_margin(peak, low, high) for peak in found)


def _margin(peak: Peak, low: float, high: float) -> SeparationMargin:
    side: Side = "below" if peak.speed < low else "above" if peak.speed > high else "inside"
    actual = {"below": 1 - peak.speed / low, "above": peak.speed / high - 1, "inside": 0.0}[side]
    return SeparationMargin(peak, side, actual, required_margin(peak.amplification_factor, side))


def required_margin(factor: float, side: Side) -> float:
    """Part of the nearer end of the operating range.

    A peak inside it cannot have one: what it would need just above is given.
    """
    if factor < CRITICALLY_DAMPED:
        return 0.0
    of_factor = BELOW * (1 - 1 / (factor - 1.5))
    return of_factor if side == "below" else ABOVE + of_factor


def _vertex(speed: Array, amplitude: Array) -> tuple[float, float]:
    """Speed and height of the parabola through three points about a peak."""
    a, b, c = np.polyfit(speed - speed[1], amplitude, 2)
    if a >= 0:
        return float(speed[1]), float(amplitude[1])
    return float(speed[1] - b / (2 * a)), float(c - b**2 / (4 * a))


def _crossing(speed: Array, amplitude: Array, height: float) -> float | None:
    """Where amplitudes fall to half power along one side of a peak; None if they rise again before."""
    low = height * HALF_POWER
    below = np.flatnonzero(amplitude < low)
    if not len(below):
        return None
    index = int(below[0])
    if np.any(amplitude[1:index] > height):
        return None  # the flank of a higher peak
    part = (amplitude[index - 1] - low) / (amplitude[index - 1] - amplitude[index])
    return float(speed[index - 1] + part * (speed[index] - speed[index - 1]))
