"""How runs went: the updating steps (the paper's Fig. 3), and what was reached at which cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from bench.plan.naming import cell_name
from bench.plan.plan import Plan
from ksmea.arrays import Array
from ksmea.records.curves import as_array
from ksmea.records.identification import UpdateRecord
from ksmea.show.charts.chart import Axis, Band, Chart, Choice, Element, Level, Line, Panel, Points
from ksmea.show.charts.colours import CONTEXT, MODEL, styles

MAX_STACKS = 8  # cells in a picture; more would be a poster
MAX_LINES = 40  # repetitions in one panel; more would be a blot
FEW_LINES = 3  # have a median and quartiles; fewer are drawn alone
ACROSS = 4  # cells side by side
LEAST_EXCESS = 1e-3  # of a deviance, below which the data see no difference: drawn as this


def updates_chart(plan: Plan, histories: Mapping[str, Sequence[UpdateRecord]]) -> Chart:
    """Stiffnesses and misfit against the updating step, a stack per cell, as in Fig. 3.

    Each run is thin; the median and quartiles of the runs are bold.
    """
    of_cells = [
        [histories.get(run.key, ()) for run in plan.runs if run.cell == cell and run.repetition < MAX_LINES]
        for cell in range(len(plan.cells))
    ]
    stacks = tuple(_of_cell(plan, cell, [each for each in found if each]) for cell, found in enumerate(of_cells))
    return Chart(
        f"{figure_number(plan, 'updates')}{_updates_finding(plan, of_cells)}",
        "Unknowns, and the misfit of the true model, at the surrogate's optimum of each updating step. Thin: each repetition;"
        " bold: median, band: quartiles, in which a run that has ended keeps its last value; dotted: true values.",
        stacks, min(ACROSS, len(stacks)), 2.9 * min(ACROSS, max(len(stacks), 2)), of_stacks="cell", most=MAX_STACKS,
    )  # fmt: skip


def figure_number(plan: Plan, kind: str) -> str:
    """'Fig. 3. ' of a figure of the paper; empty for others.

    Source: Han, Guo & Gao 2013, doi 10.1016/j.jsv.2012.12.025.
    """
    number = PAPER_FIGURES.get((plan.report.paper or "", kind))
    return "" if number is None else f"Fig. {number}. "


PAPER_FIGURES = {
    ("table2", "updates"): 3, ("table2", "surrogate"): 4, ("table3", "identified"): 6, ("table3", "surrogate"): 7,
    ("table8", "identified"): 10, ("table8", "surrogate"): 11,
}  # fmt: skip


def _updates_finding(plan: Plan, of_cells: Sequence[Sequence[Sequence[UpdateRecord]]]) -> str:
    """Range over the cells of the median number of updates, for each label."""
    medians: dict[str, list[float]] = {}
    for cell, found in zip(plan.cells, of_cells):
        if counts := [len(history) for history in found if history]:
            medians.setdefault(str(cell.place.get("label") or ""), []).append(float(np.median(counts)))
    if not medians:
        return "No run has updated its surrogate yet"
    ranges = [f"{label}: {_range(values)}" if label else _range(values) for label, values in medians.items()]
    return f"Updating steps until the end of a run (median): {', '.join(ranges)}"


def _range(values: Sequence[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _of_cell(plan: Plan, cell: int, histories: Sequence[Sequence[UpdateRecord]]) -> tuple[Panel, ...]:
    steps = [np.arange(1.0, len(history) + 1) for history in histories]
    x = Axis("updating step", is_whole=True, group="step")
    title = cell_name(plan, plan.cells[cell])
    panels = []
    for index, facts in enumerate(plan.cells[cell].parameters[:2]):
        values = [np.array([update.x[index] for update in history]) / facts.si_per_unit for history in histories]
        truth = () if facts.truth is None else (Level(at=facts.truth / facts.si_per_unit),)
        label = f"{facts.name} ({facts.unit})"
        elements = (*_of_runs(steps, values), *truth)
        panels.append(Panel(elements, x, Axis(label, group=label), title if index == 0 else "", 1.7))
    misfit = [as_array([update.misfit for update in history]) for history in histories]
    y = Axis("misfit of the true model", "log", group="misfit", better="low")
    return (*panels, Panel(_of_runs(steps, misfit), x, y, "" if panels else title, 1.7))


def _of_runs(steps: Sequence[Array], values: Sequence[Array]) -> tuple[Element, ...]:
    """Each run thin; of several, also their quartiles and median.

    In these a run keeps its last value after its end.
    """
    alone = len(values) < FEW_LINES
    thin = Line(
        _joined(steps), _joined(values), width=1.0 if alone else 0.7, opacity=1.0 if alone else 0.45,
        colour=MODEL if alone else CONTEXT, name="" if alone else "each run",
    )  # fmt: skip
    if alone:
        return (thin,)
    longest = max(map(len, values))
    held = np.array([np.append(own, np.full(longest - len(own), own[-1])) for own in values])
    low, middle, high = np.nanpercentile(np.where(np.isfinite(held), held, np.nan), (25, 50, 75), axis=0)
    at = np.arange(1.0, longest + 1)
    return thin, Band(at, low, high, name="quartiles"), Line(at, middle, width=2.0, name="median")


def _joined(lines: Sequence[Sequence[float] | Array]) -> Array:
    """Values of several lines, with gaps between them."""
    return np.concatenate([np.empty(0), *(np.append(np.asarray(line, dtype=float), np.nan) for line in lines)])


REACHED = {"excess": "misfit above its least", "error": "rms error of the unknowns (CRLB)"}


def anytime_chart(plan: Plan, frame: pd.DataFrame, stages: pd.DataFrame) -> Chart:
    """Excess and error of the best point so far against the cost: medians as lines and quartiles as bands.

    A dot where a stage of the method ended and another followed, a cross where the last run ended.
    """
    price = " or ".join(map(str, sorted(set(frame["jacobian_price"]))))
    x = Axis(f"evaluations of the true model, a Jacobian as {price}", "log", group="cost")
    names = [cell_name(plan, cell) for cell in plan.cells]
    stacks = []
    for column, label in REACHED.items():
        elements: list[Element] = [Level(at=1.0)]
        for name, (colour, dash) in styles(names).items():
            rows = frame[frame["cell"] == names.index(name)]
            ends = stages[(stages["cell"] == names.index(name)) & ~stages["on_surrogate"].astype(bool)].iloc[:-1]
            if len(rows):
                elements += _reached(rows, ends, column, name, colour, dash)
        least = f", at least {LEAST_EXCESS:g}" if column == "excess" else ""
        stacks.append((Panel(tuple(elements), x, Axis(label + least, "log", better="low"), height=3.6),))
    return Chart(
        f"{plan.name}: the best point so far, medians and quartiles of {int(frame['runs'].max())} runs",
        "Misfit and error of the best point so far against the cost: medians over the runs, quartiles as bands. Dots: a stage of the method"
        " ended; crosses: the last run ended.",
        tuple(stacks), across=2, width=9.6, choices=(Choice("cell", "cell", tuple(names)),) if len(names) > 1 else (),
    )  # fmt: skip


def _reached(rows: pd.DataFrame, ends: pd.DataFrame, column: str, name: str, colour: str, dash: str) -> list[Element]:
    cost = rows["cost"].to_numpy(float)
    low, middle, high = (
        _seen(rows[f"{column}_{quartile}"].to_numpy(float), column) for quartile in ("q1", "median", "q3")
    )
    at = (ends["evaluations"] + rows["jacobian_price"].iloc[0] * ends["jacobians"]).to_numpy(float)
    behind = np.searchsorted(cost, at, side="right") - 1
    tags = {"cell": name}
    return [
        Band(cost, low, high, is_stepped=True, colour=colour, tags=tags),
        Line(cost, middle, dash, is_stepped=True, name=name, colour=colour, tags=tags),
        Points(cost[-1:], middle[-1:], "x", 5.0, colour=colour, tags=tags),
        Points(at[behind >= 0], middle[behind[behind >= 0]], colour=colour, tags=tags),
    ]


def _seen(values: Array, column: str) -> Array:
    """Values as a logarithmic axis can show them: what is infinitely far is not."""
    shown = np.maximum(values, LEAST_EXCESS) if column == "excess" else values
    return np.where(np.isfinite(shown), shown, np.nan)
