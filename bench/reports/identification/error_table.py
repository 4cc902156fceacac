"""Median absolute errors of an experiment as a table.

A row for each cell, ours above the paper's, and a column for each unknown.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench.plan.naming import place_text, telling_axes
from bench.plan.plan import Cell, Plan
from bench.reports.identification.error_chart import at_limits
from bench.reports.tables import EFFORT, EXACT, LEAST_PCT
from ksmea.show.text import number

OURS, PAPER = "here", "paper"
LIMIT = "†"


def error_table(plan: Plan, summary: pd.DataFrame) -> pd.DataFrame:
    """Errors in per cent, then updates, evaluations and time, as medians over the repetitions.

    The smallest error of each column and source has a star if there are several; a value at a search limit has a dagger.
    """
    axes, rows = telling_axes(plan), []
    names = list(dict.fromkeys(summary["parameter"]))
    by_name = {name: summary[summary["parameter"] == name].reset_index(drop=True) for name in names}
    by_name = {name: frame for name, frame in by_name.items() if len(frame) == len(plan.cells)}
    shown = [name for name, frame in by_name.items() if frame["median"].notna().any()]
    sources = [OURS, PAPER] if any(by_name[name]["paper"].notna().any() for name in shown) else [OURS]
    best = {(name, source): _best(by_name[name], source) for name in shown if name not in EFFORT for source in sources}
    for at, cell in enumerate(plan.cells):
        for source in sources:
            if source == PAPER and not any(np.isfinite(by_name[name]["paper"].iloc[at]) for name in shown):
                continue
            row = {axis: place_text(cell.place.get(axis)) for axis in axes}
            row |= {"": source} if len(sources) > 1 else {}
            for name in shown:
                is_best = best.get((name, source)) == at
                of_name = by_name[name].iloc[at]
                marks = "*" * is_best + LIMIT * _is_at_limit(
                    cell, name, of_name["median" if source == OURS else "paper"]
                )
                row[_heading(name, by_name[name])] = _cell(name, of_name, source) + marks
            row |= _counts(by_name[shown[0]].iloc[at], source) if shown else {}
            rows.append(row)
    return pd.DataFrame(rows)


def _is_at_limit(cell: Cell, name: str, value: float) -> bool:
    """Whether a value, of the median run or of the paper, is where its search ends."""
    facts = next((each for each in cell.parameters if each.name == name), None)
    return facts is not None and bool(at_limits(np.array([value], dtype=float), facts)[0])


def _heading(name: str, frame: pd.DataFrame) -> str:
    if name in EFFORT:
        return f"{name.replace('_', ' ')}{f' ({EFFORT[name]})' if EFFORT[name] else ''}"
    return f"{name} (%)" if frame["error_pct_median"].notna().any() else name.replace("_", " ")


def _cell(name: str, row: pd.Series, source: str) -> str:
    if name in EFFORT:
        return number(row["median"] if source == OURS else row["paper"], 3)
    error = _error(row, source)
    is_rounding = name not in EXACT and np.isfinite(row["error_pct_median"]) and 0 < error < LEAST_PCT
    return f"< {LEAST_PCT:g}" if is_rounding else number(error, 2)


def _error(row: pd.Series, source: str) -> float:
    if source == OURS:
        return float(row["error_pct_median"] if np.isfinite(row["error_pct_median"]) else row["median"])
    return float(100 * abs(row["paper"] / row["reference"] - 1)) if row["reference"] else np.nan


def _best(frame: pd.DataFrame, source: str) -> int | None:
    """The row with the smallest error; None of a single row, without errors, or if all are equal."""
    errors = np.array([_error(row, source) for _, row in frame.iterrows()])
    errors = np.where(errors < LEAST_PCT, 0.0, errors)
    known = errors[np.isfinite(errors)]
    if len(set(known)) < 2 or not np.isfinite(frame["error_pct_median"]).any():
        return None
    return int(np.nanargmin(errors))


def _counts(row: pd.Series, source: str) -> dict[str, str]:
    """Runs with a result, and failed ones."""
    if source != OURS:
        return {"runs": ""}
    failed = f", {row['failed']} failed" if row["failed"] else ""
    return {"runs": f"{row['runs']}{failed}"}
