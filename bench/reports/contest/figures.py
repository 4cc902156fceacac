"""Figures of a contest: curves over the cost, profiles over the instances, mean ranks, and time against the model's price."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.reports.contest.drawing import draw_line, panels_of, styles
from bench.reports.contest.paired_tests import cliques
from bench.reports.contest.scores import WORDS
from bench.reports.contest.targets import Measure
from ksmea.show.charts.locators import plain_ticks
from ksmea.show.figures.style import INTERVAL, REFERENCE

COST = "evaluations / unknowns"
LEAST = 1e-3  # of a measure, below which the data see no difference: drawn as this
BANDED = 7  # methods, beyond which bands of quartiles would hide the lines
PRICES = np.logspace(-6, np.log10(3600), 200)  # s per evaluation: from a microsecond to an hour
PROFILES = {
    "performance": "expected running time / that of the fastest (performance profile)",
    "data": "expected running time in simplex gradients of d + 1 evaluations (data profile)",
}


def ecdf_figure(frame: pd.DataFrame, measure: Measure, methods: Sequence[str]) -> Figure:
    """Share of targets and runs that are reached, with bands over instances; a panel for each group of instances."""
    mine = frame[frame["measure"] == measure.name]
    figure, panels = panels_of(list(dict.fromkeys(mine["family"])), methods)
    for group, axes in panels.items():
        for number, (method, style) in enumerate(styles(methods).items()):
            rows = mine[(mine["family"] == group) & (mine["method"] == method)]
            cost = rows["cost_per_unknown"].to_numpy()
            draw_line(axes, cost, rows["share"].to_numpy(), style, number)
            _band(axes, cost, rows["low"], rows["high"], style.colour)
        axes.set(xscale="log", ylim=(-0.02, 1.02), title=group)
        plain_ticks(axes.xaxis)
        axes.grid(alpha=0.25)
    figure.supxlabel(COST, fontsize=10)
    figure.supylabel(f"targets and runs reached ({measure.name} {_ends(measure)}), 95 % bands", fontsize=10)
    return figure


def _ends(measure: Measure) -> str:
    return f"{measure.targets[0]:g} … {measure.targets[-1]:g}"


def _band(axes: Axes, x: np.ndarray, low: pd.Series, high: pd.Series, colour: str) -> None:
    axes.fill_between(x, low.to_numpy(), high.to_numpy(), step="post", color=colour, alpha=0.12, linewidth=0)


def anytime_figure(frame: pd.DataFrame, measure: Measure, methods: Sequence[str]) -> Figure:
    """Medians over the runs of what they had at a cost, quartiles as bands; a panel for each group of instances."""
    figure, panels = panels_of(list(dict.fromkeys(frame["family"])), methods)
    for group, axes in panels.items():
        for number, (method, style) in enumerate(styles(methods).items()):
            rows = frame[(frame["family"] == group) & (frame["method"] == method)]
            cost = rows["cost_per_unknown"].to_numpy()
            low, middle, high = (
                rows[f"{measure.name}_{name}"].clip(lower=LEAST).replace(np.inf, np.nan)
                for name in ("q1", "median", "q3")
            )
            draw_line(axes, cost, middle.to_numpy(), style, number)
            if len(methods) <= BANDED:
                _band(axes, cost, low, high, style.colour)
        for target in measure.targets:
            axes.axhline(target, color=REFERENCE, linewidth=0.5, linestyle=":" if target != measure.main else "-")
        axes.set(xscale="log", yscale="log", title=group)
        plain_ticks(axes.xaxis)
        plain_ticks(axes.yaxis)
    figure.supxlabel(COST, fontsize=10)
    bands = ", quartiles as bands" if len(methods) <= BANDED else ""
    figure.supylabel(f"{measure.name}, at least {LEAST:g}: medians{bands}", fontsize=10)
    return figure


def profiles_figure(frame: pd.DataFrame, measure: Measure, methods: Sequence[str]) -> Figure:
    """Performance and data profile over all instances."""
    figure, panels = panels_of(list(PROFILES), methods)
    for profile, axes in panels.items():
        for number, (method, style) in enumerate(styles(methods).items()):
            rows = frame[(frame["family"] == "all") & (frame["method"] == method) & (frame["profile"] == profile)]
            draw_line(axes, rows["at"].to_numpy(), rows["share"].to_numpy(), style, number)
        axes.set(xscale="log", ylim=(-0.02, 1.02))
        plain_ticks(axes.xaxis)
        axes.set_xlabel(PROFILES[profile], fontsize=8)
        axes.grid(alpha=0.25)
    figure.supylabel(f"share of instances, {measure.name} ≤ {measure.main:g}", fontsize=10)
    return figure


def ranks_figure(board: pd.DataFrame, pairs: pd.DataFrame) -> Figure:
    """Mean ranks over all instances with their intervals, a panel for each criterion; bars join methods that no test tells
    apart (critical-difference diagram: Demšar, J. Mach. Learn. Res. 7 (2006) 1–30)."""
    names = [name for name in WORDS if f"{name}_rank" in board]
    rows = board[board["family"] == "all"]
    figure = Figure(figsize=(4.2 * len(names) + 0.5, 0.9 + 0.32 * len(rows)), layout="constrained")
    for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names):
        ordered = rows.sort_values(f"{name}_rank", kind="stable")
        mean, low, high = (ordered[f"{name}_rank{end}"].to_numpy() for end in ("", "_low", "_high"))
        at = np.arange(len(ordered))
        axes.errorbar(mean, at, xerr=[mean - low, high - mean], fmt="o", markersize=5, color=styles([""])[""].colour)
        mine = pairs[(pairs["family"] == "all") & (pairs["criterion"] == name)]
        alike = cliques(ordered["method"].tolist(), mine)
        for number, clique in enumerate(alike):
            first = ordered["method"].tolist().index(clique[0])
            x = len(ordered) + 0.5 + 0.35 * number
            axes.plot(
                [x, x], [first - 0.3, first + len(clique) - 0.7], color=INTERVAL, linewidth=4, solid_capstyle="butt"
            )
        axes.set_yticks(at, ordered["method"], fontsize=8)
        axes.set_xlim(0.7, len(ordered) + 0.8 + 0.35 * max(len(alike), 1))
        axes.set_xticks(range(1, len(ordered) + 1), [str(each) for each in range(1, len(ordered) + 1)], fontsize=8)
        axes.invert_yaxis()
        axes.set_title(WORDS[name], fontsize=9)
        axes.grid(axis="x", alpha=0.25)
    figure.supxlabel(
        "mean rank (1: best) with 95 % interval; green bars join methods that no test tells apart", fontsize=9
    )
    return figure


def price_figure(board: pd.DataFrame, measure: Measure, methods: Sequence[str]) -> Figure:
    """Expected time to the main target against the price of one evaluation, over all instances; methods that no run of reaches
    it have no line."""
    rows = board[board["family"] == "all"].set_index("method")
    figure, panels = panels_of(["all"], methods)
    axes = panels["all"]
    for number, (method, style) in enumerate(styles(methods).items()):
        total = rows.loc[method, f"{measure.name}_ert"] * PRICES + rows.loc[method, "overhead_s"]
        if np.isfinite(total).all():
            draw_line(axes, PRICES, total, style, number)
    axes.set(xscale="log", yscale="log")
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    axes.set_xlabel("price of one evaluation of the true model (s)", fontsize=9)
    axes.set_ylabel(f"expected time to {measure.name} ≤ {measure.main:g} (s)", fontsize=9)
    axes.grid(alpha=0.25)
    return figure
