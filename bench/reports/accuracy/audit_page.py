"""Sections on the audit: the paper's printed errors next to the precision of its data.

There is one for each reading of its print.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
import pandas as pd

from bench.plan.page import Drawn, Folded, Page, Prose, Section, Table
from bench.reports.identification.spread_chart import segments
from ksmea.show.charts.chart import Axis, Chart, Element, Line, Panel, Points
from ksmea.show.charts.colours import CATEGORIES, INK

LOWEST, HIGHEST = 0.03, 3e4  # %, of the axis; what lies beyond stands at its edge as an arrow
HALF_WIDTH = 0.38  # of a CRLB's line
READINGS = {  # colour by how speeds and damping are read
    ("rad/s", "kN s/m"): CATEGORIES[0],
    ("rad/s", "kN s/mm"): CATEGORIES[2],
    ("rpm", "kN s/m"): CATEGORIES[1],
    ("rpm", "kN s/mm"): CATEGORIES[4],
    ("rpm", "assumed"): CATEGORIES[1],
}
STYLES = {"amplitude": (2.6, "solid"), "complex": (1.4, "dash")}  # width and dashes by the kind of data
PRINTED, AT_LIMIT, AS_ZERO = "printed", "printed, at a search limit", "printed as 0 (at its rounding)"
SYMBOLS = {PRINTED: "circle", AT_LIMIT: "square", AS_ZERO: "triangle down"}  # hollow: with a slip


def audit_page(text: str, frame: pd.DataFrame, file: str, picture: str) -> Page:
    """For each table of the paper its printed errors against the CRLBs, and the table of readings."""
    sections = [Section("Table", (Prose(text), Folded("All values", (Table(frame, file=file),))))]
    if frame["crlb_pct"].notna().any():
        charts = (Drawn(partial(audit_chart, frame), picture),)
        sections.insert(0, Section("Printed errors against the CRLB", charts))
    counts = frame["verdict"].value_counts()
    verdicts = ", ".join(f"{count} {name}" for name, count in counts.items())
    return Page(f"printed values under all readings: {verdicts}" if verdicts else text, tuple(sections))


def audit_chart(frame: pd.DataFrame) -> Chart:
    """The paper's printed errors as dots against the CRLBs of every reading, a panel per table.

    Not what is said of columns as a whole.
    """
    single = frame[frame["crlb_pct"].notna()]
    stacks = tuple((_panel(table, single[single["table"] == table]),) for table in dict.fromkeys(single["table"]))
    across = min(2, max(len(stacks), 1))
    return Chart(
        "Printed errors (dots) against what the data can tell (lines: 1 σ), by how the print is read",
        "Printed errors of each table (black) against the CRLB (lines, 1 σ) of each reading of its units: drawn through for amplitudes, dashed"
        f" for complex data. Squares: at a search limit; hollow: with a slip; triangles: printed as 0, at their rounding; what lies beyond"
        f" {HIGHEST:g} % stands there as an arrow.",
        stacks, across, 4.7 * across,
    )  # fmt: skip


def _panel(table: str, rows: pd.DataFrame) -> Panel:
    names = list(dict.fromkeys(rows["parameter"]))
    elements: list[Element] = []
    for (reading, damping, kind), mine in rows.groupby(["reading", "damping", "kind"], sort=False):
        elements += _crlb(reading, damping, kind, mine, names)
    printed = pd.concat(
        [_side_by_side(rows[rows["parameter"] == name].drop_duplicates("column"), at) for at, name in enumerate(names)]
    )
    for (name, is_slip), mine in printed.groupby(["mark", "is_slip"], sort=False):
        elements.append(
            Points(
                mine["at"].to_numpy(), mine["shown"].to_numpy(), SYMBOLS[name], is_open=is_slip, colour=INK,
                name=f"{name}, with a slip" if is_slip else name, said=mine["said"].tolist(),
            )
        )  # fmt: skip
    x = Axis(low=-0.6, high=len(names) - 0.4, ticks={float(at): name for at, name in enumerate(names)})
    return Panel(
        tuple(elements),
        x,
        Axis("error (%)", "log", LOWEST, HIGHEST, group="error"),
        f"Table {table.removeprefix('table')}",
        2.9,
    )


def _crlb(reading: str, damping: str, kind: str, rows: pd.DataFrame, names: Sequence[str]) -> Iterator[Element]:
    """The bounds of one reading, a line for each parameter."""
    one = rows.drop_duplicates("parameter")
    at, crlb = np.array([names.index(name) for name in one["parameter"]], dtype=float), one["crlb_pct"].to_numpy(float)
    colour, (width, dash) = READINGS[reading, damping], STYLES[kind]
    seen = crlb < HIGHEST
    name = f"CRLB: {reading}, {damping}, {kind}"
    ends = segments(at[seen] - HALF_WIDTH, at[seen] + HALF_WIDTH), segments(crlb[seen], crlb[seen])
    yield Line(*ends, dash, width, name=name, colour=colour, said=f"{name}: {{y:.3g}} %")
    if not seen.all():
        offset = 0.12 if kind == "complex" else -0.12
        top = np.full(int((~seen).sum()), 0.75 * HIGHEST)
        yield Points(
            at[~seen] + offset,
            top,
            "triangle up",
            7.0,
            colour=colour,
            said=[f"{name}: {value:.3g} %" for value in crlb[~seen]],
        )


def _side_by_side(rows: pd.DataFrame, at: int) -> pd.DataFrame:
    """Position of each printed column of one parameter, and its kind.

    An error of 0 stands at its rounding.
    """
    offsets = np.linspace(-0.21, 0.21, len(rows)) if len(rows) > 1 else [0.0]
    error = rows["error_pct_printed"].to_numpy(float)
    shown = np.where(error != 0, error, rows["rounding_pct"].to_numpy(float))
    marks = np.select([rows["at_search_limit"].astype(bool), error == 0], [AT_LIMIT, AS_ZERO], PRINTED)
    said = [
        f"{row.parameter}, {row.column}: printed {row.error_pct_printed:g} %, {row.verdict}"
        for row in rows.itertuples()
    ]
    return rows.assign(
        at=at + np.asarray(offsets), shown=shown, mark=marks, is_slip=rows["slip"].astype(bool), said=said
    )
