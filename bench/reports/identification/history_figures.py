"""Figures of single runs: the updating steps (the paper's Fig. 3) and response curves (Figs. 4–7, 10 and 11)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bench.plan.naming import cell_name
from bench.plan.plan import Plan
from ksmea.records.curves import ResponseCurves, as_array
from ksmea.records.identification import UpdateRecord
from ksmea.show.charts.ticks import plain_ticks
from ksmea.show.figures.style import COLOURS, OURS, REFERENCE, broken
from ksmea.units import MICROMETRE, RPM

MAX_ROWS = 8  # cells in one figure; more would be a poster
MAX_LINES = 40  # repetitions in one panel; more would be a blot


def updates_figure(plan: Plan, histories: Mapping[str, Sequence[UpdateRecord]]) -> Figure:
    """Stiffnesses and misfit against the updating step, a row per cell and a line per repetition, as in Fig. 3."""
    cells = list(range(len(plan.cells)))[:MAX_ROWS]
    n_shown = max(min(2, len(plan.cells[cell].parameters)) for cell in cells)
    figure = Figure(figsize=(2.9 * (n_shown + 1), 2.2 * len(cells) + 0.6), layout="constrained")
    panels = figure.subplots(len(cells), n_shown + 1, squeeze=False)
    for row, cell in zip(panels, cells):
        runs = [histories.get(run.key, []) for run in plan.runs if run.cell == cell and run.repetition < MAX_LINES]
        facts = plan.cells[cell].parameters
        for panel in row[len(facts) : -1]:
            panel.set_axis_off()
        for index, panel in enumerate(row[: min(len(facts), n_shown)]):
            scale = facts[index].si_per_unit
            for history in runs:
                steps = np.arange(1, len(history) + 1)
                panel.plot(steps, [update.x[index] / scale for update in history], color=OURS, alpha=0.35, linewidth=1)
            if (truth := facts[index].truth) is not None:
                panel.axhline(truth / scale, color=REFERENCE, linestyle=":")
            panel.set_ylabel(f"{facts[index].name} ({facts[index].unit})", fontsize=8)
        for history in runs:
            misfits = as_array([update.misfit for update in history])
            row[-1].semilogy(np.arange(1, len(history) + 1), misfits, color=OURS, alpha=0.35, linewidth=1)
        plain_ticks(row[-1].yaxis)
        row[-1].set_ylabel("misfit of the FE model", fontsize=8)
        row[0].set_title(cell_name(plan, plan.cells[cell]), fontsize=9, loc="left")
    _finish(panels, "updating step")
    figure.suptitle(f"{plan.name}: the surrogate's optimum at each updating step, a line per repetition", fontsize=10)
    return figure


def response_figure(plan: Plan, curves: Mapping[int, ResponseCurves]) -> Figure:
    """Amplitude against speed of one repetition: measured and identified on the left (Figs. 6 and 10), surrogate and FE
    model at the surrogate's last optimum on the right (Figs. 4, 7 and 11); a row per cell, channels one over another."""
    cells = list(curves)[:MAX_ROWS]
    figure = Figure(figsize=(8.6, 2.5 * len(cells) + 1.0), layout="constrained")
    panels = figure.subplots(len(cells), 2, squeeze=False)
    for (left, right), cell in zip(panels, cells):
        _draw(left, curves[cell], {"measured": ".", "identified": "-"})
        _draw(right, curves[cell], {"predicted": ".", "modelled": "-"})
        left.set_title(cell_name(plan, plan.cells[cell]), fontsize=9, loc="left")
        handles, labels = left.get_legend_handles_labels()
        more_handles, more_labels = right.get_legend_handles_labels()
    figure.legend(
        handles + more_handles,
        labels + more_labels,
        loc="outside lower center",
        ncols=4 if len(handles) < 5 else 2,
        fontsize=8,
        frameon=False,
    )
    _finish(panels, "speed (rpm)")
    figure.suptitle(
        f"{plan.name}, repetition 0, at the measured speeds.\nLeft: measured and identified. Right: final surrogate and FE model",
        fontsize=10,
    )
    return figure


def mesh_figure(coarse: ResponseCurves, fine: ResponseCurves) -> Figure:
    """The true response with 13 and with 21 elements, and their relative difference: the paper's Fig. 5."""
    figure = Figure(figsize=(8.6, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    _draw(left, coarse, {"true": "-"}, " (13 elements)")
    _draw(left, fine, {"true": "."}, " (21 elements)")
    left.legend(fontsize=7, loc="lower right")
    one, other = as_array(coarse.true), as_array(fine.true)
    speed = as_array(coarse.speed) / RPM
    for index, channel in enumerate(coarse.channels):
        right.semilogy(
            speed, np.abs(other[:, index] / one[:, index] - 1) * 100, color=COLOURS[index % len(COLOURS)], label=channel
        )
    plain_ticks(right.yaxis)
    right.set_ylabel("difference (%)", fontsize=8)
    right.legend(fontsize=7)
    _finish(np.array([[left, right]]), "speed (rpm)")
    figure.suptitle("Unbalance response at the reference values, 13 against 21 elements", fontsize=10)
    return figure


def _draw(panel: Axes, curves: ResponseCurves, styles: Mapping[str, str], remark: str = "") -> None:
    """Curves of all channels, a colour per channel and a style per curve; µm over rpm."""
    speed = as_array(curves.speed) / RPM
    for name, style in styles.items():
        drawn = getattr(curves, name)
        if drawn is None:
            continue
        values = as_array(drawn)
        for index, channel in enumerate(curves.channels):
            colour = COLOURS[index % len(COLOURS)]
            panel.semilogy(
                broken(speed, curves.breaks), broken(values[:, index] / MICROMETRE, curves.breaks), style, color=colour, markersize=4, linewidth=1,
                label=f"{name}{remark}, {channel}",
            )  # fmt: skip
    plain_ticks(panel.yaxis)
    panel.set_ylabel("amplitude (µm 0-peak)", fontsize=8)


def _finish(panels: np.ndarray, label: str) -> None:
    for panel in panels.ravel():
        panel.tick_params(labelsize=7)
        panel.grid(alpha=0.25)
    for panel in panels[-1]:
        panel.set_xlabel(label, fontsize=8)
