"""Dates and clock times of exports as seconds, in the layouts that instruments write."""
# Shorter than 40 lines: readers of several exports share it.

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

import numpy as np

from ksmea.arrays import Array

DATES = ("%m/%d/%Y", "%d/%m/%Y", "%d.%m.%Y", "%Y-%m-%d", "%d%b%Y", "%d-%b-%Y")
TIMES = ("%I:%M:%S %p", "%I:%M:%S.%f %p", "%H:%M:%S", "%H:%M:%S.%f")
SEPARATORS = (" ", "T")


def seconds(texts: Sequence[str]) -> Array | None:
    """Seconds since the first of several times, (n,); None where they are no times, or where month and day could be either and
    that makes a difference.

    >>> seconds(["4/4/2021 4:35:40 AM", "4/4/2021 4:35:41 AM"])
    array([0., 1.])
    """
    found: list[Array] = []
    for date in DATES:
        for time in TIMES:
            for separator in SEPARATORS:
                elapsed = _elapsed(texts, f"{date}{separator}{time}")
                if elapsed is not None and not any(np.array_equal(elapsed, other) for other in found):
                    found.append(elapsed)
    return found[0] if len(found) == 1 else None


def _elapsed(texts: Sequence[str], layout: str) -> Array | None:
    try:
        times = [datetime.strptime(text, layout) for text in texts]
    except ValueError:
        return None
    return np.array([(each - times[0]).total_seconds() for each in times])
