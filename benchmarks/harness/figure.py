"""The ratios of a table on a logarithmic axis, a panel for each group."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.harness.report import number, title_of
from benchmarks.harness.table import PART
from ksmea.show.charts.chart import Axis, Chart, Element, Level, Panel, Points, Words, named_rows
from ksmea.show.charts.colours import MODEL, PAPER, REFERENCE

ROW_HEIGHT, WIDTH = 0.24, 11.0  # inches
MAX_NAME = 78
SIDES = ((MODEL, "ours is faster"), (PAPER, "theirs is faster"))
LABEL = "their time over ours, paired by turn, with quartiles; right of 1, ours is faster; |: demanded"
NOTHING = "no contestant beside ours was measured"


def ratio_chart(frame: pd.DataFrame) -> Chart:
    """A dot for each contestant beside ours, with the quartiles of its ratio; a mark where a demand lies."""
    shown = frame[frame["ratio"].notna() & (frame["note"] != PART)]
    if shown.empty:
        return Chart(NOTHING, NOTHING, (), width=WIDTH)
    ends = min(float(shown["ratio_q1"].min()), 0.5) / 1.5, max(float(shown["ratio_q3"].max()), 2.0) ** 1.15
    stack = tuple(_panel(str(group), rows, *ends) for group, rows in shown.groupby("group", sort=False))
    return Chart("", LABEL, (stack,), width=WIDTH)


def _panel(group: str, rows: pd.DataFrame, low: float, high: float) -> Panel:
    ratio, first, third = (rows[name].to_numpy(float) for name in ("ratio", "ratio_q1", "ratio_q3"))
    at = np.arange(len(rows), dtype=float)
    elements: list[Element] = [Level(at=1.0, along="x", dash="solid")]
    for (colour, name), mine in zip(SIDES, (ratio >= 1, ratio < 1)):
        elements.append(Points(ratio[mine], at[mine], left=first[mine], right=third[mine], name=name, colour=colour))
    elements.append(Points(rows["at_least"].to_numpy(float), at, "post", 9.0, colour=REFERENCE))
    elements += [
        Words(x=end, y=place, text=number(value), size=7, offset=(6, 0), side="left")
        for value, end, place in zip(ratio, third, at)
    ]
    y = named_rows(_name(line) for _, line in rows.iterrows())
    return Panel(tuple(elements), Axis(LABEL, "log", low, high, group="ratio"), y, group, ROW_HEIGHT * (len(rows) + 1))


def _name(line: pd.Series) -> str:
    name = f"{title_of(line).partition(': ')[2]} – {line['contestant']}"
    return name if len(name) <= MAX_NAME else f"{name[: MAX_NAME - 1]}…"
