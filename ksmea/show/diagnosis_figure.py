"""Figures of a diagnosis: the fit and its residuals by speed and channel before and after, and the ranked effects."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.records.diagnosis import CurvesRecord, DiagnosisRecord, TrialRecord, Values
from ksmea.show.style import OURS, PAPER, REFERENCE, ShownFigure, broken
from ksmea.units import MICROMETRE, RPM

BEFORE, AFTER = PAPER, OURS  # colours
NAMED, IN_GROUP, OTHER = OURS, "#a3c4de", "#bbbbbb"
MAX_CHANNELS = 8
LEAST_SHOWN = 1e-6  # of the largest amplitude: where a band on a logarithmic axis ends that reaches to 0


def residual_figure(record: DiagnosisRecord) -> Figure:
    """A column per channel: amplitude measured and fitted, and residuals in units of the noise, before and after."""
    curves = record.curves
    if curves is None:
        raise SettingError(
            "residuals of a diagnosis: expected a record with its curves, got one without (diagnosis.json leaves them out);"
            " draw the record of the run, or give axes to draw the ranking of effects"
        )
    channels = curves.channels[:MAX_CHANNELS]
    figure = ShownFigure(figsize=(max(5.0, 3.1 * len(channels)), 6.4), layout="constrained")
    panels = figure.subplots(3, len(channels), squeeze=False, sharex=True, height_ratios=[2, 1, 1])
    for column, channel in enumerate(channels):
        _draw_channel(panels[:, column], curves, column)
        panels[0, column].set_title(channel, fontsize=9)
    for panel, text in zip(panels[:, 0], ("amplitude (µm)", "residual / noise, before", "residual / noise, after")):
        panel.set_ylabel(text, fontsize=8)
    for panel in panels.ravel():
        panel.tick_params(labelsize=7)
        panel.grid(alpha=0.25)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=8, frameon=False)
    names = " and ".join(f"{effect.name} ({effect.location})" for effect in record.applied)
    figure.suptitle(f"Verdict: {record.verdict}" + (f"; after: with {names}" if names else ""), fontsize=11)
    return figure


def _draw_channel(panels: np.ndarray, curves: CurvesRecord, column: int) -> None:
    """One channel on three panels: amplitudes, residuals before, residuals after."""
    top, middle, bottom = panels
    speed = np.array(curves.speed) / RPM
    responses, residuals = curves.responses, curves.residuals
    measured = _amplitude(responses.measured, column) / MICROMETRE
    top.semilogy(speed, measured, ".", color=REFERENCE, label="measured")
    before = _amplitude(responses.before, column) / MICROMETRE
    line = broken(speed, curves.breaks)
    top.semilogy(line, broken(before, curves.breaks), color=BEFORE, linewidth=1, label="model before")
    _draw_residuals(middle, speed, residuals.before, column, BEFORE)
    if responses.after is None or residuals.after is None:
        bottom.set_axis_off()
        middle.set_xlabel("speed (rpm)", fontsize=8)
        return
    if curves.averaged is not None:
        ends = (np.array(part)[:, column] / MICROMETRE for part in (curves.averaged.low, curves.averaged.high))
        band = [broken(np.maximum(end, LEAST_SHOWN * np.max(measured)), curves.breaks) for end in ends]
        top.fill_between(line, *band, color=IN_GROUP, alpha=0.5, linewidth=0, label="averaged, its interval")
    after = _amplitude(responses.after, column) / MICROMETRE
    top.semilogy(line, broken(after, curves.breaks), color=AFTER, linewidth=1, label="model after")
    _draw_residuals(bottom, speed, residuals.after, column, AFTER)
    bottom.set_xlabel("speed (rpm)", fontsize=8)


def _draw_residuals(panel: Axes, speed: Array, values: Values, column: int, colour: str) -> None:
    """Both parts of complex residuals, or real ones, with the band of two standard deviations."""
    parts = np.array(values)[:, column]
    scale = np.sqrt(2) if parts.ndim == 2 else 1.0  # a complex residual of unit variance has parts of half of it
    panel.axhspan(-2, 2, color=REFERENCE, alpha=0.08)
    for part, marker in zip(np.atleast_2d(parts.T), "ox"):
        panel.plot(speed, part * scale, marker, color=colour, markersize=2.5, alpha=0.8)
    panel.axhline(0, color=REFERENCE, linewidth=0.6)
    limit = max(4.0, 1.1 * float(np.abs(parts).max()) * scale)
    panel.set_ylim(-limit, limit)


def _amplitude(values: Values, column: int) -> Array:
    parts = np.array(values)[:, column]
    amplitude: Array = np.hypot(*parts.T) if parts.ndim == 2 else np.abs(parts)
    return amplitude


def ranking_figure(record: DiagnosisRecord) -> Figure:
    """The ranked effects on a figure of their own."""
    figure = ShownFigure(figsize=(7.5, 0.3 * len(record.effects) + 1.2), layout="constrained")
    draw_ranking(record, figure.subplots())
    return figure


def draw_ranking(record: DiagnosisRecord, axes: Axes) -> None:
    """ΔBIC of the best location of each effect. Only effects that are named, or that the data do not tell from these, are
    coloured: with a misfit that is large enough, nearly every effect lowers the deviance significantly."""
    best: dict[str, TrialRecord] = {}
    for trial in record.ranking:
        best.setdefault(trial.effect, trial)
    trials = list(best.values())[::-1]
    axes.barh(
        range(len(trials)),
        [trial.delta_bic for trial in trials],
        color=[_colour(record, trial.effect) for trial in trials],
    )
    axes.set_yticks(range(len(trials)), [f"{trial.effect} ({trial.location})" for trial in trials], fontsize=8)
    axes.axvline(0, color=REFERENCE, linewidth=0.8)
    axes.set_xscale("symlog", linthresh=10)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("ΔBIC in favour of the effect" + _key(record), fontsize=8)
    axes.tick_params(axis="x", labelsize=8)
    axes.grid(axis="x", alpha=0.25)


def _colour(record: DiagnosisRecord, effect: str) -> str:
    if effect in record.named:
        return NAMED
    return IN_GROUP if effect in record.ambiguity_group else OTHER


def _key(record: DiagnosisRecord) -> str:
    if not record.named:
        return ""
    is_ambiguous = len(record.ambiguity_group) > len(record.named)
    return "; blue: named" + (", light blue: as well supported by the data" if is_ambiguous else "")
