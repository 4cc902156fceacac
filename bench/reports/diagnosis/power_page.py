"""Sections on many diagnoses: how often each verdict was reached in each cell, and what a diagnosis sees of hidden effects."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS
from bench.plan.naming import cell_name
from bench.plan.page import Folded, Grid, Page, Plot, Prose, Section, Table
from bench.plan.plan import Plan
from bench.reports.diagnosis.power import DROP, EFFECT, SIZES, chance, detectable_drop
from bench.reports.plots.traces import BLUE, COLOURS, GREY, axis, folded, layout, level, line, points
from bench.reports.tables import interval

VERDICTS = ("adequate", "named", "ambiguous", "located", "unknown", "not observable")
ROW = 34  # px for each cell
BAR, MARGINS = 110, 270  # px: of a scale of colours, and of names of effects above a matrix
FEW_RUNS = 8  # of a cell, up to which each has a mark on the axis
SCALE = [[0.0, "rgba(43,122,184,0.06)"], [1.0, "#2b7ab8"]]


def diagnoses_page(plan: Plan, text: str, frame: pd.DataFrame, runs: pd.DataFrame) -> Page:
    """Verdicts of each cell, in a table and as bars."""
    counts = (
        runs.loc[runs["status"].isin(RESULTS), "verdict"].value_counts() if "verdict" in runs else pd.Series(dtype=int)
    )
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in counts.items()) or "no run has a result"
    table = Section("Table", (Prose(text), Folded("All columns", (Table(frame, file=f"{plan.name}.csv"),))))
    names = [cell_name(plan, cell) for cell in plan.cells]
    labels = [name or f"cell {number}" for number, name in enumerate(names)]
    return Page(verdicts, (table, Section("Verdicts", (_verdict_plot(labels, frame),))))


def _verdict_plot(names: list[str], frame: pd.DataFrame) -> Plot:
    traces = [
        {
            "type": "bar",
            "orientation": "h",
            "name": verdict,
            "x": frame[verdict],
            "y": [*map(folded, names)],
            "marker": {"color": colour},
            "showlegend": True,
        }
        for verdict, colour in zip(VERDICTS, COLOURS)
        if frame[verdict].any()
    ]
    made = layout("runs", barmode="stack")
    made["xaxis"] |= {"tickformat": "d", **({"dtick": 1} if frame["runs"].max() <= FEW_RUNS else {})}
    made["yaxis"] = axis(autorange="reversed", categoryorder="array", categoryarray=[*map(folded, names)])
    return Plot(
        "Verdicts",
        "How often each verdict was reached in each cell.",
        {"data": traces, "layout": made},
        height=140 + ROW * len(names),
    )


def power_page(
    seen: str, about: str, tables: dict[str, pd.DataFrame], with_effect: pd.DataFrame, shares: pd.DataFrame
) -> Page:
    """Rates by effect and by kind of data, detection against size, and what each effect is called; `seen` is that in a line."""
    effects = list(dict.fromkeys(with_effect[EFFECT]))
    sections = (
        Section("Rates", (Prose(about), *(Table(table, title) for title, table in tables.items()))),
        Section(
            "Detection",
            (Grid(tuple(_detection_plot(effect, with_effect[with_effect[EFFECT] == effect]) for effect in effects)),),
        ),
        Section("Confusion", (_confusion_plot(shares),)),
    )
    return Page(seen, sections)


def _detection_plot(effect: str, mine: pd.DataFrame) -> Plot:
    """The share of draws of one effect that are detected against size, with what is expected."""
    sizes = np.geomspace(min(0.5, mine["size"].min()), max(2.0, mine["size"].max()), 60)
    unknowns, candidates, tested = (mine[name].iloc[0] for name in ("unknowns", "candidates", "level"))
    needed = detectable_drop(unknowns, candidates, tested)
    expected = [100 * chance(size**2 * needed, unknowns, candidates, tested) for size in sizes]
    rows = []
    for _, of in mine.groupby(DROP):
        seen, n = int(of["detected"].sum()), len(of)
        low, high = interval(seen, n)
        rows.append((of["size"].median(), 100 * seen / n, 100 * low, 100 * high, f"{seen} of {n}"))
    at, share, lows, highs, words = (list(column) for column in zip(*rows))
    bars = {
        "type": "data",
        "symmetric": False,
        "array": np.subtract(highs, share),
        "arrayminus": np.subtract(share, lows),
    }
    traces = [
        line(sizes, expected, "expected", GREY),
        points(at, share, "detected", BLUE, error_y=bars, text=words, hovertemplate="%{text}<extra></extra>"),
    ]
    made = layout("size / smallest detectable size", "detected (%)", x_log=True, shapes=[level(1.0, along="x")])
    made["yaxis"]["range"] = [-4, 104]
    made["xaxis"] |= {"tickvals": list(SIZES), "ticktext": [f"{size:g}" for size in SIZES]}
    said = f"Share of draws of {effect} that are detected, with 95 % intervals, and what is expected (line)."
    return Plot(effect, said, {"data": traces, "layout": made}, height=290)


def _confusion_plot(shares: pd.DataFrame) -> Plot:
    pct = 100 * shares.to_numpy(float)
    trace = {
        "type": "heatmap", "z": pct, "x": [*map(str, shares.columns)], "y": [*map(str, shares.index)], "colorscale": SCALE,
        "zmin": 0, "zmax": 100, "hovertemplate": "%{y} is called %{x}: %{z:.0f} %<extra></extra>", "xgap": 1, "ygap": 1,
        "colorbar": {"title": {"text": "%"}, "thickness": 12, "len": BAR, "lenmode": "pixels", "tickvals": [0, 50, 100]},
    }  # fmt: skip
    made = layout("", "hidden")
    made["yaxis"] |= {"autorange": "reversed"}
    made["xaxis"] |= {"tickangle": -90, "side": "top", "title": {"text": "reported", "standoff": 10}}
    said = "What each hidden effect (rows) is called (columns), in per cent of its clearly visible draws."
    return Plot(
        "Confusion", said, {"data": [trace], "layout": made}, "confusion.png", height=MARGINS + 22 * len(shares)
    )
