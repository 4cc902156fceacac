"""Data, fit and residuals of one identification over speed: a column per channel."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.arrays import Array
from ksmea.records.curves import FitCurves, as_array
from ksmea.show.charts.locators import plain_ticks
from ksmea.show.figures.response_lines import AMPLITUDE, PHASE, amplitude_line, column, phase_axis, phase_line
from ksmea.show.figures.style import INTERVAL, OURS, PAPER, REFERENCE, ShownFigure
from ksmea.units import MICROMETRE, RPM

MAX_CHANNELS = 4  # columns; the record has all
MAX_ERROR_BARS = 400  # more points than this are drawn without
COMPONENTS = (("in phase", OURS, "o"), ("in quadrature", INTERVAL, "s"))
FAR = 10.0  # residuals beyond this are drawn on an axis that is logarithmic beyond half of it


def fit_figure(fit: FitCurves, title: str = "") -> Figure:
    """Amplitude (with ± 1 σ), phase where there is one, and residuals in units of the noise; dotted: ± 2."""
    n_channel = min(len(fit.channels), MAX_CHANNELS)
    with_phase = fit.has_phase
    rows = ["amplitude", *(["phase"] if with_phase else []), *(["residual"] if fit.sd is not None else [])]
    heights = [{"amplitude": 3, "phase": 1.6, "residual": 1.6}[row] for row in rows]
    figure = ShownFigure(figsize=(max(7.0, 2.8 * n_channel + 0.6), 1.15 * sum(heights) + 1.2), layout="constrained")
    panels = figure.subplots(len(rows), n_channel, squeeze=False, sharex=True, sharey="row", height_ratios=heights)
    draw = {"amplitude": draw_amplitude, "phase": _phase, "residual": _residual}
    for index in range(n_channel):
        for row, panel in zip(rows, panels[:, index]):
            draw[row](panel, fit, index)
            panel.grid(alpha=0.25)
            panel.tick_params(labelsize=8)
        panels[0, index].set_title(fit.channels[index], fontsize=10)
        panels[-1, index].set_xlabel("speed (rpm)", fontsize=9)
    labels = {"amplitude": AMPLITUDE, "phase": PHASE, "residual": "residual / σ\n(dotted: ± 2)"}
    for row, panel in zip(rows, panels[:, 0]):
        panel.set_ylabel(labels[row], fontsize=9)
    handles, names = panels[0, 0].get_legend_handles_labels()
    if "residual" in rows and with_phase:
        more_handles, more_names = panels[-1, 0].get_legend_handles_labels()
        handles, names = handles + more_handles, names + [f"residual {name}" for name in more_names]
    figure.legend(handles, names, loc="outside lower center", ncols=4, frameon=False, fontsize=9)
    left_out = len(fit.channels) - n_channel
    figure.suptitle(title + (f" ({left_out} channels more are not shown)" if left_out else ""), fontsize=11)
    return figure


def draw_amplitude(panel: Axes, fit: FitCurves, index: int) -> None:
    """Measured and fitted amplitude (µm) of one channel over speed (rpm)."""
    speed, measured = as_array(fit.speed) / RPM, column(fit.measured.amplitude, index) / MICROMETRE
    style: Any = {"fmt": "o", "color": OURS, "markersize": 3.5, "elinewidth": 0.9, "alpha": 0.8}
    sd = None
    if fit.sd is not None and len(speed) <= MAX_ERROR_BARS:
        # of complex data, sd is the total one; along the amplitude lies 1/√2 of it
        sd = column(fit.sd, index) / MICROMETRE / (np.sqrt(2) if fit.has_phase else 1)
        sd = np.stack([np.minimum(sd, 0.95 * measured), sd])  # the axis is logarithmic
    panel.errorbar(speed, measured, sd, label="measured ± 1 σ" if sd is not None else "measured", **style)
    panel.plot(*amplitude_line(fit.fine, index), color=PAPER, linewidth=1.3, label="fitted", zorder=3)
    panel.set_yscale("log")
    plain_ticks(panel.yaxis)


def _phase(panel: Axes, fit: FitCurves, index: int) -> None:
    panel.plot(*phase_line(fit.fine, index), color=PAPER, linewidth=1.3, zorder=3)
    panel.plot(
        as_array(fit.speed) / RPM, np.degrees(column(fit.measured.phase, index)), "o", color=OURS,
        markersize=3.5, alpha=0.8,
    )  # fmt: skip
    phase_axis(panel)


def _residual(panel: Axes, fit: FitCurves, index: int) -> None:
    speed, scaled_parts = as_array(fit.speed) / RPM, residuals(fit, index)
    for scaled, (name, colour, marker) in zip(scaled_parts, COMPONENTS):
        panel.plot(speed, scaled, marker, color=colour, markersize=3, alpha=0.8, label=name)
    for at in (-2, 0, 2):
        panel.axhline(at, color=REFERENCE, linestyle=":" if at else "-", linewidth=0.8)
    if max(np.abs(scaled).max() for scaled in scaled_parts) > FAR:
        panel.set_yscale("symlog", linthresh=FAR / 2)
        plain_ticks(panel.yaxis)


def residuals(fit: FitCurves, index: int) -> list[Array]:
    """Measured minus fitted in units of the noise, (n_speed,): of amplitudes one; of complex data the components along the
    fitted response and at right angles to it, whose standard deviations are both 1."""
    sd = column(fit.sd, index)
    measured, fitted = column(fit.measured.amplitude, index), column(fit.fitted.amplitude, index)
    if not fit.has_phase:
        return [(measured - fitted) / sd]
    turn = column(fit.measured.phase, index) - column(fit.fitted.phase, index)
    scaled = np.sqrt(2) * (measured * np.exp(1j * turn) - fitted) / sd
    return [scaled.real, scaled.imag]
