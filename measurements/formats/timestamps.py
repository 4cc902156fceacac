"""Dates and clock times of exports as seconds, in the layouts that instruments write."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Sequence
from datetime import datetime

import numpy as np

from ksmea.arrays import Array

NANOSECONDS = re.compile(r"(\.[0-9]{6})[0-9]{1,3}(?![0-9])", re.ASCII)  # a datetime holds microseconds
HALF_A_DAY, DAY = 43_200.0, 86_400.0  # s
DATES = ("%m/%d/%Y", "%d/%m/%Y", "%d.%m.%Y", "%Y-%m-%d", "%d%b%Y", "%d-%b-%Y")
TIMES = ("%I:%M:%S %p", "%I:%M:%S.%f %p", "%H:%M:%S", "%H:%M:%S.%f")
SEPARATORS = (" ", "T")


def seconds(texts: Sequence[str]) -> Array | None:
    """Seconds since the first of several times, (n,).

    None if they are no times, or if month and day could be either and that makes a difference. Of clock times without a
    date one that is half a day earlier than the one before is of the next day.

    >>> seconds(["4/4/2021 4:35:40 AM", "4/4/2021 4:35:41 AM"])
    array([0., 1.])
    >>> seconds(["2024-05-17T09:30:00.000632417Z", "2024-05-17T09:30:00.001632417Z"]), seconds(["23:59:59.5", "00:00:00.5"])
    (array([0.   , 0.001]), array([0., 1.]))
    """
    texts = [NANOSECONDS.sub(r"\1", text) for text in texts]
    with contextlib.suppress(ValueError):
        times = [datetime.fromisoformat(text) for text in texts if ":" in text and "-" in text]
        if len(times) == len(texts):
            return np.array([(each - times[0]).total_seconds() for each in times])
    for layout in TIMES:
        elapsed = _elapsed(texts, layout)
        if elapsed is not None:
            return elapsed + DAY * np.cumsum(np.diff(elapsed, prepend=0.0) < -HALF_A_DAY)
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
