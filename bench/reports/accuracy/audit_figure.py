"""The paper's printed errors as dots against the CRLBs of every reading, a panel per table."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ksmea.show.charts.locators import plain_ticks
from ksmea.show.figures.style import COLOURS

READINGS = {  # colour by how speeds and damping are read
    ("rad/s", "kN s/m"): COLOURS[0],
    ("rad/s", "kN s/mm"): COLOURS[2],
    ("rpm", "kN s/m"): COLOURS[1],
    ("rpm", "kN s/mm"): COLOURS[4],
    ("rpm", "assumed"): COLOURS[1],
}
STYLES: dict[str, tuple[float, Any]] = {
    "amplitude": (2.6, "-"),
    "complex": (1.4, (0, (2, 1))),
}  # width and dashes by the kind of data
LOWEST, HIGHEST = 0.03, 3e4  # %, of the axis; what lies beyond stands at its edge as an arrow
HALF_WIDTH = 0.38  # of a CRLB's line


def audit_figure(frame: pd.DataFrame) -> Figure:
    frame = frame[frame["crlb_pct"].notna()]  # not what is said of columns as a whole
    tables = list(dict.fromkeys(frame["table"]))
    columns = min(2, len(tables))
    n_row = -(-len(tables) // columns)
    figure = Figure(figsize=(4.5 * columns, 3.2 * n_row + 1.1), layout="constrained")
    panels = figure.subplots(n_row, columns, squeeze=False, sharey=True).ravel()
    for panel, table in zip(panels, tables):
        _panel(panel, frame[frame["table"] == table])
        panel.set_title(f"Table {table.removeprefix('table')}", fontsize=10)
    for panel in panels[len(tables) :]:
        panel.set_axis_off()
    for panel in panels[::columns]:
        panel.set_ylabel("error (%)", fontsize=9)
    figure.legend(handles=_legend(frame), loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    figure.suptitle("Printed errors (dots) against what the data can tell (lines: 1 σ), by how the print is read")
    return figure


def _panel(panel: Axes, rows: pd.DataFrame) -> None:
    names = list(dict.fromkeys(rows["parameter"]))
    for index, name in enumerate(names):
        of_name = rows[rows["parameter"] == name]
        for (reading, damping, kind), group in of_name.groupby(["reading", "damping", "kind"], sort=False):
            _draw_crlb(panel, index, float(group["crlb_pct"].iloc[0]), READINGS[reading, damping], kind)
        _values(panel, index, of_name.drop_duplicates("column"))
    panel.set_yscale("log")
    panel.set_ylim(LOWEST, HIGHEST)
    panel.set_xlim(-0.6, len(names) - 0.4)
    panel.set_xticks(range(len(names)), names)
    plain_ticks(panel.yaxis)
    panel.tick_params(labelsize=8)
    panel.grid(axis="y", alpha=0.25)


def _draw_crlb(panel: Axes, index: int, crlb_pct: float, colour: str, kind: str) -> None:
    width, dashes = STYLES[kind]
    if crlb_pct < HIGHEST:
        panel.hlines(crlb_pct, index - HALF_WIDTH, index + HALF_WIDTH, color=colour, linewidth=width, linestyle=dashes)
    else:
        offset = 0.12 if kind == "complex" else -0.12
        panel.plot(index + offset, HIGHEST * 0.75, "^", color=colour, markersize=7)


def _values(panel: Axes, index: int, rows: pd.DataFrame) -> None:
    """A dot per printed column, side by side; an error of 0 stands at its rounding."""
    offsets = np.linspace(-0.21, 0.21, len(rows)) if len(rows) > 1 else [0.0]
    for offset, row in zip(offsets, rows.itertuples()):
        shown = row.error_pct_printed or row.rounding_pct
        marker = "s" if row.at_search_limit else "v" if row.error_pct_printed == 0 else "o"
        face = "white" if row.slip else "black"
        panel.plot(
            index + offset,
            shown,
            marker,
            color="black",
            markerfacecolor=face,
            markersize=5,
            markeredgewidth=1.1,
            zorder=5,
        )


def _legend(frame: pd.DataFrame) -> list[Line2D]:
    shown = list(dict.fromkeys(zip(frame["reading"], frame["damping"])))
    labels: dict[tuple[str, str], str] = {}  # one entry per colour
    for reading, damping in shown:
        labels.setdefault(("colour", READINGS[reading, damping]), f"CRLB: {reading}, {damping}")
    lines = [Line2D([], [], color=colour, linewidth=2.6, label=label) for (_, colour), label in labels.items()]
    for kind in dict.fromkeys(frame["kind"]):
        width, dashes = STYLES[kind]
        lines.append(Line2D([], [], color="grey", linewidth=width, linestyle=dashes, label=f"{kind} data"))
    for marker, face, label in (
        ("o", "black", "printed"),
        ("o", "white", "printed, with a slip"),
        ("s", "black", "printed, at a search limit"),
        ("v", "black", "printed as 0 (at its rounding)"),
    ):
        lines.append(
            Line2D([], [], color="black", linestyle="", marker=marker, markerfacecolor=face, markersize=5, label=label)
        )
    return lines
