"""Sections on a fleet: table of all machines, their unknowns side by side, and the text of each."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd

from bench.plan.page import Drawn, Folded, Page, Prose, Section, Table
from ksmea.show.charts.chart import Axis, Chart, Element, Panel, Points
from ksmea.show.text import with_ends

MOST_NAMED = 40  # machines whose names stand below the axis; of more, their number
NAME = 24  # last characters of a name that are shown


def fleet_page(
    about: str, table: pd.DataFrame, values: pd.DataFrame, details: Sequence[tuple[str, str]], file: str, picture: str
) -> Page:
    """Page of a fleet.

    `values` are the unknowns of each machine with their intervals, `details` the title and the text of each.
    """
    sections = [Section("Machines", (Table(table, file=file),))]
    if len(values):
        sections.append(Section("Unknowns", (Drawn(partial(fleet_chart, values), picture),)))
    if details:
        sections.append(Section("Each machine", tuple(Folded(title, (Prose(text),)) for title, text in details)))
    return Page(about, tuple(sections))


def fleet_chart(values: pd.DataFrame) -> Chart:
    """Unknowns of a fleet: a panel for each unknown, machines in the order of the table.

    An open end is an arrow at the farthest value.
    """
    files = list(dict.fromkeys(values["file"].astype(str)))
    is_named = len(files) <= MOST_NAMED
    ticks = {float(at): each[-NAME:] for at, each in enumerate(files)} if is_named else None
    x = Axis("" if is_named else "machine, in the order of the table", ticks=ticks, is_turned=True, group="machine")
    unknowns = values.drop_duplicates(["name", "unit"])[["name", "unit"]].itertuples(index=False, name=None)
    panels = tuple(
        _panel(values[(values["name"] == name) & (values["unit"] == unit)], files, x, f"{name} ({unit})")
        for name, unit in unknowns
    )
    said = "Each unknown of each machine with its interval; an arrow where a side is open."
    return Chart("Unknowns of each machine", said, (panels,), width=float(np.clip(0.25 * len(files) + 2, 6, 14)))


def _panel(mine: pd.DataFrame, files: Sequence[str], x: Axis, label: str) -> Panel:
    at = np.array([files.index(str(each)) for each in mine["file"]], dtype=float)
    value, low, high = (mine[column].to_numpy(float) for column in ("value", "low", "high"))
    said = [f"{files[int(place)]}: {with_ends(*each)}" for place, *each in zip(at, value, low, high)]
    every = np.concatenate([value, low, high])
    ends = np.where(np.isnan(low), np.nanmin(every), low), np.where(np.isnan(high), np.nanmax(every), high)
    if np.isnan([low, high]).all():
        return Panel(
            (Points(at, value, size=4.0, said=said),), x, Axis(label), height=1.5
        )  # no intervals were asked for
    elements: list[Element] = [Points(at, value, size=4.0, low=ends[0], high=ends[1], said=said)]
    elements += [
        Points(
            at[is_open], end[is_open], f"triangle {way}", 6.0, said=[said[index] for index in np.flatnonzero(is_open)]
        )
        for end, is_open, way in ((ends[0], np.isnan(low), "down"), (ends[1], np.isnan(high), "up"))
        if is_open.any()
    ]
    return Panel(tuple(elements), x, Axis(label), height=1.5)
