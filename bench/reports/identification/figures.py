"""Figures from tables; drawn without a display."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bench.jobs.lines import RESULTS
from bench.plan.naming import place_text, telling_axes
from bench.plan.plan import Plan
from bench.reports.plots.interval_ends import drawn_ends
from bench.reports.tables import EFFORT, EXACT, has_intervals, lacks_interval
from ksmea.show.charts.ticks import plain_ticks
from ksmea.show.figures.style import INTERVAL, OURS, PAPER, REFERENCE

COLUMNS = 3  # of panels: more are too small to read on a page
MAX_LABELS = 12  # more cells than this are numbered, not named


def summary_figure(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame) -> Figure:
    """A panel per parameter (and updates, evaluations, time): box plots over the repetitions, the paper's values. Cells
    whose problem has not the parameter, or has it in another unit, are no part of its panel."""
    names = list(dict.fromkeys(zip(summary["parameter"], summary["unit"])))
    columns = min(COLUMNS, len(names))
    n_row = -(-len(names) // columns)
    figure = Figure(figsize=(2.9 * columns, 2.7 * n_row + 0.6), layout="constrained")
    panels = figure.subplots(n_row, columns, squeeze=False).ravel()
    for panel, (name, unit) in zip(panels, names):
        rows = summary[(summary["parameter"] == name) & (summary["unit"] == unit)]
        _panel(panel, plan, runs, rows, cells_with(plan, name, unit))
    for panel in panels[len(names) :]:
        panel.set_axis_off()
    handles, labels = panels[0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    repetitions = int(runs.groupby("cell").size().max())
    plural = "s" if repetitions > 1 else ""
    figure.suptitle(f"{plan.name}: medians, quartiles and extremes of {repetitions} repetition{plural}")
    return figure


def cells_with(plan: Plan, name: str, unit: str) -> list[int]:
    """The cells that a table has a row of this name and unit for: all, of a row that is no parameter."""
    if name in EFFORT | EXACT:
        return list(range(len(plan.cells)))
    return [
        index
        for index, cell in enumerate(plan.cells)
        if any((facts.name, facts.unit) == (name, unit) for facts in cell.parameters)
    ]


def _panel(panel: Axes, plan: Plan, runs: pd.DataFrame, rows: pd.DataFrame, cells: list[int]) -> None:
    name, unit = rows["parameter"].iloc[0], rows["unit"].iloc[0]
    results = runs[runs["status"].isin(RESULTS)]
    positions = np.arange(1, len(rows) + 1)
    values = [
        results.loc[results["cell"] == cell, name].dropna().to_numpy(float) if name in results else np.array([])
        for cell in cells
    ]
    panel.boxplot(
        values,
        positions=positions,
        widths=0.55,
        whis=(0, 100),
        medianprops={"color": OURS, "linewidth": 2},
        boxprops={"color": OURS},
        whiskerprops={"color": OURS},
        capprops={"color": OURS},
    )
    panel.plot([], [], color=OURS, linewidth=2, label="this bench")
    if has_intervals(rows):
        _draw_intervals(panel, positions, rows, results[results["cell"].isin(cells)])
    if rows["reference"].notna().any():
        panel.hlines(
            rows["reference"], positions - 0.45, positions + 0.45, color=REFERENCE, linestyle=":", label="reference"
        )
    if rows["paper"].notna().any():
        panel.plot(positions, rows["paper"], "D", color=PAPER, markersize=5, label="paper")
        if name == "time":
            panel.set_yscale("log")
            plain_ticks(panel.yaxis)
    panel.set_title(f"{name} ({unit})" if unit else name.replace("_", " "), fontsize=10)
    labels = _labels(plan, cells)
    panel.set_xticks(positions, labels, fontsize=8, rotation=0 if max(map(len, labels)) < 6 else 60)
    panel.set_xlabel(" / ".join(telling_axes(plan)), fontsize=8)
    panel.tick_params(axis="y", labelsize=8)
    panel.grid(axis="y", alpha=0.25)
    if name in EFFORT and not unit:
        panel.yaxis.set_major_locator(MaxNLocator(integer=True))


def _draw_intervals(panel: Axes, positions: np.ndarray, rows: pd.DataFrame, results: pd.DataFrame) -> None:
    """The median interval of each cell beside its box; an arrow where the side is open."""
    values = np.concatenate([results[rows["parameter"].iloc[0]], rows["reference"], rows["paper"]]).astype(float)
    has_interval = ~lacks_interval(rows).to_numpy(bool)
    positions, rows = positions[has_interval], rows[has_interval]
    low, high = drawn_ends(rows["low"].to_numpy(float), rows["high"].to_numpy(float), values)
    panel.vlines(positions + 0.4, low, high, color=INTERVAL, linewidth=2, label="median interval (arrow: open side)")
    for ends, marker, is_open in ((low, "v", rows["low"].isna()), (high, "^", rows["high"].isna())):
        panel.plot((positions + 0.4)[is_open], ends[is_open], marker, color=INTERVAL, markersize=4)


def _labels(plan: Plan, cells: list[int]) -> list[str]:
    if len(cells) > MAX_LABELS:
        return [str(cell + 1) if position % 5 == 0 else "" for position, cell in enumerate(cells)]
    axes = telling_axes(plan)
    return [" / ".join(place_text(plan.cells[cell].place.get(axis)) for axis in axes) for cell in cells]
