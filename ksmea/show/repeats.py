"""What repeats tell of the noise, in words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ksmea.records.repeats import RepeatsRecord
from ksmea.show.text import chance, noise_parts, number

DIFFER = 0.01  # p below which runs that are alike are said to differ


def repeat_lines(record: RepeatsRecord | None) -> Iterator[str]:
    """For example 'repeats differ by 0.4 % + 0.1 µm (86 degrees of freedom)', and whether runs do by more."""
    if record is None:
        return
    who = "runs with the same weights" if record.are_runs else "repeats"
    said = f"{who} differ by {noise_parts(record.relative, record.floor)} ({record.degrees} degrees of freedom)"
    between = record.between
    if between is None:
        yield said
    elif between.p >= DIFFER:
        yield f"{said}; runs with the same weights differ no more than that ({chance(between.p)})"
    else:
        times = number(np.sqrt(between.ratio), 2)
        most = ", ".join(f"{each.what} ({number(np.sqrt(each.ratio), 2)} times)" for each in record.standing_out)
        where = f": {most}" if most else ""
        yield f"{said}; runs with the same weights differ {times} times as much ({chance(between.p)}){where}"
