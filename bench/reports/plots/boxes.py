"""Box plots over repetitions: a small plot for each quantity, a box for each cell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bench.plan.page import Plot
from bench.reports.plots.interval_ends import drawn_ends
from bench.reports.plots.traces import BLUE, GREEN, GREY, ORANGE, axis, layout

MOST_POINTS = 2000  # runs of a cell of which each is drawn; of more, quartiles alone
ARROW = 9  # px of an open end
FEW_COUNTS = 6  # range of counts up to which an axis shows each
MOST_NAMES = 12  # cells whose names stand below the axis

Intervals = Sequence[tuple[float, float] | None]


def box_trace(position: Any, values: Sequence[float], name: str, colour: str = BLUE, **more: Any) -> dict[str, Any]:
    """Median, quartiles and extremes of values, and the values themselves where they are few."""
    finite = np.asarray(values, dtype=float)
    finite = finite[np.isfinite(finite)]
    low, first, median, third, high = np.percentile(finite, [0, 25, 50, 75, 100]) if len(finite) else [np.nan] * 5
    box = {  # plotly's own quartiles are others than those of tables
        "type": "box",
        "name": name,
        "line": {"color": colour, "width": 1.6},
        "marker": {"color": colour, "size": 3},
        "x0": position,
        "q1": [first],
        "median": [median],
        "q3": [third],
        "lowerfence": [low],
        "upperfence": [high],
        "whiskerwidth": 0.4,
        **more,
    }
    points = {"y": [finite], "boxpoints": "all", "jitter": 0.6, "pointpos": 0}
    return {**box, **points} if 0 < len(finite) <= MOST_POINTS else box


def box_plot(
    title: str,
    unit: str,
    cells: Sequence[str],
    values: Sequence[Sequence[float]],
    marks: Mapping[str, Sequence[float]],
    intervals: Intervals | None = None,
    *,
    x: str = "",
    y_log: bool = False,
) -> Plot:
    """A box for the values of each cell; `marks` are further values of each cell by name, 'paper' and 'reference' for
    example, `intervals` the ends of one, not a number where open, and None where a cell has none."""
    at = list(range(len(cells)))
    traces = [box_trace(number, of, name, showlegend=False) for number, name, of in zip(at, cells, values)]
    for mark, of in marks.items():
        style = MARKS.get(mark, {"symbol": "circle", "size": 8, "color": GREY})
        if np.isfinite(np.asarray(of, dtype=float)).any():
            traces.append({"type": "scatter", "mode": "markers", "name": mark, "x": at, "y": of, "marker": style})
    if intervals is not None:
        traces += _intervals(at, intervals, [*values, *marks.values()], y_log)
    made = layout(x, unit, y_log=y_log)
    if not y_log and _are_few_counts([*values, *marks.values()]):
        made["yaxis"]["dtick"] = 1
    few = len(cells) <= MOST_NAMES
    made["xaxis"] = (
        axis(x, tickvals=at, ticktext=cells, range=[-0.6, len(cells) - 0.4]) if few else axis(x or "cell, from 0")
    )
    return Plot(title, _alternative(title, marks, intervals), {"data": traces, "layout": made}, height=330)


def _are_few_counts(values: Sequence[Sequence[float]]) -> bool:
    """Whether all values are whole and close to each other."""
    every = np.concatenate([np.asarray(of, dtype=float) for of in values] or [np.array([])])
    every = every[np.isfinite(every)]
    return bool(len(every) and np.all(every == np.round(every)) and np.ptp(every) <= FEW_COUNTS)


MARKS = {
    "paper": {"symbol": "diamond", "size": 9, "color": ORANGE},
    "reference": {"symbol": "line-ew-open", "size": 30, "color": GREY, "line": {"width": 2}},
    "most likely": {"symbol": "cross", "size": 7, "color": GREEN},
}


def _alternative(title: str, marks: Mapping[str, Sequence[float]], intervals: Intervals | None) -> str:
    legend = [
        f"{MARKED[mark]}: {mark}"
        for mark in marks
        if mark in MARKED and np.isfinite(np.asarray(marks[mark], dtype=float)).any()
    ]
    if intervals is not None:
        is_open = any(np.isnan(each).any() for each in intervals if each is not None)
        legend.append("green lines: median interval" + is_open * ", with an arrow where it is open")
    return f"{title}: median, quartiles and all values of each cell" + (f"; {', '.join(legend)}." if legend else ".")


MARKED = {"paper": "diamonds", "reference": "bars", "most likely": "crosses"}


def _intervals(
    at: Sequence[int], intervals: Intervals, values: Sequence[Sequence[float]], is_log: bool
) -> list[dict[str, Any]]:
    """The interval of each cell beside its box; an end that is open lies beyond all values, and is an arrow."""
    every = np.concatenate([np.asarray(of, dtype=float) for of in values] or [np.array([])])
    with_interval = [(position, ends) for position, ends in zip(at, intervals) if ends is not None]
    if not len(every) or not np.isfinite([ends for _, ends in with_interval]).any():
        return []
    low, high = np.array([ends for _, ends in with_interval], dtype=float).T
    xs, ys, sizes = [], [], []
    for (position, ends), *drawn in zip(with_interval, *drawn_ends(low, high, every, is_log=is_log)):
        xs += [position + 0.42, position + 0.42, None]
        ys += [*map(float, drawn), None]
        sizes += [*(ARROW if np.isnan(end) else 0 for end in ends), 0]
    return [
        {
            "type": "scatter",
            "mode": "lines+markers",
            "name": "median interval",
            "x": xs,
            "y": ys,
            "marker": {
                "symbol": ["triangle-down", "triangle-up", "circle"] * len(with_interval),
                "size": sizes,
                "color": GREEN,
                "opacity": 1,
                "line": {"width": 0},
            },
            "line": {"color": GREEN, "width": 3},
        }
    ]
