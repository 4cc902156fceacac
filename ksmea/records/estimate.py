"""An unknown with its interval, and the noise level, as several records have them."""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.records.record import Record


@dataclass(frozen=True)
class EstimateRecord(Record):
    """An unknown as fitted, with its interval, in its unit."""

    name: str
    unit: str
    value: float
    low: float | None  # None: open on this side
    high: float | None
    interval: str  # kind, see ksmea.intervals.Interval
    at_limit: bool  # the value lies on a search limit, which is what is physical for the unknowns of an effect

    def holds(self, value: float) -> bool:
        """Whether a value lies in the interval; of an angle that of its turns which is nearest to the estimate."""
        if self.unit == "deg":
            value += 360 * round((self.value - value) / 360)
        return (self.low is None or self.low <= value) and (self.high is None or value <= self.high)


@dataclass(frozen=True)
class NoiseLevelRecord(Record):
    """Standard deviation s of a response q: s² = (relative · |q|)² + floor²."""

    relative: float  # the median where each run has its own
    floor: float  # m; the median where each datum or run has its own
    by_run: tuple[tuple[str, float, float], ...] = ()  # name, relative, floor of each run that has its own
