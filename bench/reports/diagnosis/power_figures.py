"""Figures of what a diagnosis sees: detection against size, and what each hidden effect is called."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from bench.reports.diagnosis.power import DROP, EFFECT, SIZES, chance, detectable_drop
from bench.reports.tables import interval
from ksmea.show.figures.style import OURS, REFERENCE

COLUMNS = 5  # of small axes


def detection_figure(with_effect: pd.DataFrame) -> Figure:
    """The share of draws that are detected against size, per effect: 1 is the smallest detectable size, which nine of ten draws
    are expected to show. Bars are 95 % intervals, the line is what is expected."""
    effects = list(dict.fromkeys(with_effect[EFFECT]))
    columns = min(COLUMNS, len(effects))
    rows = math.ceil(len(effects) / columns)
    made = Figure(figsize=(2.5 * columns + 0.6, 1.9 * rows + 0.6), layout="constrained")
    grid = made.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    sizes = np.geomspace(min(0.5, with_effect["size"].min()), max(2.0, with_effect["size"].max()))
    for axes, effect in zip(grid.flat, effects):
        mine = with_effect[with_effect[EFFECT] == effect]
        unknowns, candidates, level = (mine[name].iloc[0] for name in ("unknowns", "candidates", "level"))
        needed = detectable_drop(unknowns, candidates, level)
        expected = [chance(size**2 * needed, unknowns, candidates, level) for size in sizes]
        axes.plot(sizes, 100 * np.array(expected), color=REFERENCE, lw=1)
        for _, at_drop in mine.groupby(DROP):
            n, seen = len(at_drop), int(at_drop["detected"].sum())
            low, high = interval(seen, n)
            ends = [[100 * (seen / n - low)], [100 * (high - seen / n)]]
            axes.errorbar(at_drop["size"].median(), 100 * seen / n, yerr=np.abs(ends), fmt="o", ms=4, lw=1, color=OURS)
        axes.axvline(1.0, color=REFERENCE, lw=0.8, ls=":")
        axes.set_title(effect, fontsize=8)
        axes.set(xscale="log", ylim=(-5, 105))
        axes.set_xticks(SIZES, [f"{size:g}" for size in SIZES])
        axes.minorticks_off()
    for axes in list(grid.flat)[len(effects) :]:
        axes.set_axis_off()
    made.supxlabel("size / smallest detectable size", fontsize=9)
    made.supylabel("detected, %, with 95 % intervals", fontsize=9)
    return made


def confusion_figure(shares: pd.DataFrame) -> Figure:
    """What each hidden effect (rows) is called (columns), in per cent of its clearly visible draws."""
    n_row, n_column = shares.shape
    made = Figure(figsize=(2.6 + 0.36 * n_column, 2.2 + 0.28 * n_row), layout="constrained")
    axes = made.subplots()
    image = axes.imshow(100 * shares.to_numpy(), cmap="Blues", vmin=0, vmax=100, aspect="auto")
    for (row, column), share in np.ndenumerate(shares.to_numpy()):
        if share:
            colour = "white" if share > 0.5 else "black"
            axes.text(column, row, f"{100 * share:.0f}", ha="center", va="center", fontsize=6, color=colour)
    axes.set_xticks(range(n_column), shares.columns, rotation=90, fontsize=7)
    axes.set_yticks(range(n_row), shares.index, fontsize=7)
    axes.set(xlabel="reported", ylabel="hidden")
    made.colorbar(image, ax=axes, shrink=0.6, label="% of clearly visible draws")
    return made
