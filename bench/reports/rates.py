"""Rates that are counted, with the interval that so many draws leave."""

from __future__ import annotations

import scipy

LEVEL = 0.95


def interval(count: int, n: int) -> tuple[float, float]:
    """Wilson's interval of a rate of `count` in n draws, 0 to 1."""
    if not n:
        return 0.0, 1.0
    found = scipy.stats.binomtest(count, n).proportion_ci(LEVEL, method="wilson")
    return float(found.low), float(found.high)


def rate(count: int, n: int) -> str:
    """For example '19, 95 % (76–99)'."""
    if not n:
        return "–"
    low, high = interval(count, n)
    return f"{count}, {100 * count / n:.0f} % ({100 * low:.0f}–{100 * high:.0f})"
