"""Figures of a diagnosis: the fit and its residuals by speed and channel before and after, and the ranked effects."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.show.style import OURS, PAPER, REFERENCE
from ksmea.units import MICROMETRE, RPM

WHEN = {"before": PAPER, "after": OURS}  # colours
MOST_CHANNELS = 8


def residual_figure(record: Mapping[str, Any]) -> Figure:
    """A column per channel: amplitude measured and fitted, and residuals in units of the noise, before and after."""
    curves = record["curves"]
    speed = np.array(curves["speed"]) / RPM
    channels = curves["channels"][:MOST_CHANNELS]
    figure = Figure(figsize=(max(5.0, 3.1 * len(channels)), 6.4), layout="constrained")
    panels = figure.subplots(3, len(channels), squeeze=False, sharex=True, height_ratios=[2, 1, 1])
    for column, (top, *below) in enumerate(panels.T):
        top.semilogy(
            speed,
            _amplitude(curves["responses"]["measured"], column) / MICROMETRE,
            ".",
            color=REFERENCE,
            label="measured",
        )
        for when, colour in WHEN.items():
            if when in curves["responses"]:
                top.semilogy(
                    speed,
                    _amplitude(curves["responses"][when], column) / MICROMETRE,
                    color=colour,
                    linewidth=1,
                    label=f"model {when}",
                )
        top.set_title(channels[column], fontsize=9)
        for panel, when in zip(below, WHEN):
            if when in curves["residuals"]:
                _draw_residuals(panel, speed, curves["residuals"][when], column, WHEN[when])
            else:
                panel.set_axis_off()
        panels[-1, column].set_xlabel("speed (rpm)", fontsize=8)
        below[0].set_xlabel("speed (rpm)" if "after" not in curves["residuals"] else "", fontsize=8)
    panels[0, 0].set_ylabel("amplitude (µm)", fontsize=8)
    for panel, when in zip(panels[1:, 0], WHEN):
        panel.set_ylabel(f"residual / noise, {when}", fontsize=8)
    for panel in panels.ravel():
        panel.tick_params(labelsize=7)
        panel.grid(alpha=0.25)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=8, frameon=False)
    names = " and ".join(f"{effect['name']} ({effect['place']})" for effect in record["applied"])
    figure.suptitle(f"Verdict: {record['verdict']}" + (f"; after: with {names}" if names else ""), fontsize=11)
    return figure


def _draw_residuals(panel: Axes, speed: np.ndarray, values: Any, column: int, colour: str) -> None:
    """Both parts of complex residuals, or real ones, with the band of two standard deviations."""
    parts = np.array(values)[:, column]
    scale = np.sqrt(2) if parts.ndim == 2 else 1.0  # a complex residual of unit variance has parts of half of it
    panel.axhspan(-2, 2, color=REFERENCE, alpha=0.08)
    for part, marker in zip(np.atleast_2d(parts.T), "ox"):
        panel.plot(speed, part * scale, marker, color=colour, markersize=2.5, alpha=0.8)
    panel.axhline(0, color=REFERENCE, linewidth=0.6)
    limit = max(4.0, 1.1 * float(np.abs(parts).max()) * scale)
    panel.set_ylim(-limit, limit)


def _amplitude(values: Any, column: int) -> np.ndarray:
    parts = np.array(values)[:, column]
    return np.hypot(*parts.T) if parts.ndim == 2 else np.abs(parts)


def trials_figure(record: Mapping[str, Any]) -> Figure:
    """ΔBIC of the best place of each effect; those that count as found are filled."""
    best: dict[str, Mapping[str, Any]] = {}
    for trial in record["ranking"]:
        best.setdefault(trial["effect"], trial)
    trials = list(best.values())[::-1]
    figure = Figure(figsize=(7.5, 0.3 * len(trials) + 1.2), layout="constrained")
    panel = figure.subplots()
    found = [trial["p"] < record["lack_of_fit"]["level"] for trial in trials]
    colours = [OURS if is_found else "#bbbbbb" for is_found in found]
    panel.barh(range(len(trials)), [trial["delta_bic"] for trial in trials], color=colours)
    panel.set_yticks(range(len(trials)), [f"{trial['effect']} ({trial['place']})" for trial in trials], fontsize=8)
    panel.axvline(0, color=REFERENCE, linewidth=0.8)
    panel.set_xscale("symlog", linthresh=10)
    panel.xaxis.set_major_formatter("{x:g}")
    panel.set_xlabel("ΔBIC in favour of the effect; blue: found", fontsize=8)
    panel.tick_params(axis="x", labelsize=8)
    panel.grid(axis="x", alpha=0.25)
    return figure
