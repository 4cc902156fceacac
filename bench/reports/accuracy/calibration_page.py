"""Sections on estimates and intervals over many noise draws: errors in units of the CRLB, coverage, basins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import NormalDist

import numpy as np
import pandas as pd

from bench.plan.page import Folded, Page, Plot, Prose, Section, Table
from bench.reports.plots.traces import BLUE, COLOURS, GREEN, ORANGE, axis, folded, layout, level

ENDS = (2.5, 25, 50, 75, 97.5)  # percentiles of a box and its whiskers
NEAR = 6.0  # times the CRLB within which errors are drawn on a linear axis
ROW = 36  # px for each cell


def calibration_page(
    text: str, frame: pd.DataFrame, names: Sequence[str], errors: Mapping[str, Sequence[np.ndarray]], levels: Sequence[float], file: str, still: str
) -> Page:  # fmt: skip
    """`errors` are those of each parameter and cell in units of the CRLB, `levels` the confidence levels of the intervals."""
    plots = [
        _error_plot(name, names, of, still if number == 0 else "") for number, (name, of) in enumerate(errors.items())
    ]
    sections = [
        Section("Table", (Prose(text), Folded("All columns", (Table(frame, file=file),)))),
        Section("Errors in units of the CRLB", tuple(plots)),
    ]
    more = (
        [_coverage_plot(frame, names, levels)] if "covered_pct" in frame and frame["covered_pct"].notna().any() else []
    )
    more += [_basin_plot(frame, names)] if frame["right_basin_pct"].notna().any() else []
    sections += [Section("Coverage and basins", tuple(more))] if more else []
    return Page(_headline(frame), tuple(sections))


def _headline(frame: pd.DataFrame) -> str:
    """How many runs, and the range of the coverage."""
    runs = int(frame["runs"].max())
    of_cell = f"{runs} run{'s' * (runs != 1)} in each cell" + (" at most" if frame["runs"].min() < runs else "")
    if "covered_pct" not in frame or frame["covered_pct"].isna().all():
        return of_cell
    low, high = (f"{end:.1f}" for end in (frame["covered_pct"].min(), frame["covered_pct"].max()))
    return f"Intervals hold the truth in {low if low == high else f'{low} to {high}'} % of the runs; {of_cell}"


def _error_plot(name: str, cells: Sequence[str], errors: Sequence[np.ndarray], still: str) -> Plot:
    traces = []
    for cell, values in zip(cells, errors):
        if len(values):
            low, first, median, third, high = np.percentile(values, ENDS)
            traces.append(
                {
                    "type": "box", "orientation": "h", "name": folded(cell), "y0": folded(cell), "q1": [first], "median": [median], "q3": [third],
                    "lowerfence": [low], "upperfence": [high], "showlegend": False, "line": {"color": BLUE},
                }
            )  # fmt: skip
    reach = max((float(np.max(np.abs(np.percentile(values, ENDS)))) for values in errors if len(values)), default=1.0)
    normal = NormalDist().inv_cdf(0.975)
    made = layout(
        "error / CRLB",
        shapes=[level(at, along="x", dash="solid" if at == 0 else "dot") for at in (-normal, 0.0, normal)],
    )
    made["xaxis"] = axis(
        "error / CRLB", range=[-max(reach, 4) * 1.05, max(reach, 4) * 1.05] if reach < NEAR else [-12, 12]
    )
    made["yaxis"] = axis(autorange="reversed")
    beyond = "; some reach beyond what is drawn" if reach >= 12 else ""
    said = f"Errors of {name}: boxes are quartiles, whiskers 2.5 and 97.5 %; dotted: where those of an efficient estimate lie{beyond}."
    return Plot(name, said, {"data": traces, "layout": made}, still, height=130 + ROW * len(cells))


def _coverage_plot(frame: pd.DataFrame, names: Sequence[str], levels: Sequence[float]) -> Plot:
    parameters = list(dict.fromkeys(frame["parameter"]))
    row_of = {name: number for number, name in enumerate(names)}
    traces = [
        {
            "type": "scatter", "mode": "markers", "name": name, "x": rows["covered_pct"],
            "y": [row_of[cell] + 0.6 * ((number + 0.5) / len(parameters) - 0.5) for cell in rows["cell_name"]],
            "marker": {"color": colour, "size": 7}, "hovertemplate": "%{x:.1f} %",
            "error_x": {
                "type": "data", "symmetric": False, "thickness": 1.5, "arrayminus": 2 * rows["covered_se"],
                "array": np.minimum(2 * rows["covered_se"], 100 - rows["covered_pct"]),
            },
        }
        for number, (name, colour) in enumerate(zip(parameters, COLOURS))
        for rows in [frame[frame["parameter"] == name]]
    ]  # fmt: skip
    made = layout(shapes=[level(100 * each, along="x") for each in levels])
    made["xaxis"] = axis("coverage (%)")
    made["yaxis"] = axis(tickvals=[*row_of.values()], ticktext=[*map(folded, names)], range=[len(names) - 0.5, -0.5])
    said = "Share of the intervals that hold the truth, ± 2 standard errors; dotted: the confidence level."
    return Plot("Coverage", said, {"data": traces, "layout": made}, height=140 + 2 * ROW * len(names))


def _basin_plot(frame: pd.DataFrame, names: Sequence[str]) -> Plot:
    rows = frame.drop_duplicates("cell_name")
    basins = {"right_basin_pct": ("the truth's", GREEN), "wrong_basin_pct": ("another, less likely", ORANGE), "higher_elsewhere_pct": ("another, more likely", BLUE)}  # fmt: skip
    traces = [
        {
            "type": "bar",
            "orientation": "h",
            "name": said,
            "x": rows[column],
            "y": [*map(folded, rows["cell_name"])],
            "marker": {"color": colour},
        }
        for column, (said, colour) in basins.items()
    ]
    made = layout("runs (%)", barmode="stack")
    made["yaxis"] = axis(autorange="reversed", categoryorder="array", categoryarray=[*map(folded, names)])
    said = "In which basin of the likelihood the runs of each cell end."
    return Plot("Basins", said, {"data": traces, "layout": made}, height=140 + ROW * len(names))
