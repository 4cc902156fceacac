"""Whether the joint fit of runs and that of their differences agree, in words."""

from __future__ import annotations

from collections.abc import Iterator

from ksmea.records.both_ways import BothWaysRecord
from ksmea.show.text import chance, number

DISAGREE = 0.01  # p below which it is said


def hausman_lines(record: BothWaysRecord | None) -> Iterator[str]:
    """One line; none where differences between runs tell nothing."""
    if record is None:
        return
    if record.p >= DISAGREE:
        yield f"joint and by differences between runs agree ({chance(record.p)})"
        return
    moved = ", ".join(
        f"{each.name} by {number(abs(each.standard_errors), 2)} standard errors to {number(each.value)} {each.unit}"
        for each in record.moved
    )
    yield (
        f"joint and by differences between runs do not agree ({chance(record.p)}): differences move {moved or 'several a little'};"
        " something alike in all runs, such as runout or a bow, is likely and not in the model: +experiment=diagnose looks for"
        " it, measurement.reference leaves it out"
    )
