"""Sections on a fleet: the table of all machines, their unknowns side by side, and the whole text of each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from bench.plan.page import Folded, Grid, Page, Plot, Prose, Section, Table
from bench.reports.plots.traces import BLUE, axis, layout
from ksmea.show.text import with_ends

MOST_NAMED = 12  # machines whose names stand below the axis


def fleet_page(
    about: str, table: pd.DataFrame, values: pd.DataFrame, details: Sequence[tuple[str, str]], file: str, still: str
) -> Page:
    """`values` are the unknowns of each machine with their intervals, `details` the title and the text of each."""
    sections = [Section("Machines", (Table(table, file=file),))]
    if len(values):
        unknowns = dict.fromkeys(values[["name", "unit"]].itertuples(index=False, name=None))
        plots = [
            _plot(values, name, unit, still if number == 0 else "") for number, (name, unit) in enumerate(unknowns)
        ]
        sections.append(Section("Unknowns", (Grid(tuple(plots)),)))
    if details:
        sections.append(Section("Each machine", tuple(Folded(title, (Prose(text),)) for title, text in details)))
    return Page(about, tuple(sections))


def _plot(values: pd.DataFrame, name: str, unit: str, still: str) -> Plot:
    """The interval of one unknown for each machine; an end that is open reaches to the farthest value."""
    mine = values[(values["name"] == name) & (values["unit"] == unit)]
    value, low, high = (mine[column].to_numpy(float) for column in ("value", "low", "high"))
    texts = [with_ends(*each) for each in zip(value, low, high)]
    ends = np.concatenate([value, low, high])
    low, high = np.where(np.isnan(low), np.nanmin(ends), low), np.where(np.isnan(high), np.nanmax(ends), high)
    machines = mine["file"].astype(str).tolist()
    trace = {
        "type": "scatter", "mode": "markers", "x": machines, "y": value, "name": name, "marker": {"color": BLUE, "size": 7},
        "error_y": {"type": "data", "symmetric": False, "array": high - value, "arrayminus": value - low, "thickness": 1.5},
        "text": texts, "hovertemplate": "%{x}: %{text}<extra></extra>",
    }  # fmt: skip
    made = layout("", f"{name} ({unit})", showlegend=False)
    made["xaxis"] = axis(
        "" if len(machines) <= MOST_NAMED else "machine", type="category", showticklabels=len(machines) <= MOST_NAMED
    )
    return Plot(
        f"{name} ({unit})",
        f"{name} of each machine with its interval.",
        {"data": [trace], "layout": made},
        still,
        height=310,
    )
