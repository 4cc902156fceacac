"""Records of an unknown with its interval, of the noise level, and of a rotor's stability threshold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ksmea.records.record import Record
from ksmea.units import Part, Quantity, Speed, Vibration

RunNoise = Annotated[tuple[str, float, float], Quantity("name, part, m")]  # its relative part and its floor


@dataclass(frozen=True)
class Shown:
    """A value with the ends of its interval in `unit`, not a number where open.

    Tables and charts show it for an unknown.
    """

    value: float
    low: float
    high: float
    unit: str

    @property
    def has_interval(self) -> bool:
        return not np.isnan([self.low, self.high]).all()


@dataclass(frozen=True)
class EstimateRecord(Record):
    """An unknown as fitted, with its interval, in its unit."""

    name: str
    unit: str
    value: float
    low: float | None  # None: open on this side
    high: float | None
    interval: str  # basis, see ksmea.inference.intervals.Interval
    at_limit: bool  # the value lies on a search limit, which is what is physical for the unknowns of an effect

    @property
    def shown(self) -> Shown:
        low, high = (np.nan if end is None else end for end in (self.low, self.high))
        return Shown(self.value, low, high, self.unit)

    def holds(self, value: float) -> bool:
        """Whether a value lies in the interval; of an angle, its turn nearest to the estimate counts."""
        if self.unit == "deg":
            value += 360 * round((self.value - value) / 360)
        return (self.low is None or self.low <= value) and (self.high is None or value <= self.high)


@dataclass(frozen=True)
class NoiseLevelRecord(Record):
    """Standard deviation s of a response q: s² = (relative · |q|)² + floor²."""

    relative: Part  # the median where each run has its own
    floor: Vibration  # the median where each datum or run has its own
    by_run: tuple[RunNoise, ...] = ()  # of each run that has its own


@dataclass(frozen=True)
class StabilityRecord(Record):
    """The stability threshold and its interval, rad/s.

    None if no free motion grows up to `searched`, 0: from rest.
    """

    threshold: Speed | None
    low: Speed | None  # ends of the interval
    high: Speed | None
    level: float  # of the interval
    measured: Speed  # highest speed of the data
    searched: Speed

    @property
    def is_violated(self) -> bool:
        """Whether no steady response exists at speeds that were measured, or are to be."""
        return self.threshold is not None and self.threshold <= self.measured
