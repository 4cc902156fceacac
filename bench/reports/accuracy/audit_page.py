"""Sections on the audit: the paper's printed errors beside what its data can tell, under each reading of its print."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench.plan.page import Folded, Page, Plot, Prose, Section, Table
from bench.reports.plots.traces import COLOURS, GREY, axis, layout, points

LOWEST, HIGHEST = 0.03, 3e4  # %, of the axis
OFFSETS = 0.5  # width over which readings of one parameter are spread


def audit_page(text: str, frame: pd.DataFrame, file: str, still: str) -> Page:
    """The table of readings, and for each table of the paper its printed errors against the CRLBs."""
    sections = [Section("Table", (Prose(text), Folded("All values", (Table(frame, file=file),))))]
    single = frame[frame["crlb_pct"].notna()]
    tables = list(dict.fromkeys(single["table"]))
    plots = tuple(
        _plot(table, single[single["table"] == table], still if number == 0 else "")
        for number, table in enumerate(tables)
    )
    sections += [Section("Printed errors against the CRLB", plots)] if plots else []
    counts = frame["verdict"].value_counts()
    verdicts = ", ".join(f"{count} {name}" for name, count in counts.items())
    return Page(f"printed values under all readings: {verdicts}" if verdicts else text, tuple(sections))


def _plot(table: str, rows: pd.DataFrame, still: str) -> Plot:
    names = list(dict.fromkeys(rows["parameter"]))
    readings = list(rows.groupby(["reading", "damping", "kind"], sort=False))
    traces = []
    for number, ((reading, damping, kind), of) in enumerate(readings):
        one = of.drop_duplicates("parameter")
        offset = OFFSETS * ((number + 0.5) / len(readings) - 0.5)
        at = [names.index(name) + offset for name in one["parameter"]]
        label = f"speeds in {reading}, damping {damping if damping == 'assumed' else f'in {damping}'}, {kind}"
        crlb = np.clip(one["crlb_pct"].to_numpy(float), LOWEST, HIGHEST)
        style = {"symbol": "line-ew-open", "size": 18, "line": {"width": 3}}
        text = [f"{name}: CRLB {value:.3g} %" for name, value in zip(one["parameter"], one["crlb_pct"])]
        traces.append(
            points(at, crlb, label, COLOURS[number % len(COLOURS)], marker=style, text=text, hovertemplate="%{text}")
        )
    printed = rows.drop_duplicates(["parameter", "column"])
    error = printed["error_pct_printed"].to_numpy(float)
    shown = np.where(error > 0, error, printed["rounding_pct"].to_numpy(float))
    words = [
        f"{row.parameter}, {row.column}: printed {row.error_pct_printed:g} %, {row.verdict}"
        for row in printed.itertuples()
    ]
    at = [names.index(name) for name in printed["parameter"]]
    traces.append(
        points(
            at,
            np.clip(shown, LOWEST, HIGHEST),
            "printed error",
            GREY,
            text=words,
            hovertemplate="%{text}",
            marker={"size": 9},
        )
    )
    made = layout("", "error (%)", y_log=True)
    made["xaxis"] = axis(tickvals=list(range(len(names))), ticktext=names)
    said = (
        f"Printed errors (dots) of Table {table.removeprefix('table')} against the CRLB (bars, 1 σ) of each reading of its units;"
        f" what lies beyond {HIGHEST:g} % stands there."
    )
    return Plot(f"Table {table.removeprefix('table')}", said, {"data": traces, "layout": made}, still)
