"""Figures of a diagnosis: the fit and its residuals by speed and channel before and after, and the ranked effects."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.records.curves import FineCurve
from ksmea.records.diagnosis import CurvesRecord, DiagnosisRecord, Values
from ksmea.show.charts.locators import plain_ticks
from ksmea.show.figures.diagnosis_residuals import as_complex, residuals
from ksmea.show.figures.effect_ranking import AS_WELL, LINEAR, NAMED, OTHER, QUANTITY, best_trials, standing
from ksmea.show.figures.residual_components import COMPONENTS, components
from ksmea.show.figures.response_lines import AMPLITUDE, PHASE, amplitude_line, phase_axis, phase_line
from ksmea.show.figures.style import OURS, PAPER, REFERENCE, ShownFigure, broken
from ksmea.units import MICROMETRE, RPM

BEFORE, AFTER = PAPER, OURS  # colours
IN_GROUP = "#a3c4de"
RANKING_COLOURS = {NAMED: OURS, AS_WELL: IN_GROUP, OTHER: "#bbbbbb"}
COLUMNS, MAX_CHANNELS = 3, 9
BEFOREHAND, AFTERWARDS = "residual / σ\nbefore, ± 2 grey", "residual / σ\nafter, ± 2 grey"
COLOURS = {BEFOREHAND: BEFORE, AFTERWARDS: AFTER}
HEIGHTS = {AMPLITUDE: 2.0, PHASE: 1.2, BEFOREHAND: 1.2, AFTERWARDS: 1.2}
N_SD = 2.0  # of the noise: the band of residuals
LEAST_SHOWN = 1e-6  # of the largest amplitude: where a band on a logarithmic axis ends that reaches to 0


def residual_figure(record: DiagnosisRecord) -> Figure:
    """A column per channel: amplitude measured and fitted, and residuals before and after in units of one law of noise."""
    curves = record.curves
    if curves is None:
        raise SettingError(
            "residuals of a diagnosis: expected a record with its curves, got one without (diagnosis.json leaves them out);"
            " draw the record of the run, or give axes to draw the ranking of effects"
        )
    channels, rows = curves.channels[:MAX_CHANNELS], _rows(curves)
    left = dict(zip(COLOURS, residuals(record).values()))
    fitted = {BEFOREHAND: curves.responses.before, AFTERWARDS: curves.responses.after or ()}
    columns, n_block = min(COLUMNS, len(channels)), -(-len(channels) // COLUMNS)
    heights = [HEIGHTS[row] for row in rows] * n_block
    size = (max(6.0, 2.8 * columns + 0.4), 0.95 * sum(heights) + 1.0)
    figure = ShownFigure(figsize=size, layout="constrained")
    panels = figure.subplots(len(heights), columns, squeeze=False, sharex=True, height_ratios=heights)
    for index, channel in enumerate(channels):
        block, column = divmod(index, columns)
        own = panels[block * len(rows) : (block + 1) * len(rows), column]
        for row, panel in zip(rows, own):
            if row in _DRAW:
                _DRAW[row](panel, curves, index)
            else:
                _draw_residuals(panel, curves, left[row], fitted[row], index, COLOURS[row])
            panel.tick_params(labelsize=8)
            panel.xaxis.set_major_locator(MaxNLocator(4))
            panel.grid(alpha=0.25)
            if column == 0:
                panel.set_ylabel(row, fontsize=8)
        own[0].set_title(channel, fontsize=10)
    for panel in panels.ravel()[:-columns]:
        panel.tick_params(labelbottom=False)
    for panel in panels[-len(rows) :, (len(channels) - 1) % columns + 1 :].ravel():
        panel.set_axis_off()
    for panel in panels[-1]:
        panel.set_xlabel("speed (rpm)", fontsize=9)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    of_residuals, parts = panels[rows.index(BEFOREHAND), 0].get_legend_handles_labels()
    figure.legend(
        handles + of_residuals, labels + parts, loc="outside lower center", ncols=3, fontsize=9, frameon=False
    )
    names = " and ".join(f"{effect.name} ({effect.location})" for effect in record.applied)
    left_out = len(curves.channels) - len(channels)
    more = f"; {left_out} channels more are not shown" if left_out else ""
    figure.suptitle(f"Verdict: {record.verdict}" + (f"; after: with {names}" if names else "") + more, fontsize=11)
    return figure


def _rows(curves: CurvesRecord) -> list[str]:
    """The panels of a channel, by their labels."""
    has_phase = np.ndim(curves.responses.measured) == 3
    after = [AFTERWARDS] if curves.residuals.after is not None else []
    return [AMPLITUDE, *([PHASE] if has_phase else []), BEFOREHAND, *after]


def _models(curves: CurvesRecord) -> Iterator[tuple[str, str, FineCurve]]:
    """Label, colour and curve of the model before and after; at the measured speeds where a record has no finer ones."""
    responses = curves.responses
    for label, colour, fine, coarse in (
        ("model before", BEFORE, curves.fine_before, responses.before),
        ("model after", AFTER, curves.fine_after, responses.after),
    ):
        if fine is not None:
            yield label, colour, fine
        elif coarse is not None:
            values = as_complex(coarse)
            yield (
                label,
                colour,
                FineCurve.of(np.array(curves.speed), values, curves.breaks, with_phase=np.iscomplexobj(values)),
            )


def _draw_amplitude(panel: Axes, curves: CurvesRecord, column: int) -> None:
    speed = np.array(curves.speed) / RPM
    measured = np.abs(as_complex(curves.responses.measured)[:, column]) / MICROMETRE
    panel.semilogy(speed, measured, ".", color=REFERENCE, markersize=4, label="measured")
    if curves.averaged is not None and curves.responses.after is not None:
        line = broken(speed, curves.breaks)
        ends = (np.array(part)[:, column] / MICROMETRE for part in (curves.averaged.low, curves.averaged.high))
        low, high = (broken(np.maximum(end, LEAST_SHOWN * np.max(measured)), curves.breaks) for end in ends)
        panel.fill_between(line, low, high, color=IN_GROUP, alpha=0.5, linewidth=0, label="averaged, its interval")
    for label, colour, curve in _models(curves):
        panel.semilogy(*amplitude_line(curve, column), color=colour, linewidth=1, label=label)
    plain_ticks(panel.yaxis)


def _draw_phase(panel: Axes, curves: CurvesRecord, column: int) -> None:
    measured = np.degrees(np.angle(as_complex(curves.responses.measured)[:, column]))
    panel.plot(np.array(curves.speed) / RPM, measured, ".", color=REFERENCE, markersize=4)
    for _, colour, curve in _models(curves):
        if curve.phase is not None:
            panel.plot(*phase_line(curve, column), color=colour, linewidth=1)
    phase_axis(panel)


_DRAW: dict[str, Callable[[Axes, CurvesRecord, int], None]] = {AMPLITUDE: _draw_amplitude, PHASE: _draw_phase}


def _draw_residuals(
    panel: Axes, curves: CurvesRecord, residuals: Array | ComplexArray, fitted: Values, column: int, colour: str
) -> None:
    """Both components of complex residuals, or real ones, with the band of two standard deviations."""
    values, turned_by = residuals[:, column], as_complex(fitted)[:, column]
    parts = components(values, turned_by) if np.iscomplexobj(values) else (values,)
    panel.axhspan(-N_SD, N_SD, color=REFERENCE, alpha=0.08)
    for part, marker, name in zip(parts, "ox", COMPONENTS):
        label = f"residual {name}" if len(parts) > 1 else None
        panel.plot(np.array(curves.speed) / RPM, part, marker, color=colour, markersize=2.5, alpha=0.8, label=label)
    panel.axhline(0, color=REFERENCE, linewidth=0.6)
    limit = max(4.0, 1.1 * float(np.max(np.abs(parts))))
    panel.set_ylim(-limit, limit)


def ranking_figure(record: DiagnosisRecord) -> Figure:
    """The ranked effects on a figure of their own."""
    figure = ShownFigure(figsize=(7.5, 0.3 * len(record.effects) + 1.2), layout="constrained")
    draw_ranking(record, figure.subplots())
    return figure


def draw_ranking(record: DiagnosisRecord, axes: Axes) -> None:
    """ΔBIC of the best location of each effect, coloured where it is named or explains the data about as well."""
    trials = best_trials(record)[::-1]
    axes.set_xscale("symlog", linthresh=LINEAR)  # before the bars, whose margins it sets
    plain_ticks(axes.xaxis)
    for rank, colour in RANKING_COLOURS.items():
        mine = [(at, trial.delta_bic) for at, trial in enumerate(trials) if standing(record, trial.effect) == rank]
        if mine:
            axes.barh(*zip(*mine), color=colour, label=rank)
    axes.set_yticks(range(len(trials)), [f"{trial.effect} ({trial.location})" for trial in trials], fontsize=8)
    axes.axvline(0, color=REFERENCE, linewidth=0.8)
    axes.set_ylim(-0.7, len(trials) - 0.3)
    axes.set_xlabel(QUANTITY, fontsize=8)
    axes.tick_params(axis="x", labelsize=8)
    axes.grid(axis="x", alpha=0.25)
    if trials:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(RANKING_COLOURS), fontsize=8, frameon=False)
