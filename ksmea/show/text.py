"""Numbers and columns as text."""

from __future__ import annotations

from typing import Any

import pandas as pd

from ksmea.records.estimate import NoiseLevelRecord
from ksmea.units import MICROMETRE

SMALLEST = 1e-15  # p that is told: rounding


def aligned(head: list[str], lines: list[list[str]]) -> str:
    """Columns of text, right-aligned."""
    widths = [max(len(line[column]) for line in [head, *lines]) for column in range(len(head))]
    return "\n".join("  ".join(text.rjust(width) for text, width in zip(line, widths)) for line in [head, *lines])


def number(value: Any, digits: int = 4) -> str:
    return "–" if pd.isna(value) else f"{value:.{digits}g}"


def noise_parts(relative: float, floor: float) -> str:
    """For example '4.6 % + 0.017 µm', a part that is 0 left out."""
    parts = [f"{two_digits(100 * relative)} %"] if relative else []
    parts += [f"{two_digits(floor / MICROMETRE)} µm"] if floor else []
    return " + ".join(parts) or "none"


def noise_level(level: NoiseLevelRecord) -> str:
    """For example '5 % of each value and 0.1 µm', or the same of each run that has its own."""
    if not level.by_run:
        return _level(level.relative, level.floor)
    return "; ".join(f"run {name} {_level(relative, floor)}" for name, relative, floor in level.by_run)


def _level(relative: float, floor: float) -> str:
    return f"{100 * relative:.3g} % of each value and {floor / MICROMETRE:.3g} µm"


def chance(p: float) -> str:
    """For example 'p = 0.012'."""
    return f"p = {p:.2g}" if p > SMALLEST else f"p < {SMALLEST:g}"


def two_digits(value: float) -> str:
    return f"{value:.2g}" if abs(value) < 100 else f"{value:.0f}"
