"""Course of runs: updating steps, response curves, and progress over cost.

These are the paper's Fig. 3, Figs. 4–7, 10 and 11.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from bench.plan.naming import cell_name
from bench.plan.plan import Plan
from ksmea.arrays import Array
from ksmea.records.curves import ResponseCurves, as_array
from ksmea.records.identification import UpdateRecord
from ksmea.show.charts.chart import Axis, Band, Chart, Choice, Element, Level, Line, Panel, Points, broken
from ksmea.show.charts.colours import CATEGORIES, CONTEXT, MEASURED, MODEL, category, styles
from ksmea.units import MICROMETRE, RPM

MAX_STACKS = 8  # cells in a picture; more would be a poster
MAX_LINES = 40  # repetitions in one panel; more would be a blot
FEW_LINES = 3  # are told apart without being seen through
ACROSS = 4  # cells side by side
LEAST_EXCESS = 1e-3  # of a deviance, below which the data see no difference: drawn as this
AMPLITUDE = "amplitude (µm 0-peak)"


def updates_chart(plan: Plan, histories: Mapping[str, Sequence[UpdateRecord]]) -> Chart:
    """Stiffnesses and misfit against the updating step, as in Fig. 3.

    There is a stack per cell and a line per repetition.
    """
    stacks = tuple(
        _of_cell(
            plan,
            cell,
            [histories.get(run.key, ()) for run in plan.runs if run.cell == cell and run.repetition < MAX_LINES],
        )
        for cell in range(len(plan.cells))
    )
    return Chart(
        f"{plan.name}: the surrogate's optimum at each updating step",
        "Unknowns, and the misfit of the true model, at the surrogate's optimum of each updating step, a line for each repetition; dotted: true values.",
        stacks, min(ACROSS, len(stacks)), 2.9 * min(ACROSS, max(len(stacks), 2)), of_stacks="cell", most=MAX_STACKS,
    )  # fmt: skip


def _of_cell(plan: Plan, cell: int, histories: Sequence[Sequence[UpdateRecord]]) -> tuple[Panel, ...]:
    steps = _joined([list(range(1, len(history) + 1)) for history in histories])
    opacity = 0.4 if len(histories) > FEW_LINES else 1.0
    x = Axis("updating step", is_whole=True, group="step")
    title = cell_name(plan, plan.cells[cell])
    panels = []
    for index, facts in enumerate(plan.cells[cell].parameters[:2]):
        values = _joined([[update.x[index] / facts.si_per_unit for update in history] for history in histories])
        truth = () if facts.truth is None else (Level(at=facts.truth / facts.si_per_unit),)
        label = f"{facts.name} ({facts.unit})"
        line = Line(steps, values, width=1.0, opacity=opacity)
        panels.append(Panel((line, *truth), x, Axis(label, group=label), title if index == 0 else "", 1.7))
    misfit = _joined([as_array([update.misfit for update in history]) for history in histories])
    y = Axis("misfit of the true model", "log", group="misfit", better="low")
    return (*panels, Panel((Line(steps, misfit, width=1.0, opacity=opacity),), x, y, "" if panels else title, 1.7))


def _joined(lines: Sequence[Sequence[float] | Array]) -> Array:
    """Values of several lines, with gaps between them."""
    return np.concatenate([np.empty(0), *(np.append(np.asarray(line, dtype=float), np.nan) for line in lines)])


# From the widest line, which lies below, to the narrowest, so that curves that are alike can all be seen: name, colour, width, dash.
CURVES = {
    "true": ("truth", CONTEXT, 6.0, "solid"), "identified": ("identified", MODEL, 3.0, "solid"), "measured": ("measured", MEASURED, 0.0, ""),
    "modelled": ("model at the surrogate's last optimum", CATEGORIES[4], 1.6, "dash"),
    "predicted": ("surrogate at its last optimum", CATEGORIES[3], 1.2, "dot"),
}  # fmt: skip


def response_chart(plan: Plan, curves: Mapping[int, ResponseCurves]) -> Chart:
    """Amplitude against speed of the first repetition: a stack per cell, a panel per channel.

    They are as in Figs. 4, 6, 7, 10 and 11.
    """
    stacks = tuple(
        tuple(
            _response(of, index, cell_name(plan, plan.cells[cell]) if index == 0 else "")
            for index in range(len(of.channels))
        )
        for cell, of in curves.items()
    )
    return Chart(
        f"{plan.name}, repetition 0, at the measured speeds",
        "Amplitude at the measured speeds, in the first repetition: measured, identified, the surrogate's prediction and the model"
        " at its last optimum, and the truth behind synthetic data. Surrogates know the measured speeds alone, so that peaks between"
        " them are cut off.",
        stacks, min(2, len(stacks)), 8.6, of_stacks="cell", most=MAX_STACKS,
    )  # fmt: skip


def _response(of: ResponseCurves, column: int, title: str) -> Panel:
    speed = as_array(of.speed) / RPM
    elements: list[Element] = []
    for curve, (name, colour, width, dash) in CURVES.items():
        if (values := getattr(of, curve)) is None:
            continue
        drawn = as_array(values)[:, column] / MICROMETRE
        if curve == "measured":
            elements.append(Points(speed, drawn, size=3.5, name=name, colour=colour))
        else:
            line = broken(speed, of.breaks), broken(drawn, of.breaks)
            elements.append(Line(*line, dash, width, name=name, colour=colour, opacity=0.5 if curve == "true" else 1.0))
    x, y = (
        Axis("speed (rpm)", group="speed"),
        Axis(f"{of.channels[column]}\n{AMPLITUDE}", "log", group=of.channels[column]),
    )
    return Panel(tuple(elements), x, y, title, 2.1)


def mesh_chart(coarse: ResponseCurves, fine: ResponseCurves) -> Chart:
    """The true response with 13 and with 21 elements, and their relative difference: the paper's Fig. 5."""
    x = Axis("speed (rpm)")
    responses: list[Element] = []
    differences: list[Element] = []
    for index, channel in enumerate(coarse.channels):
        one, other = (as_array(each.true)[:, index] for each in (coarse, fine))
        speed, of_fine = as_array(coarse.speed) / RPM, as_array(fine.speed) / RPM
        shown = broken(speed, coarse.breaks), broken(one / MICROMETRE, coarse.breaks)
        colour = category(index)
        responses.append(Line(*shown, width=1.0, name=f"13 elements, {channel}", colour=colour))
        responses.append(Points(of_fine, other / MICROMETRE, size=2.5, name=f"21 elements, {channel}", colour=colour))
        differences.append(Line(speed, np.abs(other / one - 1) * 100, name=channel, colour=colour))
    return Chart(
        "True responses with 13 and with 21 elements, at 13 elements' measured speeds",
        "Amplitude of the true response with both meshes, and the difference in per cent.",
        ((Panel(tuple(responses), x, Axis(AMPLITUDE, "log"), height=2.6),), (Panel(tuple(differences), x, Axis("difference (%)", "log"), height=2.6),)),
        across=2, width=8.6,
    )  # fmt: skip


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
