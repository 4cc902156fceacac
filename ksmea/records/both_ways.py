"""Whether runs fitted jointly and by their differences alone agree."""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.records.record import Record


@dataclass(frozen=True)
class MovedRecord(Record):
    """An unknown that differences put elsewhere: their value, in its unit, and the change from the joint one in standard errors."""

    name: str
    unit: str
    value: float
    standard_errors: float


@dataclass(frozen=True)
class BothWaysRecord(Record):
    """`p` of as large a disagreement under a right model, by χ² with so many degrees of freedom."""

    p: float
    degrees: int
    moved: tuple[MovedRecord, ...] = ()
