"""Anytime figure: excess and error of the best point so far against the cost, a line for each method."""

from __future__ import annotations

from itertools import cycle

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.plan.naming import cell_name
from bench.plan.plan import Plan
from ksmea.show.charts.ticks import plain_ticks
from ksmea.show.figures.style import COLOURS, REFERENCE

MAX_LINES = 14  # cells in one figure; more would be a tangle, and the table has all
LEAST_EXCESS = 1e-3  # of a deviance, below which the data see no difference: drawn as this
LINES = ("-", "--")  # of the first cells, and of those behind whose colours are the same
LABELS = {
    "excess": "misfit above its least",
    "error": "rms error of the unknowns (CRLB)",
}


def trace_figure(plan: Plan, frame: pd.DataFrame, stages: pd.DataFrame) -> Figure:
    """Medians as lines and quartiles as bands; a dot where a stage of the method ended and another followed, a cross where the
    last run ended."""
    figure = Figure(figsize=(9.6, 5.0), layout="constrained")
    panels = figure.subplots(1, 2)
    styles = [(line, colour) for line in LINES for colour in COLOURS]
    for (line, colour), (cell, rows) in zip(cycle(styles), list(frame.groupby("cell"))[:MAX_LINES]):
        label = cell_name(plan, plan.cells[cell])
        ends = stages[(stages["cell"] == cell) & ~stages["on_surrogate"].astype(bool)].iloc[:-1]
        for panel, column in zip(panels, LABELS):
            _draw(panel, rows, ends, column, line, colour, label)
    price = sorted(set(frame["jacobian_price"]))
    for panel, (column, label) in zip(panels, LABELS.items()):
        panel.set_xscale("log")
        panel.set_yscale("log")
        plain_ticks(panel.xaxis)
        plain_ticks(panel.yaxis)
        panel.axhline(1.0, color=REFERENCE, linestyle=":", linewidth=1)
        panel.set_xlabel(f"evaluations of the true model, a Jacobian as {' or '.join(map(str, price))}")
        panel.set_ylabel(label + (f", at least {LEAST_EXCESS:g}" if column == "excess" else ""))
        panel.grid(alpha=0.25)
    panels[0].legend(fontsize=8)
    hidden = len(set(frame["cell"])) - MAX_LINES
    figure.suptitle(
        f"{plan.name}: the best point so far, medians and quartiles of {int(frame['runs'].max())} runs"
        + (f"; {hidden} more in the table" if hidden > 0 else ""),
        fontsize=10,
    )
    return figure


def _draw(panel: Axes, rows: pd.DataFrame, ends: pd.DataFrame, column: str, line: str, colour: str, label: str) -> None:
    cost = rows["cost"].to_numpy()
    low, middle, high = (_drawn(rows[f"{column}_{name}"].to_numpy(), column) for name in ("q1", "median", "q3"))
    panel.step(cost, middle, line, where="post", color=colour, linewidth=1.6, label=label)
    panel.plot(cost[-1], middle[-1], "x", color=colour, markersize=5)
    panel.fill_between(cost, low, high, step="post", color=colour, alpha=0.15, linewidth=0)
    at = ends["evaluations"] + rows["jacobian_price"].iloc[0] * ends["jacobians"]
    behind = np.searchsorted(cost, at, side="right") - 1
    panel.plot(at[behind >= 0], middle[behind[behind >= 0]], "o", color=colour, markersize=5)


def _drawn(values: np.ndarray, column: str) -> np.ndarray:
    """Values as a logarithmic axis can show them: what is infinitely far is not."""
    shown = np.maximum(values, LEAST_EXCESS) if column == "excess" else values
    return np.where(np.isfinite(shown), shown, np.nan)
