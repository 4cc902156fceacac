"""Charts of a contest: curves over cost, profiles, mean ranks, and time against the model's price.

Profiles are over the instances.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from textwrap import fill
from typing import Any

import numpy as np
import pandas as pd

from bench.reports.contest.paired_tests import cliques
from bench.reports.contest.scores import WORDS
from bench.reports.contest.targets import Measure
from ksmea.arrays import Array
from ksmea.show.charts.chart import Axis, Band, Chart, Choice, Element, Level, Line, Panel, Points
from ksmea.show.charts.colours import INTERVAL, styles, symbol

COST = "evaluations / unknowns"
LEAST = 1e-3  # of a measure, below which the data see no difference: drawn as this
BANDED = 7  # methods, beyond which bands of quartiles would hide the lines
PRICES = np.logspace(-6, np.log10(3600), 200)  # s per evaluation: from a microsecond to an hour
PROFILES = {
    "performance": "expected running time / fastest",
    "data": "expected running time in simplex gradients of d + 1 evaluations",
}
MARKED = 5  # points of a line with the symbol of its method
TITLE = 26  # characters in a line of a title, three panels side by side
COLUMNS, WIDTH = 2, 4.6  # panels side by side, and inches of each


def ecdf_chart(frame: pd.DataFrame, measure: Measure, methods: Sequence[str]) -> Chart:
    """Share of targets and runs that are reached, with bands over instances.

    A panel for each group of instances.
    """
    mine = frame[frame["measure"] == measure.name]
    stacks = []
    for group in dict.fromkeys(mine["family"]):
        elements = [
            each
            for method, rows in _rows(mine, group, methods)
            for each in _banded(rows, methods, method, 100 * rows[["low", "share", "high"]])
        ]
        y = Axis("targets and runs reached (%)", low=-2, high=102, group="share", better="high")
        stacks.append((Panel(tuple(elements), Axis(COST, "log", group="cost"), y, group, 2.9),))
    said = (
        f"Share of targets ({measure.name} {measure.targets[0]:g} … {measure.targets[-1]:g}) and runs reached against the cost, with"
        " 95 % bands."
    )
    return _chart(f"Targets reached, {measure.name}", said, stacks, methods, "instances")


def anytime_chart(frame: pd.DataFrame, measure: Measure, methods: Sequence[str]) -> Chart:
    """Medians over the runs of what they had at a cost, quartiles as bands.

    A panel for each group of instances.
    """
    stacks = []
    for group in dict.fromkeys(frame["family"]):
        elements: list[Element] = []
        for target in measure.targets:
            elements.append(Level(at=target, dash="solid" if target == measure.main else "dot", width=0.5))
        for method, rows in _rows(frame, group, methods):
            ends = rows[[f"{measure.name}_{name}" for name in ("q1", "median", "q3")]]
            elements += _banded(
                rows, methods, method, ends.clip(lower=LEAST).replace(np.inf, np.nan), len(methods) <= BANDED
            )
        y = Axis(f"{measure.name}, at least {LEAST:g}", "log", group="measure", better="low")
        stacks.append((Panel(tuple(elements), Axis(COST, "log", group="cost"), y, group, 2.9),))
    bands = ", quartiles as bands" if len(methods) <= BANDED else ""
    said = f"Median {measure.name} of the best point so far against the cost{bands}; lines across: targets, of which the main one is drawn through."
    return _chart("At any time", said, stacks, methods, "instances")


def profiles_chart(frame: pd.DataFrame, measure: Measure, methods: Sequence[str]) -> Chart:
    """Performance and data profile over all instances."""
    stacks = []
    for profile, label in PROFILES.items():
        of = frame[frame["profile"] == profile]
        lines = [_line(rows["at"], 100 * rows["share"], methods, method) for method, rows in _rows(of, "all", methods)]
        y = Axis("instances (%)", low=-2, high=102, group="share", better="high")
        stacks.append((Panel(tuple(lines), Axis(label, "log"), y, f"{profile.capitalize()} profile", 2.9),))
    said = f"Share of instances with {measure.name} ≤ {measure.main:g} within this cost."
    return _chart("Performance and data profile", said, stacks, methods)


def ranks_chart(board: pd.DataFrame, pairs: pd.DataFrame) -> Chart:
    """Mean ranks over all instances with their intervals, a panel for each criterion.

    Bars join methods that no test tells apart (critical-difference diagram: Demšar, J. Mach. Learn. Res. 7 (2006)
    1–30).
    """
    names = [name for name in WORDS if f"{name}_rank" in board]
    rows = board[board["family"] == "all"]
    stacks = []
    for name in names:
        ordered = rows.sort_values(f"{name}_rank", kind="stable")
        methods = ordered["method"].tolist()
        mean, low, high = (ordered[f"{name}_rank{end}"].to_numpy(float) for end in ("", "_low", "_high"))
        said = [f"{method}: {rank:.2f}" for method, rank in zip(methods, mean)]
        elements: list[Element] = [Points(mean, np.arange(len(methods), dtype=float), left=low, right=high, said=said)]
        alike = cliques(methods, pairs[(pairs["family"] == "all") & (pairs["criterion"] == name)])
        for number, clique in enumerate(alike):
            x, first = len(methods) + 0.5 + 0.35 * number, methods.index(clique[0])
            elements.append(Line([x, x], [first - 0.3, first + len(clique) - 0.7], width=4.0, colour=INTERVAL))
        x_axis = Axis(
            "mean rank (1: best)",
            low=0.7,
            high=len(methods) + 0.8 + 0.35 * max(len(alike), 1),
            is_whole=True,
            better="low",
        )
        y = Axis(
            low=-0.6,
            high=len(methods) - 0.4,
            ticks={float(at): method for at, method in enumerate(methods)},
            is_reversed=True,
        )
        stacks.append((Panel(tuple(elements), x_axis, y, fill(WORDS[name], TITLE), 0.3 + 0.3 * len(methods)),))
    said_of_all = "Mean rank of each method over all instances with its 95 % interval; green bars join methods that no test tells apart."
    return Chart("Mean ranks", said_of_all, tuple(stacks), len(stacks), 4.2 * len(stacks) + 0.5)


def price_chart(board: pd.DataFrame, measure: Measure, methods: Sequence[str]) -> Chart:
    """Expected time to the main target against the price of one evaluation, over all instances.

    Methods that no run of reaches it have no line.
    """
    rows = board[board["family"] == "all"].set_index("method")
    lines = []
    for method in methods:
        total = rows.loc[method, f"{measure.name}_ert"] * PRICES + rows.loc[method, "overhead_s"]
        if np.isfinite(total).all():
            lines.append(_line(PRICES, total, methods, method, is_stepped=False))
    x = Axis("price of one evaluation of the true model (s)", "log")
    y = Axis(f"expected time to {measure.name} ≤ {measure.main:g} (s)", "log", better="low")
    return _chart(
        "Time",
        "Expected time to the main target against the price of one evaluation.",
        [(Panel(tuple(lines), x, y),)],
        methods,
    )


def _rows(frame: pd.DataFrame, group: str, methods: Sequence[str]) -> Iterator[tuple[str, pd.DataFrame]]:
    for method in methods:
        yield method, frame[(frame["family"] == group) & (frame["method"] == method)]


def _banded(
    rows: pd.DataFrame, methods: Sequence[str], method: str, ends: pd.DataFrame, has_band: bool = True
) -> list[Element]:
    """A line in its band; `ends` are low, middle and high."""
    low, middle, high = ends.to_numpy(float).T
    cost = rows["cost_per_unknown"].to_numpy(float)
    line = _line(cost, middle, methods, method)
    return (
        [Band(cost, low, high, is_stepped=True, colour=line.colour, opacity=0.8, tags=line.tags), line]
        if has_band
        else [line]
    )


def _line(
    x: Array | pd.Series, y: Array | pd.Series, methods: Sequence[str], method: str, *, is_stepped: bool = True
) -> Line:
    colour, dash = styles(methods)[method]
    values = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    look: dict[str, Any] = {"symbol": symbol(methods.index(method)), "most_symbols": MARKED, "colour": colour}
    return Line(*values, dash, 1.5, is_stepped=is_stepped, name=method, tags={"method": method}, **look)


def _chart(
    title: str, caption: str, stacks: Sequence[tuple[Panel, ...]], methods: Sequence[str], of_stacks: str = ""
) -> Chart:
    across = min(COLUMNS, len(stacks))
    choices = (Choice("method", "method", tuple(methods)),) if len(methods) > 1 else ()
    return Chart(title, caption, tuple(stacks), across, max(WIDTH * across, 7.0), choices, of_stacks, most=len(stacks))
