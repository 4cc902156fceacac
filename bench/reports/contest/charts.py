"""Charts of a contest: runs solved, curves over cost, profiles, ranks, and time by the model's price.

Profiles are over the instances. Curves of the first methods have colours, other curves are grey.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from textwrap import fill
from typing import Any

import numpy as np
import pandas as pd

from bench.reports.contest.paired_tests import cliques
from bench.reports.contest.scores import WORDS
from bench.reports.contest.targets import Measure
from ksmea.arrays import Array
from ksmea.show.charts.chart import Axis, Band, Chart, Choice, Element, Level, Line, Panel, Points, Words, named_rows
from ksmea.show.charts.colours import CONTEXT, INTERVAL, PAPER, styles, symbol

COST = "evaluations / unknowns"
LEAST = 1e-3  # of a measure, below which the data see no difference: drawn as this
COLOURED = 4  # methods, the first ones, whose curves have a colour; more could not be told apart
OTHERS = "others"
BEYOND = 1.6  # times the largest cost: where an open interval ends
PRICES = np.logspace(-6, np.log10(3600), 200)  # s per evaluation: from a microsecond to an hour
PROFILES = {
    "performance": "expected running time / fastest",
    "data": "expected running time in simplex gradients of d + 1 evaluations",
}
MARKED = 5  # points of a line with the symbol of its method
TITLE = 26  # characters in a line of a title, three panels side by side
COLUMNS, WIDTH = 2, 4.6  # panels side by side, and inches of each


def solved_chart(board: pd.DataFrame, pairs: pd.DataFrame, measure: Measure, title: str) -> Chart:
    """Runs that each method solves, its evaluations to solve one, and its time, over all instances.

    Rows are in the order of the first criterion; methods that tie share a rank.
    """
    rows = board[board["family"] == "all"].reset_index(drop=True)
    at = np.arange(len(rows), dtype=float)
    y = named_rows(_ranked(rows, measure), group="method")
    share, low, high = (100 * rows[f"{measure.name}_reached{end}"].to_numpy(float) for end in ("", "_low", "_high"))
    counts = [f"{part * runs / 100:.0f} of {runs:.0f}" for part, runs in zip(share, rows["runs"])]
    solved: list[Element] = [Points(share, at, left=low, right=high, said=counts)]
    bars = _bars(rows["method"].tolist(), pairs, measure.name, 106.0, 4.0, width=3.0)
    solved += bars
    x_solved = Axis("%", low=-4.0, high=106.0 + 4.0 * max(len(bars), 1), ticks={0.0: "0", 50.0: "50", 100.0: "100"})
    tall = 0.3 * len(rows) + 0.3
    target = f"{measure.name} ≤ {measure.main:g}"
    panels = (
        Panel(tuple(solved), x_solved, y, f"runs that reach {target}", tall),
        Panel(tuple(_costs(rows, measure, at)), Axis("", "log", better="low"), y, "evaluations to reach it once", tall),
        Panel((Points(rows["seconds"], at, said="{x:.3g} s"),), Axis("", "log"), y, "time of a run (s)", tall),
    )
    apart = (
        "Green bars join methods that no test separates."
        if bars
        else "Tests separate any two methods." * (len(rows) > 1)
    )
    caption = (
        f"Dots with 95 % intervals over all instances; the rank, before the name, is by the mean rank of the {measure.name} at the"
        f" end, '=' of methods that tie. Evaluations: expected ones until a run reaches the target. {apart}"
    )
    return Chart(title, caption, tuple((panel,) for panel in panels), len(panels), 10.5, most=len(panels))


def _ranked(rows: pd.DataFrame, measure: Measure) -> list[str]:
    """Names of methods behind their ranks, for example '=1 LM' if two or more tie."""
    means = rows[f"{measure.name}_rank"].round(2).to_numpy(float)
    return [
        f"{'=' if np.sum(means == mean) > 1 else ''}{1 + int(np.sum(means < mean))} {method}"
        for method, mean in zip(rows["method"], means)
    ]


def _costs(rows: pd.DataFrame, measure: Measure, at: Array) -> Iterator[Element]:
    """Expected evaluations to the target, open intervals with an arrow, and which methods never reach it."""
    cost, low, high = (rows[f"{measure.name}_ert{end}"].to_numpy(float) for end in ("", "_low", "_high"))
    known = np.isfinite(cost)
    ends = np.concatenate([cost, low, high])
    ends = ends[np.isfinite(ends)]
    edge = BEYOND * ends.max() if len(ends) else 1.0
    is_open = known & ~np.isfinite(high)
    right = np.where(np.isfinite(high), high, edge)
    said = [f"{each:.0f} evaluations" for each in cost[known]]
    yield Points(cost[known], at[known], left=low[known], right=right[known], said=said)
    if is_open.any():
        yield Points(np.full(int(is_open.sum()), edge), at[is_open], "triangle right", 6.0)
    for row in at[~known]:
        yield Words(x=edge, y=float(row), text="never", side="right", colour=PAPER)


def _bars(
    methods: Sequence[str], pairs: pd.DataFrame, criterion: str, start: float, step: float, *, width: float
) -> list[Line]:
    """Bars next to the rows of methods that no test separates, the first at `start`."""
    alike = cliques(methods, pairs[(pairs["family"] == "all") & (pairs["criterion"] == criterion)])
    bars: list[Line] = []
    for clique in alike:
        x, first = start + step * len(bars), methods.index(clique[0])
        bars.append(Line([x, x], [first - 0.3, first + len(clique) - 0.7], width=width, colour=INTERVAL))
    return bars


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
            for each in _banded(
                rows, methods, method, 100 * rows[["low", "share", "high"]], has_band=_has_colour(methods, method)
            )
        ]
        y = Axis("targets and runs reached (%)", low=-2, high=102, group="share", better="high")
        stacks.append((Panel(tuple(elements), Axis(COST, "log", group="cost"), y, group, 2.9),))
    said = (
        f"Share of targets ({measure.name} {measure.targets[0]:g} … {measure.targets[-1]:g}) and runs reached against the cost, with"
        f" 95 % bands{_grey(methods)}."
    )
    return _chart(_reached_finding(mine, measure, methods), said, stacks, methods, "instances")


def _reached_finding(frame: pd.DataFrame, measure: Measure, methods: Sequence[str]) -> str:
    """The method with the largest share of targets reached at the end, and its share."""
    group = frame["family"].iloc[0]
    ends = {method: 100 * float(rows["share"].iloc[-1]) for method, rows in _rows(frame, group, methods) if len(rows)}
    best = max(ends.values(), default=0.0)
    names = [method for method in methods if ends.get(method) == best]
    more = f" and {len(names) - 1} more reach" if len(names) > 1 else " reaches"
    return f"{names[0] if names else 'No method'}{more} {best:.0f} % of the targets of the {measure.name}"


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
                rows,
                methods,
                method,
                ends.clip(lower=LEAST).replace(np.inf, np.nan),
                has_band=_has_colour(methods, method),
            )
        y = Axis(f"{measure.name}, at least {LEAST:g}", "log", group="measure", better="low")
        stacks.append((Panel(tuple(elements), Axis(COST, "log", group="cost"), y, group, 2.9),))
    said = (
        f"Median {measure.name} of the best point so far against the cost, quartiles as bands; lines across: targets, of which the"
        f" main one is drawn through{_grey(methods)}."
    )
    return _chart(f"Median {measure.name} at any cost", said, stacks, methods, "instances")


def profiles_chart(frame: pd.DataFrame, measure: Measure, methods: Sequence[str]) -> Chart:
    """Performance and data profile over all instances."""
    stacks = []
    for profile, label in PROFILES.items():
        of = frame[frame["profile"] == profile]
        lines = [_line(rows["at"], 100 * rows["share"], methods, method) for method, rows in _rows(of, "all", methods)]
        y = Axis("instances (%)", low=-2, high=102, group="share", better="high")
        stacks.append((Panel(tuple(lines), Axis(label, "log"), y, f"{profile.capitalize()} profile", 2.9),))
    said = f"Share of instances with {measure.name} ≤ {measure.main:g} within this cost{_grey(methods)}."
    return _chart("Performance and data profile", said, stacks, methods)


def ranks_chart(board: pd.DataFrame, pairs: pd.DataFrame) -> Chart:
    """Mean ranks over all instances with their intervals, a panel for each criterion.

    Bars join methods that no test tells apart (critical-difference diagram: Demšar, J. Mach. Learn. Res. 7 (2006)
    1–30).
    """
    names = [name for name in WORDS if f"{name}_rank" in board]
    rows = board[board["family"] == "all"]
    stacks, has_bars = [], False
    for name in names:
        ordered = rows.sort_values(f"{name}_rank", kind="stable")
        methods = ordered["method"].tolist()
        mean, low, high = (ordered[f"{name}_rank{end}"].to_numpy(float) for end in ("", "_low", "_high"))
        said = [f"{method}: {rank:.2f}" for method, rank in zip(methods, mean)]
        elements: list[Element] = [Points(mean, np.arange(len(methods), dtype=float), left=low, right=high, said=said)]
        bars = _bars(methods, pairs, name, len(methods) + 0.5, 0.35, width=4.0)
        elements += bars
        has_bars |= bool(bars)
        x_axis = Axis(
            "mean rank (1: best)",
            low=0.7,
            high=len(methods) + 0.8 + 0.35 * max(len(bars), 1),
            is_whole=True,
            better="low",
        )
        stacks.append(
            (Panel(tuple(elements), x_axis, named_rows(methods), fill(WORDS[name], TITLE), 0.3 + 0.3 * len(methods)),)
        )
    apart = "green bars join methods that no test separates" if has_bars else "tests separate any two"
    said_of_all = f"Mean rank of each method over all instances with its 95 % interval; {apart}."
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
        f"Expected time to the main target against the price of one evaluation{_grey(methods)}.",
        [(Panel(tuple(lines), x, y),)],
        methods,
    )


def _rows(frame: pd.DataFrame, group: str, methods: Sequence[str]) -> Iterator[tuple[str, pd.DataFrame]]:
    """Rows of each method, of those with a colour last, so that their curves lie above the grey ones."""
    for method in sorted(methods, key=partial(_has_colour, methods)):
        yield method, frame[(frame["family"] == group) & (frame["method"] == method)]


def _has_colour(methods: Sequence[str], method: str) -> bool:
    return methods.index(method) < COLOURED


def _grey(methods: Sequence[str]) -> str:
    """Words on grey curves, if there are any."""
    return f"; in colour the first {COLOURED}, others grey, named on touch" if len(methods) > COLOURED else ""


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
    values = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    tags = {"method": method}
    if not _has_colour(methods, method):
        return Line(
            *values, "solid", 0.8, is_stepped=is_stepped, name=OTHERS, colour=CONTEXT, opacity=0.7, tags=tags, said=method
        )  # fmt: skip
    colour, dash = styles(methods)[method]
    look: dict[str, Any] = {"symbol": symbol(methods.index(method)), "most_symbols": MARKED, "colour": colour}
    return Line(*values, dash, 1.5, is_stepped=is_stepped, name=method, tags=tags, said=f"{method}: {{y:.3g}}", **look)


def _chart(
    title: str, caption: str, stacks: Sequence[tuple[Panel, ...]], methods: Sequence[str], of_stacks: str = ""
) -> Chart:
    across = min(COLUMNS, len(stacks))
    choices = (Choice("method", "method", tuple(methods)),) if len(methods) > 1 else ()
    return Chart(title, caption, tuple(stacks), across, max(WIDTH * across, 7.0), choices, of_stacks, most=len(stacks))
