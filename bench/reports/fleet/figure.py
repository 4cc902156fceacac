"""The unknowns of a fleet: an interval for each machine, one below the other for each unknown."""
# Shorter than 40 lines: one figure a file.

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ksmea.show.figures.style import OURS

MOST_NAMED = 40  # machines whose names stand below the axis; of more, their number
NAME = 24  # last characters of a name that are shown


def fleet_figure(values: pd.DataFrame) -> Figure:
    """Axes for each unknown, machines from left to right in the order of the table. An end that is open is an arrow to the
    edge."""
    files = list(dict.fromkeys(values["file"]))
    unknowns = values.drop_duplicates(["name", "unit"])[["name", "unit"]].to_numpy().tolist()
    width = float(np.clip(0.25 * len(files) + 2, 6, 14))
    made = Figure(figsize=(width, 1.5 * len(unknowns) + 1), layout="constrained")
    grid = made.subplots(len(unknowns), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (name, unit) in zip(grid, unknowns):
        mine = values[(values["name"] == name) & (values["unit"] == unit)]
        at = mine["file"].map(files.index).to_numpy(float)
        value, low, high = (mine[column].to_numpy(float) for column in ("value", "low", "high"))
        axes.plot(at, value, "o", ms=4, color=OURS)
        axes.vlines(at, np.where(np.isnan(low), value, low), np.where(np.isnan(high), value, high), color=OURS, lw=1)
        for is_open, marker in ((np.isnan(low) & ~np.isnan(high), "v"), (np.isnan(high) & ~np.isnan(low), "^")):
            axes.plot(at[is_open], value[is_open], marker, ms=7, color=OURS)
        axes.set_ylabel(f"{name} ({unit})")
        axes.grid(alpha=0.25)
    if len(files) <= MOST_NAMED:
        grid[-1].set_xticks(range(len(files)), [each[-NAME:] for each in files], rotation=60, ha="right", fontsize=7)
    else:
        grid[-1].set_xlabel("machine, in the order of the table")
    return made
