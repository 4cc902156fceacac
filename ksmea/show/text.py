"""Numbers and columns as text."""

from __future__ import annotations

from typing import Any

import pandas as pd


def aligned(head: list[str], lines: list[list[str]]) -> str:
    """Columns of text, right-aligned."""
    widths = [max(len(line[column]) for line in [head, *lines]) for column in range(len(head))]
    return "\n".join("  ".join(text.rjust(width) for text, width in zip(line, widths)) for line in [head, *lines])


def number(value: Any, digits: int = 4) -> str:
    return "–" if pd.isna(value) else f"{value:.{digits}g}"
