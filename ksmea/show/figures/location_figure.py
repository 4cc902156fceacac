"""The figure of a location: the shaft with p of every site on it, and over speed what acts at the best one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ksmea.arrays import Array
from ksmea.records.location import NONE, NOTHING, PAIR, ForceRecord, LocationRecord, SeriesRecord
from ksmea.show.charts.locators import plain_ticks
from ksmea.show.figures.style import INTERVAL, OURS, PAPER, REFERENCE, ShownFigure, broken, figure_of
from ksmea.units import MICROMETRE, RPM

COLOURS = {"force": OURS, "moment": PAPER, "reading": INTERVAL, "force and moment": "#8a5aa8", PAIR: "#7a7a7a"}
PART_COLOURS = {"x": OURS, "y": PAPER, "forward": INTERVAL, "backward": "#8a5aa8"}
MEGA = 1e6
LINEAR = 1e-2  # of the largest work: below it the axis is linear
N_SD = 2.0  # of the band of a law


def plot(record: LocationRecord, axes: Axes | None = None) -> Figure:
    """The shaft with the sites; below it, where something was found, its amplitude, its work per turn and its dynamic
    stiffness over speed. On given axes the shaft alone."""
    if axes is not None:
        _draw_shaft(axes, record)
        return figure_of(axes)
    force = record.force
    below = [] if force is None else [_draw_amplitude, *([_draw_work, _draw_stiffness] if force.work else [])]
    figure = ShownFigure(figsize=(8.0, 2.9 + 2.1 * len(below)), layout="constrained")
    panels = figure.subplots(1 + len(below), 1, squeeze=False, height_ratios=[1.3, *[1.0] * len(below)])[:, 0]
    _draw_shaft(panels[0], record)
    if force is not None:
        for panel, draw in zip(panels[1:], below):
            draw(panel, record, force)
            panel.grid(alpha=0.25)
            panel.tick_params(labelsize=8)
        panels[-1].set_xlabel("speed (rpm)", fontsize=9)
    figure.suptitle(_title(record) + ("" if force is None else f"\n{_bands(record)}"), fontsize=11)
    return figure


def _bands(record: LocationRecord) -> str:
    of_law = f"; of the law: ± {N_SD:g} σ" if record.law is not None and record.law.amplitude_sd else ""
    return f"bands: {100 * record.interval_level:g} % intervals{of_law}"


def _title(record: LocationRecord) -> str:
    if record.kind == NOTHING:
        return f"The model is enough (p = {record.plain.p:.2g}): nothing needs to be located"
    if record.kind == NONE:
        return "Nothing that was tried explains the data"
    if record.is_spread:
        return "Something unknown at most places explains the data; above the line: not rejected"
    places = [] if record.force is None else [f"{position:g} m" for position in record.force.positions]
    where = f": best at {' and '.join(places)}" if places else ""
    return f"An unknown {record.kind} explains the data{where}; above the line: not rejected"


def _draw_shaft(panel: Axes, record: LocationRecord) -> None:
    """p of each site over its position, above a drawing of the shaft; hollow: rejected."""
    smallest = min([site.p for site in record.candidates], default=1e-3)
    for quantity, colour in COLOURS.items():
        sites = sorted((site for site in record.candidates if site.kind == quantity), key=lambda site: site.position)
        if not sites:
            continue
        places = [(position, site.p) for site in sites for position in site.positions]
        lines = [list(zip(*places))] if quantity != PAIR else [(site.positions, (site.p, site.p)) for site in sites]
        for x, p in lines:  # of a pair from one of its places to the other
            panel.semilogy(x, p, "-", color=colour, linewidth=0.6, alpha=0.5)
        panel.semilogy(*zip(*places), "o", color=colour, markersize=5, markerfacecolor="none", label=quantity)
        kept = [(position, site.p) for site in sites if site.accepted for position in site.positions]
        panel.semilogy(*zip(*kept) if kept else ([], []), "o", color=colour, markersize=7)
    plain_ticks(panel.yaxis)
    panel.axhline(record.level, color=REFERENCE, linewidth=0.8, linestyle="--")
    ground = smallest / 8
    panel.plot(record.shaft, [ground, ground], color=REFERENCE, linewidth=4, solid_capstyle="butt")
    for name, position in record.landmarks.items():
        marker = "^" if name.startswith("bearing") else "|"
        panel.plot(
            [position], [ground], marker, color=REFERENCE, markersize=9 if marker == "^" else 18, markeredgewidth=2.5
        )
        panel.annotate(name, (position, ground), (0, -17), textcoords="offset points", ha="center", fontsize=7)
    for plane in record.planes:
        panel.plot([plane], [ground * 1.9], "v", color=PAPER, markersize=5)
    panel.set_ylim(ground / 4, 1.6)
    panel.set_xlabel("position (m); triangles above the shaft: probes", fontsize=9)
    panel.set_ylabel("p of the site", fontsize=9)
    panel.tick_params(labelsize=8)
    panel.grid(alpha=0.25)
    panel.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.6), frameon=False)


def _draw_amplitude(panel: Axes, record: LocationRecord, force: ForceRecord) -> None:
    in_micrometre = force.parts[0].unit == "m"
    for part in force.parts:
        _draw_series(panel, record, part.amplitude, part.part, MICROMETRE if in_micrometre else 1.0)
    if record.law is not None and (record.law.position, record.law.kind) == (force.position, force.kind):
        for axis, amplitude in zip(("x", "y"), record.law.amplitude):
            label = f"{record.law.law}" if axis == "x" else None
            panel.plot(_rpm(record), _lines(record, amplitude), "--", color=REFERENCE, linewidth=1, label=label)
        for amplitude, sd in zip(record.law.amplitude, record.law.amplitude_sd):
            low, high = (_lines(record, np.array(amplitude) + sign * N_SD * np.array(sd)) for sign in (-1, 1))
            panel.fill_between(_rpm(record), low, high, color=REFERENCE, alpha=0.15, linewidth=0)
    panel.set_yscale("log")
    plain_ticks(panel.yaxis)
    panel.set_ylabel(f"{force.kind} ({'µm' if in_micrometre else force.parts[0].unit})", fontsize=9)
    panel.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)


def _draw_work(panel: Axes, record: LocationRecord, force: ForceRecord) -> None:
    if force.work is None:
        return
    _draw_series(panel, record, force.work, "x")
    panel.axhline(0, color=REFERENCE, linewidth=0.6)
    largest = float(np.max(np.abs(force.work.value))) or 1.0
    panel.set_yscale("symlog", linthresh=LINEAR * largest)
    plain_ticks(panel.yaxis)
    panel.set_ylabel("work (J per turn)\nabove 0: feeds", fontsize=9)


def _draw_stiffness(panel: Axes, record: LocationRecord, force: ForceRecord) -> None:
    """In phase, and dotted in quadrature, of the parts in x and y."""
    shown = [each for each in force.stiffness if each.part in ("x", "y")]
    for each in shown:
        _draw_series(panel, record, each.real, each.part, MEGA)
        panel.plot(_rpm(record), _lines(record, each.imaginary.value) / MEGA, ":", color=PART_COLOURS[each.part])
    values = np.concatenate([each.real.value for each in shown]) / MEGA
    low, high = np.quantile(values, [0.05, 0.95])
    margin = max(high - low, 1e-3)
    panel.set_ylim(low - margin, high + margin)
    panel.axhline(0, color=REFERENCE, linewidth=0.6)
    followed = ", ".join(f"{each.part} {each.coherence:.2f}" for each in shown)
    panel.set_ylabel("dynamic stiffness (MN/m)", fontsize=9)
    panel.set_title(f"line: in phase, dotted: in quadrature; coherence with the motion: {followed}", fontsize=8)


def _draw_series(panel: Axes, record: LocationRecord, series: SeriesRecord, part: str, scale: float = 1.0) -> None:
    colour = PART_COLOURS.get(part, REFERENCE)
    value, low, high = (_lines(record, values) / scale for values in (series.value, series.low, series.high))
    panel.plot(_rpm(record), value, color=colour, linewidth=1.2, label=part)
    panel.fill_between(_rpm(record), low, high, color=colour, alpha=0.15, linewidth=0)


def _rpm(record: LocationRecord) -> Array:
    return _lines(record, record.speed) / RPM


def _lines(record: LocationRecord, values: Sequence[float] | Array) -> Array:
    """Values over speed, a line for each run."""
    return broken(np.array(values), record.breaks)
