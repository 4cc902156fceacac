"""What repeats in a campaign tell, as a record."""

from __future__ import annotations

from ksmea.diagnosis.repeats import Spread, repeats
from ksmea.measurement import Measurement
from ksmea.records.repeats import RepeatsRecord, SpreadRecord

SLIGHT = 0.1  # a part of the noise below this part of the other everywhere does not show


def repeats_of(measurement: Measurement) -> RepeatsRecord | None:
    """None of data without repeats, or with too few."""
    found = repeats(measurement)
    if found is None:
        return None
    [(relative, floor)] = found.noise.levels
    smallest, largest = found.amplitude
    return RepeatsRecord(
        relative=0.0 if relative * largest < SLIGHT * floor else relative,
        floor=0.0 if floor < SLIGHT * relative * smallest else floor,
        degrees=found.degrees,
        are_runs=found.are_runs,
        between=None if found.between is None else _record(found.between),
        standing_out=tuple(map(_record, found.standing_out)),
    )


def _record(spread: Spread) -> SpreadRecord:
    return SpreadRecord(spread.what, spread.ratio, spread.p)
