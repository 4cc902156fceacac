"""How the half-widths of the intervals change with the data: a panel per variation, a line per unknown."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, NullLocator

from ksmea.arrays import Array
from ksmea.records.identifiability import IdentifiabilityRecord, Unknown, Variation
from ksmea.show.charts.locators import plain_ticks
from ksmea.show.figures.style import COLOURS, MARKERS, ShownFigure, figure_of
from ksmea.units import RPM

HEADINGS = {
    "speeds": "number of speeds in the band",
    "band": "band (rpm), with as many speeds",
    "position": "position of one measuring plane (m)",
    "noise": "noise, times the present",
    "kind": "kind of data",
}
CARET = "$\\uparrow$"  # of what lies beyond the upper edge
MIN_PCT, MAX_PCT = 1e-3, 1e4  # what lies beyond stands at the upper edge as an arrow


def plot(record: IdentifiabilityRecord, axes: Axes | None = None, *, title: str = "") -> Figure:
    """Half-widths of the intervals in per cent of the values (of the range of its search for a value of 0 and for an angle,
    which the legend says). Dotted: the data as they are; grey: not even the size can be told.

    Without axes a figure with a panel for each variation; on given axes the first of them. A record without variations
    shows the data as they are.
    """
    panelled = _panelled(record)
    if axes is not None or not panelled:
        return _one_panel(record, axes)
    columns = min(2, len(panelled))
    n_row = -(-len(panelled) // columns)
    figure = ShownFigure(figsize=(4.1 * columns + 0.4, 3.1 * n_row + 0.9), layout="constrained")
    panels = figure.subplots(n_row, columns, squeeze=False, sharey=True).ravel()
    limits = _axis_limits([entry.crlb_si for entries in panelled.values() for entry in entries], record)
    for panel, (name, entries) in zip(panels, panelled.items()):
        _draw(panel, name, entries, record, limits)
    for panel in panels[len(panelled) :]:
        panel.set_axis_off()
    for panel in panels[: len(panelled) : columns]:
        panel.set_ylabel(_quantity(record), fontsize=9)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=min(len(labels), 6 if all(each.base for each in record.parameters) else 4),
        frameon=False,
        fontsize=9,
    )
    of_what = f"{title}: " if title else ""
    figure.suptitle(f"{of_what}how well the unknowns can be known (dotted: as it is; grey: not at all)", fontsize=11)
    return figure


def _one_panel(record: IdentifiabilityRecord, axes: Axes | None) -> Figure:
    """The first variation on given axes, or on those of a new figure; the data as they are where there is none."""
    figure = ShownFigure(figsize=(5.6, 4.0), layout="constrained") if axes is None else figure_of(axes)
    panel = figure.subplots() if axes is None else axes
    panelled = _panelled(record)
    if panelled:
        name, entries = next(iter(panelled.items()))
        limits = _axis_limits([entry.crlb_si for entry in entries], record)
        _draw(panel, name, entries, record, limits)
        panel.legend(fontsize=8)
    else:
        _draw_present(panel, record)
    panel.set_ylabel(_quantity(record), fontsize=9)
    return figure


def _panelled(record: IdentifiabilityRecord) -> dict[str, list[Variation]]:
    """The variations that have a panel; two kinds of data have one only where nothing else was varied."""
    by_name: dict[str, list[Variation]] = {}
    for entry in record.variations:
        by_name.setdefault(entry.variation, []).append(entry)
    return {name: entries for name, entries in by_name.items() if name != "kind"} or by_name


def _quantity(record: IdentifiabilityRecord) -> str:
    return f"± (%), {100 * record.level:g} % interval"


def half_widths(crlbs: Sequence[Array], record: IdentifiabilityRecord) -> Array:
    """Half-widths (n, d), %, of CRLBs (n, d), SI."""
    measure = [abs(item.base) or item.upper - item.lower for item in record.parameters]
    widths: Array = 100 * record.sigmas * np.array(crlbs) / measure
    return widths


def label(parameter: Unknown) -> str:
    """Its name, and what its per cent are of where that is not its value."""
    return parameter.name if parameter.base else f"{parameter.name} (% of its range)"


def _axis_limits(crlbs: list[Array], record: IdentifiabilityRecord) -> tuple[float, float]:
    """Around all that is finite, and 100 % in it."""
    widths = np.clip(half_widths(crlbs, record), MIN_PCT, MAX_PCT)
    return 0.6 * float(np.min(widths)), 1.7 * max(100.0, float(np.max(widths)))


def _draw(
    panel: Axes, name: str, entries: list[Variation], record: IdentifiabilityRecord, limits: tuple[float, float]
) -> None:
    abscissa = _abscissa(name, entries)
    is_named = name in ("band", "kind")
    n_parameter = len(record.parameters)
    widths = half_widths([entry.crlb_si for entry in entries], record)
    present = half_widths([record.crlb_si], record)[0]
    for index, (parameter, colour, mark) in enumerate(zip(record.parameters, cycle(COLOURS), cycle(MARKERS))):
        x = abscissa + (0.6 * ((index + 0.5) / n_parameter - 0.5) if is_named else 0.0)
        shown = np.minimum(widths[:, index], MAX_PCT)
        style = mark if is_named else f"{mark}-"
        panel.plot(x, shown, style, color=colour, markersize=4.5, linewidth=1.4, label=label(parameter))
        beyond = widths[:, index] > MAX_PCT
        panel.plot(x[beyond], shown[beyond], marker=CARET, linestyle="", color=colour, markersize=8)
        panel.axhline(min(present[index], MAX_PCT), color=colour, linestyle=":", linewidth=0.9, alpha=0.7)
    panel.set_title(HEADINGS[name], fontsize=10)
    _ticks(panel, name, entries, abscissa)
    _finish(panel, limits)


def _draw_present(panel: Axes, record: IdentifiabilityRecord) -> None:
    """A dot per unknown."""
    widths = half_widths([record.crlb_si], record)[0]
    for index, colour, own in zip(range(len(widths)), cycle(COLOURS), cycle(MARKERS)):
        marker = own if widths[index] <= MAX_PCT else CARET
        panel.plot([index], [min(widths[index], MAX_PCT)], marker=marker, linestyle="", color=colour, markersize=7)
    panel.set_xticks(range(len(widths)), list(map(label, record.parameters)))
    panel.set_title("the data as they are", fontsize=10)
    _finish(panel, _axis_limits([record.crlb_si], record))


def _finish(panel: Axes, limits: tuple[float, float]) -> None:
    panel.set_yscale("log")
    panel.set_ylim(*limits)
    panel.axhspan(100, 10 * MAX_PCT, color="#999999", alpha=0.12, linewidth=0)
    plain_ticks(panel.yaxis)
    panel.tick_params(labelsize=8)
    panel.grid(alpha=0.25)


def _abscissa(name: str, entries: list[Variation]) -> Array:
    if name in ("band", "kind"):
        return np.arange(len(entries), dtype=float)
    return np.array([entry.value for entry in entries], dtype=float)


def _ticks(panel: Axes, name: str, entries: list[Variation], abscissa: Array) -> None:
    if name == "band":
        bands = [entry.value for entry in entries if isinstance(entry.value, tuple)]
        labels = [f"{low / RPM:.0f}–{high / RPM:.0f}" for low, high in bands]
        panel.set_xticks(abscissa, labels, rotation=35, ha="right")
    elif name == "kind":
        panel.set_xticks(abscissa, [str(entry.value) for entry in entries])
    elif name in ("speeds", "noise"):
        panel.set_xscale("log")
        panel.set_xticks(abscissa, [f"{value:g}" for value in abscissa])
        panel.xaxis.set_minor_locator(NullLocator())
        panel.xaxis.set_minor_formatter(NullFormatter())
