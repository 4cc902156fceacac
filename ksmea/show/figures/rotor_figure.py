"""A rotor to scale: shaft, disks, bearings, unbalance and probes over the length of the shaft."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from itertools import cycle, pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from ksmea.measurement.channel import named
from ksmea.rotordynamics.layout import DiskOutline, RotorLayout
from ksmea.show.figures.style import INTERVAL, OURS, PAPER, REFERENCE, ShownFigure, figure_of
from ksmea.units import GRAM_MILLIMETRE, MILLIMETRE

SHAFT, DISK, SPRING = "#c9d3dc", "#7f97ab", "#444444"
WIDTH = 8.0  # inches
IN_METRES = 3.0  # m, from which length on the axis is in m
THINNEST = 0.008  # of the length: a thinner disk is drawn as wide as this
ROW = 0.055  # of the length, between rows of text
WORDS = 0.085  # of the length, as wide as those of a disk
NEAR = 0.24  # of the length: words of places closer than this stand in different rows


def rotor_figure(layout: RotorLayout, title: str = "", axes: Axes | None = None) -> Figure:
    """The rotor in one plane, both axes of one scale; its axis is in mm, of long rotors in m."""
    given = axes is not None
    if axes is None:
        axes = ShownFigure(figsize=(WIDTH, _height(layout)), layout="constrained").subplots()
    unit, name = (1.0, "m") if layout.length >= IN_METRES else (MILLIMETRE, "mm")
    draw = _Scaled(axes, layout, unit)
    draw.shaft()
    draw.disks()
    draw.bearings()
    draw.marks_above()
    draw.dimensions()
    axes.set_aspect("equal")
    axes.set_xlabel(f"position along the shaft ({name})", fontsize=9)
    axes.set_ylabel(f"radius ({name})", fontsize=9)
    axes.tick_params(labelsize=8)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if title and not given:
        axes.set_title(title, fontsize=11)
    return figure_of(axes)


def _height(layout: RotorLayout) -> float:
    low, high = _Scaled.reach(layout)
    return float(np.clip(WIDTH * 0.9 * (high - low) / (1.12 * layout.length) + 0.9, 2.8, 9.0))


class _Scaled:
    """A drawing in the unit of its axes. Lengths of symbols follow that of the shaft."""

    def __init__(self, axes: Axes, layout: RotorLayout, unit: float) -> None:
        self.axes, self.layout, self.unit = axes, layout, unit
        self.length = layout.length
        low, high = self.reach(layout)
        axes.set_xlim(-0.06 * self.length / unit, 1.06 * self.length / unit)
        axes.set_ylim(low / unit, high / unit)
        radius = layout.largest_radius / unit
        ticks = [tick for tick in np.linspace(-radius, radius, 3)]
        axes.set_yticks(ticks, [f"{abs(tick):.4g}" for tick in ticks])
        axes.spines["left"].set_bounds(-radius, radius)

    @staticmethod
    def reach(layout: RotorLayout) -> tuple[float, float]:
        """From below the dimensions to above the marks, m."""
        radius = layout.largest_radius
        rows = max((first + len(mark.lines) for mark, first in _stacked(_marks(layout), layout.length)), default=0)
        above = radius + (1.6 + rows) * ROW * layout.length
        below = max(radius, 0.1 * layout.length) + max(_drops(layout), default=0.0)
        return -below - 3.4 * ROW * layout.length, above

    def shaft(self) -> None:
        for each in self.layout.sections:
            for low, high in ((each.inner_radius, each.outer_radius), (-each.outer_radius, -each.inner_radius)):
                if each.inner_radius == 0 and low < 0:
                    continue  # one rectangle is the whole of a solid section
                base = -each.outer_radius if each.inner_radius == 0 else low
                self._box(each.start, base, each.end - each.start, high - base, SHAFT)
        overhang = 0.03 * self.length / self.unit
        ends = (-overhang, self.length / self.unit + overhang)
        self.axes.plot(ends, (0, 0), color=REFERENCE, linewidth=0.7, dashes=(12, 3, 2, 3))

    def disks(self) -> None:
        drops = _drops(self.layout)
        for number, (disk, drop) in enumerate(zip(self.layout.disks, drops), start=1):
            width, top = max(disk.thickness, THINNEST * self.length), _top(disk, self.layout)
            if disk.outer_radius is None:
                self.axes.plot(disk.position / self.unit, 0, "o", color=DISK, markeredgecolor="black", markersize=9)
            else:
                height = disk.outer_radius - disk.bore_radius
                for base in (disk.bore_radius, -disk.outer_radius):
                    self._box(disk.position - width / 2, base, width, height, DISK)
            below = -top - 0.012 * self.length - drop
            self._text(disk.position, below, f"disk {number}\n{disk.mass:.3g} kg", "black", "top")

    def bearings(self) -> None:
        size = 0.035 * self.length
        for number, bearing in enumerate(self.layout.bearings, start=1):
            radius = self.layout.shaft_radius(bearing.position)
            for sign in (1, -1):
                corners = [(0, sign * radius), (-size / 2, sign * (radius + size)), (size / 2, sign * (radius + size))]
                points = [((bearing.position + x) / self.unit, y / self.unit) for x, y in corners]
                self.axes.add_patch(Polygon(points, facecolor="white", edgecolor=SPRING, linewidth=1.2, zorder=4))
                if self.layout.support:
                    self._box(bearing.position - 0.7 * size, sign * (radius + size) - (sign < 0) * 0.35 * size,
                              1.4 * size, 0.35 * size, "#e6dcc8")  # fmt: skip
            below = -radius - (1.45 if self.layout.support else 1.0) * size
            self._text(bearing.position, below - 0.012 * self.length, f"bearing {number}", SPRING, "top")

    def marks_above(self) -> None:
        """Unbalance, probes and effects: a line to each place, and its words where those of no other place are."""
        foot = self.layout.largest_radius + 0.9 * ROW * self.length
        for mark, first in _stacked(_marks(self.layout), self.length):
            level, start = foot + first * ROW * self.length, self.layout.shaft_radius(mark.place)
            colour = mark.lines[0][1]
            line = ((mark.place / self.unit,) * 2, (start / self.unit, level / self.unit))
            self.axes.plot(*line, color=colour, linewidth=0.9, zorder=5)
            self.axes.plot(mark.place / self.unit, start / self.unit, "v", color=colour, markersize=5, zorder=6)
            edge = "left" if mark.place < 0.1 * self.length else "right" if mark.place > 0.9 * self.length else "center"
            for row, (words, own) in enumerate(mark.lines):
                self._text(mark.place, level + row * ROW * self.length, words, own, "bottom", edge)

    def dimensions(self) -> None:
        """Lengths between all places where something sits or a section ends, below the rotor."""
        layout = self.layout
        stops = {
            0.0,
            layout.length,
            *(disk.position for disk in layout.disks),
            *(each.position for each in layout.bearings),
        }
        places = _apart(sorted(stops), 1e-6 * self.length)
        level = self.reach(layout)[0] + 0.9 * ROW * self.length
        previous_row = cycle((0.0, 0.55 * ROW * self.length))
        for left, right in pairwise(places):
            short = right - left < 0.07 * self.length
            at = level / self.unit
            arrow = {"arrowstyle": "<->", "linewidth": 0.8, "color": REFERENCE, "shrinkA": 0, "shrinkB": 0}
            self.axes.annotate("", (left / self.unit, at), (right / self.unit, at), arrowprops=arrow)
            drop = next(previous_row) if short else 0.0
            self._text(
                (left + right) / 2,
                level - 0.006 * self.length - drop,
                f"{(right - left) / self.unit:.5g}",
                REFERENCE,
                "top",
            )
        for place in places:
            self.axes.plot((place / self.unit,) * 2, ((level - 0.01 * self.length) / self.unit, (level + 0.02 * self.length) / self.unit),
                           color=REFERENCE, linewidth=0.6)  # fmt: skip

    def _box(self, left: float, bottom: float, width: float, height: float, colour: str) -> None:
        corner = (left / self.unit, bottom / self.unit)
        size = (width / self.unit, height / self.unit)
        self.axes.add_patch(Rectangle(corner, *size, facecolor=colour, edgecolor="black", linewidth=0.8, zorder=3))

    def _text(self, x: float, y: float, text: str, colour: str, vertical: str, horizontal: str = "center") -> None:
        self.axes.text(
            x / self.unit, y / self.unit, text, color=colour, fontsize=8, va=vertical, ha=horizontal, zorder=7
        )


def _drops(layout: RotorLayout) -> list[float]:
    """How far (m) the words of each disk stand lower than those of others: by two lines beside a near one."""
    drops: list[float] = []
    for index, disk in enumerate(layout.disks):
        near = index > 0 and disk.position - layout.disks[index - 1].position < WORDS * layout.length
        drops.append(1.6 * ROW * layout.length if near and not drops[-1] else 0.0)
    return drops


def _top(disk: DiskOutline, layout: RotorLayout) -> float:
    """Half the height of a disk as it is drawn, m."""
    return disk.outer_radius if disk.outer_radius is not None else 2 * layout.shaft_radius(disk.position)


@dataclass(frozen=True)
class _Mark:
    """What is drawn above one place (m): lines of words with their colours."""

    place: float
    lines: tuple[tuple[str, str], ...]


def _marks(layout: RotorLayout) -> list[_Mark]:
    lines: dict[float, list[tuple[str, str]]] = defaultdict(list)
    directions: dict[float, list[str]] = defaultdict(list)
    for probe in layout.probes:
        if probe.direction not in directions[probe.position]:
            directions[probe.position].append(probe.direction)
    for place, found in directions.items():
        lines[place].append((f"probe {', '.join(map(named, found))}", INTERVAL))
    for plane in layout.unbalance:
        angle = f" at {math.degrees(plane.phase):.0f}°" if plane.phase else ""
        lines[plane.position].append((f"unbalance {plane.magnitude / GRAM_MILLIMETRE:.4g} g mm{angle}", PAPER))
    for effect in layout.effects:
        for place in effect.positions:
            lines[place].append((effect.name, OURS))
    return [_Mark(place, tuple(found)) for place, found in sorted(lines.items())]


def _stacked(marks: list[_Mark], length: float) -> list[tuple[_Mark, int]]:
    """Each mark with the lowest row from which on its lines are free of those of the places next to it."""
    placed: list[tuple[_Mark, int]] = []
    for mark in marks:
        near = [(first, first + len(each.lines)) for each, first in placed if mark.place - each.place < NEAR * length]
        free = [0, *(end for _, end in near)]
        first = min(row for row in free if all(row + len(mark.lines) <= low or row >= end for low, end in near))
        placed.append((mark, first))
    return placed


def _apart(places: list[float], least: float) -> list[float]:
    """Rising places without those that are less than `least` behind another one."""
    kept = places[:1]
    for place in places[1:]:
        if place - kept[-1] > least:
            kept.append(place)
    return kept
