"""Campbell diagram and stability map: frequencies and logarithmic decrements of the followed modes over spin speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ksmea.arrays import Array
from ksmea.rotordynamics.whirl import Branches, CriticalSpeed, Rotordynamics
from ksmea.show.figures.style import COLOURS, REFERENCE, ShownFigure, figure_of
from ksmea.show.figures.ticks import plain_ticks
from ksmea.units import HERTZ, RPM

WHIRL = {1.0: ("forward", COLOURS[0]), -1.0: ("backward", COLOURS[1]), 0.0: ("mixed", COLOURS[3])}
MAX_LABELS = 10  # critical speeds at 1X with their amplification factor beside them
OFFSETS = ((10.0, -15.0), (-6.0, 14.0), (34.0, -30.0), (-30.0, 30.0))  # of these words from their point, in points
AT_EDGE = 0.8  # of the highest speed: behind it words stand on the left of their point
NEAR = 0.09  # of the highest speed: closer ones have their words on different sides
CLOSE = 0.002  # relative: a frequency between two scanned speeds is not quite on the straight line
FAR_FROM_STABLE = 0.5  # of a logarithmic decrement: more than this is well damped, and the axis bends above


def campbell_figure(found: Rotordynamics, axes: Axes | None = None) -> Figure:
    """Damped natural frequencies by direction of whirl, lines of the harmonics, and where they meet: the critical speeds, with
    their amplification factors at 1X."""
    if axes is None:
        axes = ShownFigure(figsize=(8.0, 6.0), layout="constrained").subplots()
        axes.set_title(f"Campbell diagram, {found.title}", fontsize=11)
    branches, shown = found.branches, np.isfinite(found.branches.frequency)
    _draw_branches(axes, branches, branches.frequency / HERTZ)
    top = 1.08 * float(branches.frequency[shown].max(initial=0.0)) / HERTZ or 1.0
    right = found.highest / RPM
    for harmonic in found.harmonics:
        axes.plot([0, right], [0, harmonic * found.highest / HERTZ], "--", color=REFERENCE, linewidth=0.9)
        end = min(right, top / (harmonic * RPM / HERTZ))
        axes.annotate(f"{harmonic:g}X", (end, end * harmonic * RPM / HERTZ), (-16, 3 if end == right else -8), textcoords="offset points",
                      ha="right", va="top", fontsize=9, color=REFERENCE)  # fmt: skip
    marked = [each for each in found.critical_speeds if _is_on_a_branch(each, branches)]
    at_1x = [each for each in marked if each.harmonic == 1.0][:MAX_LABELS]
    for each in marked:
        marker = "o" if each.harmonic == 1.0 else "s"
        axes.plot(each.speed / RPM, each.harmonic * each.speed / HERTZ, marker, color="black",
                  markerfacecolor="white", markersize=6, zorder=5)  # fmt: skip
    for each, offset in zip(at_1x, _offsets([each.speed for each in at_1x], NEAR * found.highest)):
        factor = each.amplification_factor
        factor_text = "unstable" if factor is None else f"AF {factor:.3g}" if factor < 100 else f"AF {factor:.0f}"
        is_at_edge = each.speed > AT_EDGE * found.highest
        place, side = ((-12.0, abs(offset[1])), "right") if is_at_edge else (offset, "left")
        axes.annotate(f"{each.speed / RPM:.0f} rpm, {factor_text}", (each.speed / RPM, each.speed / HERTZ), place,
                      textcoords="offset points", ha=side, fontsize=8, zorder=6, arrowprops={"arrowstyle": "-", "linewidth": 0.6},
                      bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "alpha": 0.85, "linewidth": 0})  # fmt: skip
    axes.set(xlim=(0, right), ylim=(0, top))
    axes.set_ylabel("natural frequency (Hz)", fontsize=10)
    more = [Line2D([], [], color="black", marker="o", markerfacecolor="white", linestyle="", label="critical speed")]
    if any(each.harmonic != 1.0 for each in found.critical_speeds):
        more.append(
            Line2D([], [], color="black", marker="s", markerfacecolor="white", linestyle="", label="at a harmonic")
        )
    _finish(axes, branches, more)
    return figure_of(axes)


def stability_figure(found: Rotordynamics, axes: Axes | None = None) -> Figure:
    """Logarithmic decrement of the modes over speed: below 0 a free motion grows. The first such speed is marked."""
    if axes is None:
        axes = ShownFigure(figsize=(8.0, 4.8), layout="constrained").subplots()
        axes.set_title(f"Stability, {found.title}", fontsize=11)
    decrement = found.branches.log_decrement
    _draw_branches(axes, found.branches, decrement)
    axes.axhline(0.0, color=REFERENCE, linewidth=1.0)
    low, high = (float(end(decrement[np.isfinite(decrement)], initial=0.0)) for end in (np.min, np.max))
    if high > 10 * FAR_FROM_STABLE:
        axes.set_yscale("symlog", linthresh=FAR_FROM_STABLE)
        plain_ticks(axes.yaxis)
    axes.set_ylim(min(1.1 * low, -0.05 * min(high, FAR_FROM_STABLE)), 1.1 * high or 1.0)
    axes.axhspan(axes.get_ylim()[0], 0.0, color="#D55E00", alpha=0.10, linewidth=0)
    axes.text(0.01, 0.01, "unstable", transform=axes.transAxes, fontsize=9, color="#a04000", va="bottom")
    if np.isfinite(found.threshold):
        axes.axvline(found.threshold / RPM, color="black", linestyle=":", linewidth=1.4)
        label = f"threshold {found.threshold / RPM:.0f} rpm" if found.threshold else "unstable from rest"
        axes.annotate(label, (found.threshold / RPM, 0.97), (4, 0),
                      xycoords=("data", "axes fraction"), textcoords="offset points", va="top", fontsize=9)  # fmt: skip
    axes.set_xlim(0, found.highest / RPM)
    axes.set_ylabel("logarithmic decrement", fontsize=10)
    _finish(axes, found.branches, [])
    return figure_of(axes)


def _draw_branches(axes: Axes, branches: Branches, values: Array) -> None:
    """A line for each mode in the colours of its direction of whirl, numbered at its right end."""
    speed = branches.speed / RPM
    for column in range(values.shape[1]):
        for start, end, direction in _pieces(branches.direction[:, column]):
            axes.plot(speed[start:end], values[start:end, column], color=WHIRL[direction][1], linewidth=1.6)


def _pieces(direction: Array) -> Iterator[tuple[int, int, float]]:
    """From, to (exclusive) and direction of runs of the same direction; each reaches one further, so that lines join."""
    start = 0
    for index in range(1, len(direction) + 1):
        if index == len(direction) or direction[index] != direction[start]:
            if np.isfinite(direction[start]):
                yield start, min(index + 1, len(direction)), float(direction[start])
            start = index


def _is_on_a_branch(critical: CriticalSpeed, branches: Branches) -> bool:
    """Whether a critical speed lies on one of the modes that are drawn."""
    at = np.searchsorted(branches.speed, critical.speed).clip(1, len(branches.speed) - 1)
    ends = branches.frequency[at - 1 : at + 1]
    low, high = np.nanmin(ends, axis=0, initial=np.inf), np.nanmax(ends, axis=0, initial=-np.inf)
    frequency = critical.harmonic * critical.speed
    return bool(np.any((low <= (1 + CLOSE) * frequency) & (high >= (1 - CLOSE) * frequency)))


def _offsets(speeds: Sequence[float], near: float) -> list[tuple[float, float]]:
    """Where the words of each rising speed stand beside its point: those of neighbours on different sides, ever further away."""
    place, found = 0, []
    for index, speed in enumerate(speeds):
        place = place + 1 if index and speed - speeds[index - 1] < near else 0
        found.append(OFFSETS[place % len(OFFSETS)])
    return found


def _finish(axes: Axes, branches: Branches, more: list[Line2D]) -> None:
    there = set(branches.direction[np.isfinite(branches.direction)].tolist())
    handles = [Line2D([], [], color=colour, label=name) for sign, (name, colour) in WHIRL.items() if sign in there]
    figure = figure_of(axes)
    if len(figure.axes) == 1:
        figure.legend(handles=[*handles, *more], loc="outside lower center", ncols=5, fontsize=9, frameon=False)
    else:
        axes.legend(handles=[*handles, *more], fontsize=8)
    axes.set_xlabel("speed (rpm)", fontsize=10)
    axes.tick_params(labelsize=9)
    axes.grid(alpha=0.25)
