"""Sections on estimates and intervals over many noise draws.

Errors in units of the CRLB, coverage, basins.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from statistics import NormalDist

import numpy as np
import pandas as pd

from bench.plan.page import Drawn, Folded, Page, Prose, Section, Table
from bench.reports.tables import FEWEST_OF_BOX, interval
from ksmea.arrays import Array
from ksmea.show.charts.chart import (
    Axis,
    Boxes,
    Chart,
    Element,
    Level,
    Panel,
    Points,
    Span,
    Words,
    named_rows,
    one_panel,
    stacked_bars,
)
from ksmea.show.charts.colours import INTERVAL, MODEL, PAPER
from ksmea.show.text import two_digits

ENDS = (2.5, 25, 50, 75, 97.5)  # percentiles of a box and its whiskers
FAR = 6.0  # times the CRLB, where axes of errors end; what lies beyond is counted there
LEAST_COVERED = 88.0  # per cent, from which on the axis shows all
HELD = 2.0  # per cent beside the level: shaded
ROW, MARGINS = 0.26, 0.8  # inches for each cell and each panel
BASINS = {
    "right_basin_pct": ("the truth's", INTERVAL),
    "wrong_basin_pct": ("another, less likely", PAPER),
    "higher_elsewhere_pct": ("another, more likely", MODEL),
}


def calibration_page(
    title: str, text: str, frame: pd.DataFrame, names: Sequence[str], errors: Mapping[str, Sequence[Array]], levels: Sequence[float], name: str
) -> Page:  # fmt: skip
    """Page of a calibration: headline, charts and table.

    `errors` has the errors of each parameter and cell in units of the CRLB, `levels` the confidence level of each
    cell's intervals; `name` is the experiment's name.
    """
    charts = [Drawn(partial(calibration_chart, title, frame, names, errors, levels), f"{name}.png")]
    charts += [Drawn(partial(basins_chart, frame, names))] if frame["right_basin_pct"].notna().any() else []
    sections = (
        Section("Errors, coverage and basins", tuple(charts)),
        Section("Table", (Prose(text), Folded("All columns", (Table(frame, file=f"{name}.csv"),)))),
    )
    runs = int(frame["runs"].max())
    of_cell = f"{runs} run{'s' * (runs != 1)} in each cell" + (" at most" if frame["runs"].min() < runs else "")
    found = _coverage_in_short(frame)
    return Page(found or of_cell, sections, of_cell if found else "")


def _coverage_in_short(frame: pd.DataFrame) -> str:
    """The range of the coverage over cells and unknowns; '' without intervals."""
    if "covered_pct" not in frame or frame["covered_pct"].isna().all():
        return ""
    low, high = (f"{end:.3g}" for end in (frame["covered_pct"].min(), frame["covered_pct"].max()))
    return f"Intervals hold the truth in {low if low == high else f'{low} to {high}'} % of the runs"


def calibration_chart(
    title: str,
    frame: pd.DataFrame,
    names: Sequence[str],
    errors: Mapping[str, Sequence[Array]],
    levels: Sequence[float],
) -> Chart:
    """Errors in CRLB (boxes: quartiles; whiskers: 2.5 and 97.5 %) and coverage, a row per parameter."""
    has_coverage = "covered_pct" in frame and bool(frame["covered_pct"].notna().any())
    are_few = max((len(values) for of in errors.values() for values in of), default=0) < FEWEST_OF_BOX
    stacks = []
    covered = frame["covered_pct"].to_numpy(float) if has_coverage else np.ones(0)
    ends = _coverage_ends(frame)[0] if has_coverage else covered
    low = min(LEAST_COVERED, float(np.nanmin(ends, initial=100.0)) - 2)
    for name, of in errors.items():
        rows = frame[frame["parameter"] == name]
        own = list(dict.fromkeys(rows["cell_name"]))  # cells that have this unknown
        stacks.append((_errors(name, own, [of[names.index(cell)] for cell in own], are_few=are_few),))
        if has_coverage:
            stacks.append((_coverage(rows, own, levels, name, low),))
    said = (
        f"Errors in units of the CRLB: {'dots are runs' if are_few else 'boxes are quartiles, whiskers 2.5 and 97.5 %'}; dotted: the 2.5 and"
        f" 97.5 % of an efficient estimate; numbers at the edges: runs beyond ± {FAR:g}."
    )
    said += (
        f" Beside them the share of intervals that hold the truth, with its 95 % interval; dotted: the confidence level, ± {HELD:g} % shaded."
        if has_coverage
        else ""
    )
    return Chart(_finding(title, names, errors), said, tuple(stacks), 2 if has_coverage else 1, 11.0, most=len(stacks))


def _finding(title: str, names: Sequence[str], errors: Mapping[str, Sequence[Array]]) -> str:
    """The title with the cells of the least and the largest rms error over all unknowns."""
    found = {}
    for number, name in enumerate(names):
        values = [np.asarray(of[number]) for of in errors.values() if number < len(of) and len(of[number])]
        if values:
            found[name] = float(np.sqrt(np.mean(np.concatenate(values) ** 2)))
    if len(found) < 2:
        return title
    near, far = min(found, key=found.__getitem__), max(found, key=found.__getitem__)
    return f"{title}; nearest to the bound: {near}, rms error {two_digits(found[near])} CRLB; farthest: {far}, {two_digits(found[far])} CRLB"


def _errors(name: str, names: Sequence[str], errors: Sequence[Array], *, are_few: bool) -> Panel:
    normal = NormalDist().inv_cdf(0.975)
    at = np.arange(len(errors), dtype=float)
    each_run = [np.full(len(values), row) for row, values in zip(at, errors)]
    shown = (
        Points(np.concatenate(errors), np.concatenate(each_run))
        if are_few
        else Boxes(at, errors, (ENDS[0], ENDS[-1]), "x", 0.6)
    )
    elements: list[Element] = [shown]
    elements += [Level(at=at, along="x", dash="dot" if at else "solid", width=0.8) for at in (-normal, 0.0, normal)]
    for row, values in enumerate(errors):
        if below := int(np.count_nonzero(values < -FAR)):
            elements.append(
                Words(x=-FAR, y=float(row), text=f"◂ {below}", side="left", offset=(2.0, 0.0), has_ground=True)
            )
        if above := int(np.count_nonzero(values > FAR)):
            elements.append(
                Words(x=FAR, y=float(row), text=f"{above} ▸", side="right", offset=(-2.0, 0.0), has_ground=True)
            )
    return Panel(
        tuple(elements),
        Axis("error / CRLB", low=-FAR, high=FAR, better="middle", group="error"),
        named_rows(names, group=name),
        name,
        MARGINS + ROW * len(names),
    )


def _coverage(rows: pd.DataFrame, names: Sequence[str], levels: Sequence[float], name: str, low: float) -> Panel:
    covered = rows["covered_pct"].to_numpy(float)
    left, right = _coverage_ends(rows)
    at = np.array([names.index(cell) for cell in rows["cell_name"]], dtype=float)
    elements: list[Element] = []
    for level in levels:
        elements.append(Span(low=100 * level - HELD, high=100 * level + HELD, along="x", colour=PAPER, opacity=0.08))
        elements.append(Level(at=100 * level, along="x", width=0.8))
    elements.append(Points(covered, at, left=left, right=right, colour=INTERVAL, said="{x:.1f} %"))
    x = Axis("coverage (%)", low=low, high=100.5, group="coverage")
    return Panel(tuple(elements), x, named_rows(names, group=name), f"{name}: coverage", MARGINS + ROW * len(names))


def _coverage_ends(rows: pd.DataFrame) -> Array:
    """Ends of the 95 % intervals of coverages (2, n), %."""
    shares = rows["covered_pct"].to_numpy(float)
    counts = [0 if np.isnan(share) else int(n) for share, n in zip(shares, rows["runs"])]
    ends = [interval(round(share * n / 100) if n else 0, n) for share, n in zip(shares, counts)]
    found: Array = 100 * np.array(ends).reshape(-1, 2).T
    return found


def basins_chart(frame: pd.DataFrame, names: Sequence[str]) -> Chart:
    """In which basin of the likelihood runs end: parts of a bar for each cell."""
    rows = frame.drop_duplicates("cell_name")
    at = [float(names.index(name)) for name in rows["cell_name"]]
    return one_panel(
        stacked_bars(at, {said: (rows[column].fillna(0).to_numpy(float), colour) for column, (said, colour) in BASINS.items()}), Axis("runs (%)"), named_rows(names),
        "Basins", "In which basin of the likelihood the runs of each cell end.", height=MARGINS + ROW * len(names),
    )  # fmt: skip
