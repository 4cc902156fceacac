"""The ratios of a table on a logarithmic axis, a panel for each group; drawn without a display."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from benchmarks.harness.report import number, title_of
from benchmarks.harness.table import PART
from ksmea.show.figures.style import OURS, PAPER, REFERENCE

ROW_HEIGHT, WIDTH = 0.24, 11.0  # inches
MAX_NAME = 78


def ratio_figure(frame: pd.DataFrame) -> Figure:
    """A dot for each contestant beside ours, with the quartiles of its ratio; a mark where a demand lies."""
    shown = frame[frame["ratio"].notna() & (frame["note"] != PART)]
    groups = list(shown.groupby("group", sort=False))
    if not groups:
        figure = Figure(figsize=(WIDTH, 1.0))
        figure.text(0.5, 0.5, "no contestant beside ours was measured", ha="center")
        return figure
    heights = [len(rows) + 2 for _, rows in groups]
    figure = Figure(figsize=(WIDTH, ROW_HEIGHT * sum(heights) + 0.8), layout="constrained")
    panels = figure.subplots(len(groups), 1, height_ratios=heights, squeeze=False, sharex=True).ravel()
    for panel, (group, rows) in zip(panels, groups):
        places = np.arange(len(rows))[::-1]
        ratio = rows["ratio"].to_numpy()
        spread = [ratio - rows["ratio_q1"].to_numpy(), rows["ratio_q3"].to_numpy() - ratio]
        colours = [OURS if value >= 1 else PAPER for value in ratio]
        panel.errorbar(ratio, places, xerr=np.maximum(spread, 0), fmt="none", ecolor=REFERENCE, elinewidth=1)
        panel.scatter(ratio, places, c=colours, s=18, zorder=3)
        demanded = rows["at_least"].to_numpy()
        panel.plot(demanded, places, "|", color=REFERENCE, markersize=9)
        for value, end, place in zip(ratio, rows["ratio_q3"], places):
            panel.annotate(number(value), (end, place), (6, 0), textcoords="offset points", fontsize=7, va="center")
        panel.set_yticks(places, [_name(line) for _, line in rows.iterrows()], fontsize=7)
        panel.set_ylim(-0.7, len(rows) - 0.3)
        panel.set_xscale("log")
        panel.axvline(1.0, color=REFERENCE, linewidth=1)
        panel.grid(axis="x", alpha=0.25)
        panel.set_title(str(group), loc="left", fontsize=9, fontweight="bold")
    low, high = float(shown["ratio_q1"].min()), float(shown["ratio_q3"].max())
    panels[-1].set_xlim(min(low, 0.5) / 1.5, 10 ** (math.log10(max(high, 2.0)) * 1.15))
    panels[-1].set_xlabel(
        "their time over ours, paired by turn, with quartiles; right of 1, ours is faster; |: demanded"
    )
    return figure


def _name(line: pd.Series) -> str:
    name = f"{title_of(line).partition(': ')[2]} – {line['contestant']}"
    return name if len(name) <= MAX_NAME else f"{name[: MAX_NAME - 1]}…"
