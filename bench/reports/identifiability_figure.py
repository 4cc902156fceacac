"""How the bounds change with the data: a panel per variation, a line per unknown."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from ksmea.units import RPM

COLOURS = ("#2b6ca3", "#c8501e", "#3a8f4d", "#8a5aa8", "#b08a00", "#555555", "#d16ba5", "#17a2b8")
HEADINGS = {
    "speeds": "number of speeds in the band",
    "band": "band (rpm), with as many speeds",
    "position": "position of one measuring plane (m)",
    "noise": "noise, times the present",
    "kind": "kind of data",
}
LEAST_PCT, MOST_PCT = 1e-3, 1e4  # what lies beyond stands at the upper edge as an arrow


def identifiability_figure(title: str, record: Mapping[str, Any]) -> Figure:
    """Half-widths of the intervals in per cent of the values (of the width of its bounds for a value of 0). Dotted: the
    data as they are; grey: not even the size can be told."""
    by_variation: dict[str, list[Mapping[str, Any]]] = {}
    for entry in record["variations"]:
        by_variation.setdefault(entry["variation"], []).append(entry)
    panelled = {name: entries for name, entries in by_variation.items() if name != "kind"} or by_variation
    columns = min(2, len(panelled))
    n_row = -(-len(panelled) // columns)
    figure = Figure(figsize=(5.2 * columns + 0.4, 3.5 * n_row + 0.7), layout="constrained")
    panels = figure.subplots(n_row, columns, squeeze=False, sharey=True).ravel()
    limits = _limits([entry["bound"] for entries in panelled.values() for entry in entries], record)
    for panel, (name, entries) in zip(panels, panelled.items()):
        _panel(panel, name, entries, record, limits)
    for panel in panels[len(panelled) :]:
        panel.set_axis_off()
    for panel in panels[: len(panelled) : columns]:
        panel.set_ylabel(f"± (%), {100 * record['level']:g} % interval", fontsize=9)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 9), frameon=False, fontsize=9)
    figure.suptitle(f"{title}: how well the unknowns can be known (dotted: as it is; grey: not at all)", fontsize=11)
    return figure


def _widths(bounds: list[list[float | None]], record: Mapping[str, Any]) -> np.ndarray:
    """(n, d) %, of 1-σ bounds (n, d), SI."""
    measure = [abs(item["true"]) or item["upper"] - item["lower"] for item in record["parameters"]]
    return 100 * record["sigmas"] * np.array([[np.inf if b is None else b for b in row] for row in bounds]) / measure


def _limits(bounds: list[list[float | None]], record: Mapping[str, Any]) -> tuple[float, float]:
    """Of the axis, around all that is finite, and 100 % in it."""
    widths = np.clip(_widths(bounds, record), LEAST_PCT, MOST_PCT)
    return 0.6 * float(np.min(widths)), 1.7 * max(100.0, float(np.max(widths)))


def _panel(
    panel: Axes, name: str, entries: list[Mapping[str, Any]], record: Mapping[str, Any], limits: tuple[float, float]
) -> None:
    places = _places(name, entries)
    is_named = name in ("band", "kind")
    n_parameter = len(record["parameters"])
    widths = _widths([entry["bound"] for entry in entries], record)
    present = _widths([[item["bound"] for item in record["parameters"]]], record)[0]
    for index, (parameter, colour) in enumerate(zip(record["parameters"], cycle(COLOURS))):
        x = places + (0.6 * ((index + 0.5) / n_parameter - 0.5) if is_named else 0.0)
        shown = np.minimum(widths[:, index], MOST_PCT)
        style = "o" if is_named else "o-"
        panel.plot(x, shown, style, color=colour, markersize=4.5, linewidth=1.4, label=parameter["name"])
        beyond = widths[:, index] > MOST_PCT
        panel.plot(x[beyond], shown[beyond], "^", color=colour, markersize=8)
        panel.axhline(min(present[index], MOST_PCT), color=colour, linestyle=":", linewidth=0.9, alpha=0.7)
    panel.set_yscale("log")
    panel.set_ylim(*limits)
    panel.axhspan(100, 10 * MOST_PCT, color="#999999", alpha=0.12, linewidth=0)
    panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    panel.set_title(HEADINGS[name], fontsize=10)
    _ticks(panel, name, entries, places)
    panel.tick_params(labelsize=8)
    panel.grid(alpha=0.25)


def _places(name: str, entries: list[Mapping[str, Any]]) -> np.ndarray:
    if name in ("band", "kind"):
        return np.arange(len(entries), dtype=float)
    return np.array([entry["value"] for entry in entries], dtype=float)


def _ticks(panel: Axes, name: str, entries: list[Mapping[str, Any]], places: np.ndarray) -> None:
    if name == "band":
        labels = [f"{entry['value'][0] / RPM:.0f}–{entry['value'][1] / RPM:.0f}" for entry in entries]
        panel.set_xticks(places, labels, rotation=35, ha="right")
    elif name == "kind":
        panel.set_xticks(places, [entry["value"] for entry in entries])
    elif name in ("speeds", "noise"):
        panel.set_xscale("log")
        panel.set_xticks(places, [f"{place:g}" for place in places])
        panel.xaxis.set_minor_locator(NullLocator())
        panel.xaxis.set_minor_formatter(NullFormatter())
