"""Unknowns that data can hardly tell apart, in words."""

from __future__ import annotations

from collections.abc import Sequence

ALIKE = 0.95  # |correlation| above which two unknowns are hard to tell apart
MAX_PAIRS = 6  # of them that are named


def alike_text(correlation: Sequence[Sequence[float | None]], names: Sequence[str]) -> str:
    """For example 'kxx and kyy (+0.971)'; 'none' where there are none."""
    pairs = [
        f"{names[one]} and {names[other]} ({value:+.3f})"
        for one, row in enumerate(correlation)
        for other, value in enumerate(row)
        if other > one and value is not None and abs(value) > ALIKE
    ]
    more = f" and {len(pairs) - MAX_PAIRS} pairs more" if len(pairs) > MAX_PAIRS else ""
    return (", ".join(pairs[:MAX_PAIRS]) or "none") + more
