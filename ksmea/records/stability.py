"""The stability of a rotor as found: from which spin speed on free motions grow, so that no steady response exists."""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.records.record import Record


@dataclass(frozen=True)
class StabilityRecord(Record):
    """The stability threshold and its interval, rad/s; None where no free motion grows up to `searched`, 0: from rest."""

    threshold: float | None
    low: float | None  # ends of the interval
    high: float | None
    level: float  # of the interval
    measured: float  # highest speed of the data
    searched: float

    @property
    def is_violated(self) -> bool:
        """Whether no steady response exists at speeds that were measured, or are to be."""
        return self.threshold is not None and self.threshold <= self.measured
