"""The spread of each unknown over the repetitions, cell by cell, next to the paper's values."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS
from bench.plan.naming import place_text, telling_axes
from bench.plan.plan import Plan
from bench.reports.identification.error_chart import determined, has_true_values
from bench.reports.identification.factors import short
from bench.reports.tables import EFFORT, EXACT, FEWEST_OF_BOX, LEAST_PCT, has_intervals, lacks_interval
from ksmea.arrays import Array
from ksmea.show.charts.chart import Axis, Boxes, Chart, Element, Line, Panel, Points, named_rows
from ksmea.show.charts.colours import INTERVAL, PAPER, REFERENCE
from ksmea.show.text import two_digits

COLUMNS = 5  # of panels: more are too small to read
ROW = 0.3  # inches
WIDE = 50.0  # largest to smallest value, from which on an axis is logarithmic
BEYOND = 0.1  # of the spread of all that is drawn: as far behind it an open side ends
PAPER_BELOW = 0.28  # of a row: the paper's values hide none
REACH = 0.45  # half of what a line of a cell takes


def spread_chart(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame) -> Chart:
    """A panel per parameter (and updates, evaluations, time), with a row for each cell.

    Boxes over the repetitions, the paper's values. Cells whose problem has not the parameter, or has it in another
    unit, are no part of its panel. Effort that is equal in all runs has none.
    """
    names = list(dict.fromkeys(zip(summary["parameter"], summary["unit"])))
    found = {each: summary[(summary["parameter"] == each[0]) & (summary["unit"] == each[1])] for each in names}
    told = {each: rows for each, rows in found.items() if not _is_constant(rows, runs)} or found
    panels = [_panel(plan, runs, rows, cells_with(plan, *each)) for each, rows in told.items()]
    n_run = int(runs.groupby("cell").size().max())
    has_boxes = any(isinstance(element, Boxes) for panel in panels for element in panel.elements)
    there = {element.name for panel in panels for element in panel.elements}
    marks = [said for name, said in MARKS.items() if name in there]
    repetitions = f"all values of {n_run} repetition{'s' * (n_run > 1)}"
    shown = f"Boxes: median, quartiles and {repetitions}" if has_boxes else f"Dots: {repetitions}"
    caption = f"{', '.join([shown, *marks])}."
    across = min(COLUMNS, len(panels))
    return Chart(
        spread_finding(plan, summary) or "Values of each parameter", caption, tuple((panel,) for panel in panels), across, 2.2 * across + 2.0,
        most=len(panels),
    )  # fmt: skip


def _is_constant(rows: pd.DataFrame, runs: pd.DataFrame) -> bool:
    """Whether all runs and the paper have one effort."""
    name = rows["parameter"].iloc[0]
    if name not in EFFORT | EXACT or name not in runs:
        return False
    values = [*runs.loc[runs["status"].isin(RESULTS), name].dropna(), *rows["paper"].dropna()]
    return len(set(values)) == 1


def spread_finding(plan: Plan, summary: pd.DataFrame) -> str:
    """Cells with the smallest and the largest median error of their worst parameter.

    Instead that the data determine none, if so; empty without errors.
    """
    if plan.cells[0].parameters and has_true_values(plan) and not determined(plan, in_any=True):
        return f"These data determine none of {', '.join(each.name for each in plan.cells[0].parameters)}: 1 σ of each is above its value"
    errors: dict[int, list[float]] = defaultdict(list)
    for (name, unit), rows in summary.groupby(["parameter", "unit"], sort=False):
        for cell, error in zip(cells_with(plan, name, unit), rows["error_pct_median"]):
            errors[cell] += [error] if np.isfinite(error) else []
    worst = {cell: max(of) for cell, of in errors.items() if of}
    if not worst:
        return ""
    best, last = min(worst, key=worst.__getitem__), max(worst, key=worst.__getitem__)
    names = {cell: _called(plan, cell) for cell in worst}
    said = f"within {_percent(worst[best])} % of each parameter (median)"
    if names[best] == names[last]:
        return f"All results {said}"
    return f"{names[best]}: {said}; {names[last]}: within {_percent(worst[last])} %"


def _called(plan: Plan, cell: int) -> str:
    """A cell in words, numbers with the name of their factor."""
    place = plan.cells[cell].place
    levels = {axis: place.get(axis) for axis in telling_axes(plan)}
    words = [
        f"{short(axis)} {place_text(level)}" if isinstance(level, int | float) else place_text(level)
        for axis, level in levels.items()
    ]
    return ", ".join(words)


def _percent(error: float) -> str:
    return two_digits(max(error, LEAST_PCT))


OURS = "this bench"
PRINTED, TRUE, MEDIAN_INTERVAL = "paper", "reference", "median interval (arrow: open side)"
MARKS = {
    PRINTED: "diamonds: paper",
    TRUE: "dotted: reference",
    MEDIAN_INTERVAL: "green lines: median interval, with an arrow where it is open",
}


def cells_with(plan: Plan, name: str, unit: str) -> list[int]:
    """The cells that a table has a row of this name and unit for: all, of a row that is not a parameter."""
    if name in EFFORT | EXACT:
        return list(range(len(plan.cells)))
    return [
        index
        for index, cell in enumerate(plan.cells)
        if any((facts.name, facts.unit) == (name, unit) for facts in cell.parameters)
    ]


def _panel(plan: Plan, runs: pd.DataFrame, rows: pd.DataFrame, cells: list[int]) -> Panel:
    name, unit = rows["parameter"].iloc[0], rows["unit"].iloc[0]
    results = runs[runs["status"].isin(RESULTS)]
    values = [
        results.loc[results["cell"] == cell, name].dropna().to_numpy(float) if name in results else np.array([])
        for cell in cells
    ]
    at, paper, reference = (
        np.arange(len(rows), dtype=float),
        rows["paper"].to_numpy(float),
        rows["reference"].to_numpy(float),
    )
    is_log = (name == "time" and bool(np.isfinite(paper).any())) or _is_wide([*values, paper])
    elements: list[Element] = [_spread(at, values)]
    if has_intervals(rows):
        every = np.concatenate([*values, reference, paper])
        has = ~lacks_interval(rows).to_numpy(bool)
        elements += interval_elements(
            at[has], rows["low"].to_numpy(float)[has], rows["high"].to_numpy(float)[has], every, is_log=is_log
        )
    if np.isfinite(reference).any():
        ends = segments(reference, reference), segments(at - REACH, at + REACH)
        elements.append(Line(*ends, name=TRUE, colour=REFERENCE, dash="dot", said="reference {x}"))
    if np.isfinite(paper).any():
        elements.append(Points(paper, at + PAPER_BELOW, "diamond", name=PRINTED, colour=PAPER))
    x = Axis("", "log" if is_log else "linear", is_whole=name in EFFORT and not unit)
    y = named_rows(_names(plan, cells), " / ".join(map(short, telling_axes(plan))), f"cells {cells}")
    title = f"{name} ({unit})" if unit else name.replace("_", " ")
    return Panel(tuple(elements), x, y, title, ROW * len(cells) + 0.3)


def _spread(at: Array, values: Sequence[Array]) -> Element:
    """Boxes of the values of each cell (n,), or all of them where they are too few for quartiles."""
    if max(map(len, values), default=0) >= FEWEST_OF_BOX:
        return Boxes(at, values, along="x", name=OURS, with_points=True)
    return Points(np.concatenate(values), np.repeat(at, [len(each) for each in values]), name=OURS, size=4.0)


def interval_elements(at: Array, low: Array, high: Array, values: Array, *, is_log: bool = False) -> list[Element]:
    """Intervals (n,) below boxes; an open end lies beyond all values, and is an arrow."""
    first, last = drawn_ends(low, high, values, is_log=is_log)
    beside = at + 0.4
    line = Line(segments(first, last), segments(beside, beside), name=MEDIAN_INTERVAL, colour=INTERVAL, width=2.0)
    arrows = [
        Points(ends[is_open], beside[is_open], f"triangle {way}", 4.5, colour=INTERVAL)
        for way, ends, is_open in (("left", first, np.isnan(low)), ("right", last, np.isnan(high)))
        if is_open.any()
    ]
    return [line, *arrows]


def drawn_ends(low: Array, high: Array, values: Array, *, is_log: bool = False) -> tuple[Array, Array]:
    """Ends (n,) of intervals to draw, with open ends (NaN) beyond all other ends and values (m,).

    On a logarithmic axis they lie beyond by a factor; an end that is not above 0 counts as open, and a value that is
    not above 0 is ignored.

    >>> drawn_ends(np.array([np.nan, 1.0]), np.array([3.0, 4.0]), np.array([5.0, 6.0]))
    (array([0.5, 1. ]), array([3., 4.]))
    """
    if is_log:
        first, last = drawn_ends(
            *(np.log(each, where=each > 0, out=np.full(len(each), np.nan)) for each in (low, high, values))
        )
        return np.exp(first), np.exp(last)
    every = np.concatenate([low, high, values])
    every = every[np.isfinite(every)]
    if not len(every):
        return low, high
    reach = BEYOND * (np.ptp(every) or np.abs(every[0]) or 1.0)
    return np.where(np.isnan(low), every.min() - reach, low), np.where(np.isnan(high), every.max() + reach, high)


def segments(first: Array, last: Array) -> Array:
    """Ends (n,) of lines that are apart, as the coordinates (3 n,) of one line with gaps."""
    return np.stack([first, last, np.full(len(first), np.nan)], axis=1).ravel()


def _is_wide(values: Sequence[Array]) -> bool:
    every = np.concatenate(values)
    every = every[np.isfinite(every)]
    return bool(len(every) and every.min() > 0 and every.max() > WIDE * every.min())


def _names(plan: Plan, cells: Sequence[int]) -> list[str]:
    """Names of cells, never numbers."""
    axes = telling_axes(plan)
    return [" / ".join(place_text(plan.cells[cell].place.get(axis)) for axis in axes) for cell in cells]
