"""Sections on a fleet: table of all machines, their unknowns side by side, and the text of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from bench.plan.page import Drawn, Folded, Page, Prose, Section, Table
from ksmea.show.charts.chart import Axis, Chart, Element, Panel, Points, named_rows
from ksmea.show.text import with_ends

MOST_NAMED = 40  # machines whose names stand at their rows; of more, their number
MOST_ACROSS = 5  # panels side by side
ROW, TALLEST = 0.25, 9.0  # inches, of a machine and of a panel
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
    """Unknowns of a fleet: a panel for each unknown, a row for each machine in the order of the table.

    An open end is an arrow at the farthest value.
    """
    files = list(dict.fromkeys(values["file"].astype(str)))
    is_named = len(files) <= MOST_NAMED
    y = named_rows(
        [each[-NAME:] for each in files], "" if is_named else "machine, in the order of the table", "machine"
    )
    if not is_named:
        y = replace(y, ticks=None)
    unknowns = values.drop_duplicates(["name", "unit"])[["name", "unit"]].itertuples(index=False, name=None)
    panels = tuple(
        _panel(values[(values["name"] == name) & (values["unit"] == unit)], files, y, f"{name} ({unit})")
        for name, unit in unknowns
    )
    said = "Each unknown of each machine with its interval; an arrow where a side is open."
    across = min(MOST_ACROSS, len(panels))
    stacks = tuple((panel,) for panel in panels)
    return Chart(f"Parameters of {len(files)} machines", said, stacks, across, 2.2 * across + 1.8, most=len(panels))


def _panel(mine: pd.DataFrame, files: Sequence[str], y: Axis, title: str) -> Panel:
    at = np.array([files.index(str(each)) for each in mine["file"]], dtype=float)
    value, low, high = (mine[column].to_numpy(float) for column in ("value", "low", "high"))
    said = [f"{files[int(place)]}: {with_ends(*each)}" for place, *each in zip(at, value, low, high)]
    every = np.concatenate([value, low, high])
    ends = np.where(np.isnan(low), np.nanmin(every), low), np.where(np.isnan(high), np.nanmax(every), high)
    height = min(ROW * len(files) + 0.3, TALLEST)
    if np.isnan([low, high]).all():  # no intervals were asked for
        return Panel((Points(value, at, size=4.0, said=said),), y=y, title=title, height=height)
    elements: list[Element] = [Points(value, at, size=4.0, left=ends[0], right=ends[1], said=said)]
    elements += [
        Points(
            end[is_open], at[is_open], f"triangle {way}", 6.0, said=[said[index] for index in np.flatnonzero(is_open)]
        )
        for end, is_open, way in ((ends[0], np.isnan(low), "left"), (ends[1], np.isnan(high), "right"))
        if is_open.any()
    ]
    return Panel(tuple(elements), y=y, title=title, height=height)
