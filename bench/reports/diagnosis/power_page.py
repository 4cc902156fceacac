"""Pages of many diagnoses and their charts.

How often each verdict was reached in each cell, detection against size, and what each hidden effect is called.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS
from bench.plan.naming import cell_name
from bench.plan.page import Drawn, Folded, Page, Prose, Section, Table
from bench.plan.plan import Plan
from bench.reports.diagnosis.power import DROP, EFFECT, SIZES, chance, detectable_drop
from bench.reports.tables import interval
from ksmea.show.charts.chart import Axis, Chart, Heat, Level, Line, Panel, Points, one_panel, stacked_bars
from ksmea.show.charts.colours import REFERENCE, category

VERDICTS = ("adequate", "named", "ambiguous", "located", "unknown", "not observable")
COLUMNS = 5  # of panels
ROW, CELL = 0.36, 0.28  # inches: of a bar, and of a row of a matrix
NAMES = 1.5  # inches, of upright names of effects


def diagnoses_page(plan: Plan, text: str, frame: pd.DataFrame, runs: pd.DataFrame) -> Page:
    """Verdicts of each cell, in a table and as bars."""
    counts = (
        runs.loc[runs["status"].isin(RESULTS), "verdict"].value_counts() if "verdict" in runs else pd.Series(dtype=int)
    )
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in counts.items()) or "no run has a result"
    table = Section("Table", (Prose(text), Folded("All columns", (Table(frame, file=f"{plan.name}.csv"),))))
    names = [cell_name(plan, cell) or f"cell {number}" for number, cell in enumerate(plan.cells)]
    return Page(verdicts, (table, Section("Verdicts", (Drawn(verdicts_chart(names, frame)),))))


def power_page(
    seen: str, about: str, tables: dict[str, pd.DataFrame], with_effect: pd.DataFrame, shares: pd.DataFrame
) -> Page:
    """Rates by effect and by kind of data, detection against size, and what each effect is called.

    `seen` is that in a line.
    """
    sections = (
        Section("Rates", (Prose(about), *(Table(table, title) for title, table in tables.items()))),
        Section("Detection", (Drawn(partial(detection_chart, with_effect), "detection.png"),)),
        Section("Confusion", (Drawn(partial(confusion_chart, shares), "confusion.png"),)),
    )
    return Page(seen, sections)


def verdicts_chart(names: Sequence[str], frame: pd.DataFrame) -> Chart:
    """How often each verdict was reached in each cell (n): bars that stand on each other."""
    at = np.arange(len(names), dtype=float)
    counts = {verdict: (frame[verdict].to_numpy(float), category(number)) for number, verdict in enumerate(VERDICTS)}
    bars = stacked_bars(at, {verdict: (sizes, colour) for verdict, (sizes, colour) in counts.items() if sizes.any()})
    y = Axis(ticks=dict(zip(at, names)), low=-0.6, high=len(names) - 0.4, is_reversed=True)
    return one_panel(
        bars, Axis("runs", is_whole=True), y, "Verdicts", "How often each verdict was reached in each cell.", height=ROW * (len(names) + 1),
    )  # fmt: skip


def detection_chart(with_effect: pd.DataFrame) -> Chart:
    """The share of draws that are detected against size, per effect.

    1 is the smallest detectable size, which nine of ten draws are expected to show.
    """
    effects = list(dict.fromkeys(with_effect[EFFECT]))
    across = min(COLUMNS, len(effects))
    sizes = np.geomspace(min(0.5, with_effect["size"].min()), max(2.0, with_effect["size"].max()), 60)
    panels = [_detection(effect, with_effect[with_effect[EFFECT] == effect], sizes) for effect in effects]
    return Chart(
        "Detection of effects against their size",
        "Share of the draws of each effect that are detected, with 95 % intervals, and the share that is expected (line)."
        " 1 is the smallest detectable size.",
        tuple(tuple(panels[column::across]) for column in range(across)), across, max(2.5 * across + 0.6, 4.0),
    )  # fmt: skip


def _detection(effect: str, mine: pd.DataFrame, sizes: np.ndarray) -> Panel:
    unknowns, candidates, level = (mine[name].iloc[0] for name in ("unknowns", "candidates", "level"))
    needed = detectable_drop(unknowns, candidates, level)
    expected = [100 * chance(size**2 * needed, unknowns, candidates, level) for size in sizes]
    draws = [of for _, of in mine.groupby(DROP)]
    counts = [(int(of["detected"].sum()), len(of)) for of in draws]
    low, high = 100 * np.array([interval(seen, n) for seen, n in counts]).T
    detected = Points(
        [of["size"].median() for of in draws], [100 * seen / n for seen, n in counts], low=low, high=high,
        name="detected", said=[f"{seen} of {n}" for seen, n in counts],
    )  # fmt: skip
    x = Axis("size / detectable size", "log", ticks={size: f"{size:g}" for size in SIZES}, group="size")
    y = Axis("detected (%)", low=-5, high=105, group="share")
    line = Line(sizes, expected, width=1.0, name="expected", colour=REFERENCE, said="{y:.0f} % expected")
    return Panel((line, detected, Level(at=1.0, along="x")), x, y, effect, 1.6)


def confusion_chart(shares: pd.DataFrame) -> Chart:
    """Verdicts (columns) on each hidden effect (rows), in per cent of its clearly visible draws."""
    n_row, n_column = shares.shape
    called = Axis("reported", ticks=dict(enumerate(map(str, shares.columns))), is_turned=True)
    hidden = Axis("hidden", ticks=dict(enumerate(map(str, shares.index))), is_reversed=True)
    return one_panel(
        [Heat(shares.to_numpy(float), said="{y} is called {x}: {z:.0%}")], called, hidden, "What hidden effects are called, % of clearly visible draws",
        "What each hidden effect (rows) is called (columns), in per cent of its clearly visible draws.",
        height=NAMES + CELL * n_row, width=max(2.6 + 0.36 * n_column, 6.0),
    )  # fmt: skip
