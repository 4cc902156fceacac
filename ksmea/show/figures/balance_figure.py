"""The figure of a balancing: the bare response with and without the correction, drift over the runs, and which runs stand out."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.records.balancing import BalanceRecord
from ksmea.show.charts.locators import plain_ticks
from ksmea.show.figures.style import COLOURS, INTERVAL, OURS, PAPER, REFERENCE, ShownFigure, figure_of
from ksmea.units import RPM

SMALLEST_P = 1e-16  # drawn
FAR_APART = 20  # largest to smallest amplitude, from which on the axis is logarithmic


def plot(record: BalanceRecord, axes: Axes | None = None) -> Figure:
    """On given axes the responses alone."""
    if axes is not None:
        _draw_responses(axes, record)
        return figure_of(axes)
    draws = [_draw_responses]
    draws += [_draw_drift] if record.drift else []
    draws += [_draw_runs] if record.method == "free" else []
    figure = ShownFigure(figsize=(8.0, 0.8 + 2.4 * len(draws)), layout="constrained")
    for panel, draw in zip(figure.subplots(len(draws), 1, squeeze=False)[:, 0], draws):
        draw(panel, record)
        panel.grid(alpha=0.25)
        panel.tick_params(labelsize=8)
    return figure


def _draw_responses(panel: Axes, record: BalanceRecord) -> None:
    found, at = record.correction, np.arange(len(record.entries))
    panel.bar(at - 0.2, [each.size for each in found.bare], 0.4, color=PAPER, label="bare")
    panel.bar(at + 0.2, [each.size for each in found.left], 0.4, color=OURS, label="with the correction")
    for index, each in enumerate(found.left):
        if each.low is not None and each.high is not None:
            panel.plot([index + 0.2] * 2, [each.low, each.high], color=REFERENCE, linewidth=1.2)
    sizes = [each.size for each in (*found.bare, *found.left) if each.size > 0]
    if sizes and max(sizes) > FAR_APART * min(sizes):  # what is left could not be seen beside what was there
        panel.set_yscale("log")
        panel.set_ylim(bottom=0.5 * min(sizes))
        plain_ticks(panel.yaxis)
    labels = ["\n".join([f"{each.speed / RPM:.0f}", *each.channel.split(" at ")]) for each in record.entries]
    step = 1 + len(at) // 12
    panel.set_xticks(at[::step], labels[::step], fontsize=8)
    panel.set_ylabel("amplitude (µm 0-peak)", fontsize=9)
    panel.legend(fontsize=8, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)


def _draw_drift(panel: Axes, record: BalanceRecord) -> None:
    """Real parts drawn through, imaginary parts dotted, over the runs in the order of time."""
    at = np.arange(len(record.runs))
    for index, each in enumerate(record.drift):
        colour = COLOURS[index % len(COLOURS)]
        label = f"{each.entry.speed / RPM:.0f} rpm, {each.entry.channel}"
        panel.plot(at, each.real, color=colour, linewidth=1.0, label=label)
        panel.plot(at, each.imaginary, ":", color=colour, linewidth=1.2)
    gaps = np.diff(record.run_time)
    for pause in np.flatnonzero(gaps > 10 * np.median(gaps)):
        panel.axvline(float(pause) + 0.5, color=REFERENCE, linewidth=0.6, linestyle="--")
    panel.set_ylabel("drift (µm)\nline: real, dotted: imaginary", fontsize=8)
    panel.set_xlabel("run in the order of time; dashed: a pause", fontsize=8)
    panel.legend(fontsize=7, ncols=3, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)


def _draw_runs(panel: Axes, record: BalanceRecord) -> None:
    p = np.maximum(record.run_p, SMALLEST_P)
    limit = record.level / max(record.n_run, 1)
    panel.semilogy(np.arange(len(p)), p, "o", color=INTERVAL, markersize=3.5)
    plain_ticks(panel.yaxis)
    panel.axhline(limit, color=REFERENCE, linewidth=0.8, linestyle="--")
    for index in np.flatnonzero(p < limit).tolist():
        panel.annotate(record.runs[index], (index, p[index]), (4, 0), textcoords="offset points", fontsize=7)
    panel.set_ylabel("p of the run's weights", fontsize=9)
    panel.set_xlabel("run in the order of time; below the line: a misfit", fontsize=8)
