"""Records of a campaign: joint fit against fit of differences (Hausman test), and noise from repeats."""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.records.record import Record
from ksmea.units import Part, Vibration


@dataclass(frozen=True)
class MovedRecord(Record):
    """An unknown that differences put elsewhere.

    Their value, in its unit, and the change from the joint one in standard errors.
    """

    name: str
    unit: str
    value: float
    standard_errors: float


@dataclass(frozen=True)
class BothWaysRecord(Record):
    """Hausman test of values from all data against values from differences between runs.

    `p` is of as large a disagreement under a right model, by χ² with so many degrees of freedom. `shows_machine`: runs
    differ by their weights or by unknowns of their own; else only by the sweep of the speed, or by a change between
    runs.
    """

    p: float
    degrees: int
    moved: tuple[MovedRecord, ...] = ()
    shows_machine: bool = True


@dataclass(frozen=True)
class SpreadRecord(Record):
    """Spread of runs that are alike: of all of them together, or of one run or channel.

    `ratio` is the mean square between runs over the mean square of repeats, `p` the probability of a ratio at least as
    large if the runs are alike; for one of several it is corrected for their number.
    """

    what: str
    ratio: float
    p: float


@dataclass(frozen=True)
class RepeatsRecord(Record):
    """Noise s² = (relative · |q|)² + floor² of repeats, a part of which next to nothing shows being 0.

    `between` is None if no runs are alike, or they themselves are the repeats (`are_runs`).
    """

    relative: Part
    floor: Vibration
    degrees: int  # of freedom
    are_runs: bool
    between: SpreadRecord | None = None
    standing_out: tuple[SpreadRecord, ...] = ()
