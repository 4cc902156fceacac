"""A rotor to scale: shaft, disks, bearings, unbalance and probes over the length of the shaft."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import cycle, pairwise
from typing import Literal

import numpy as np

from ksmea.measurement.channel import named
from ksmea.rotordynamics.layout import DiskOutline, RotorLayout
from ksmea.show.charts.chart import Area, Axis, Chart, Element, Line, Points, Words, one_panel
from ksmea.show.charts.colours import EARTH, GROUND, INK, INTERVAL, MODEL, PALE_STEEL, PAPER, REFERENCE, STEEL
from ksmea.units import GRAM_MILLIMETRE, MILLIMETRE

Side = Literal["left", "center", "right"]
Edge = Literal["top", "bottom"]
WIDTH = 8.0  # inches
IN_METRES = 3.0  # m, from which length on the axis is in m
THINNEST = 0.008  # of the length: a thinner disk is drawn as wide as this
ROW = 0.055  # of the length, between rows of text
WORDS = 0.085  # of the length, as wide as those of a disk
NEAR = 0.24  # of the length: words of places closer than this stand in different rows


def rotor_chart(layout: RotorLayout, title: str = "") -> Chart:
    """The rotor in one plane, both axes of one scale; its axis is in mm, of long rotors in m."""
    unit, name = (1.0, "m") if layout.length >= IN_METRES else (MILLIMETRE, "mm")
    draw = _Scaled(layout, unit)
    elements = [*draw.shaft(), *draw.disks(), *draw.bearings(), *draw.marks_above(), *draw.dimensions()]
    low, high = draw.reach(layout)
    x = Axis(f"position along the shaft ({name})", low=-0.06 * layout.length / unit, high=1.06 * layout.length / unit)
    radius = layout.largest_radius / unit
    y = Axis(
        f"radius ({name})",
        low=low / unit,
        high=high / unit,
        ticks={float(at): f"{abs(at):.4g}" for at in (-radius, 0.0, radius)},
    )
    return one_panel(
        elements, x, y, title, "Shaft sections, disks, bearings, unbalance planes and probes, with lengths between them.",
        height=_height(layout) - 0.9, width=WIDTH, is_to_scale=True,
    )  # fmt: skip


def _height(layout: RotorLayout) -> float:
    low, high = _Scaled.reach(layout)
    return float(np.clip(WIDTH * 0.9 * (high - low) / (1.12 * layout.length) + 0.9, 2.8, 9.0))


class _Scaled:
    """A drawing in the unit of its axes. Lengths of symbols follow that of the shaft."""

    def __init__(self, layout: RotorLayout, unit: float) -> None:
        self.layout, self.unit = layout, unit
        self.length = layout.length

    @staticmethod
    def reach(layout: RotorLayout) -> tuple[float, float]:
        """From below the dimensions to above the marks, m."""
        radius = layout.largest_radius
        rows = max((first + len(mark.lines) for mark, first in _stacked(_marks(layout), layout.length)), default=0)
        above = radius + (1.6 + rows) * ROW * layout.length
        below = max(radius, 0.1 * layout.length) + max(_drops(layout), default=0.0)
        return -below - 3.4 * ROW * layout.length, above

    def shaft(self) -> Iterator[Element]:
        for each in self.layout.sections:
            for low, high in ((each.inner_radius, each.outer_radius), (-each.outer_radius, -each.inner_radius)):
                if each.inner_radius == 0 and low < 0:
                    continue  # one rectangle is the whole of a solid section
                base = -each.outer_radius if each.inner_radius == 0 else low
                yield self._box(each.start, base, each.end - each.start, high - base, PALE_STEEL)
        overhang = 0.03 * self.length / self.unit
        ends = (-overhang, self.length / self.unit + overhang)
        yield Line(ends, (0, 0), "dashdot", 0.7, colour=REFERENCE)

    def disks(self) -> Iterator[Element]:
        drops = _drops(self.layout)
        for number, (disk, drop) in enumerate(zip(self.layout.disks, drops), start=1):
            width, top = max(disk.thickness, THINNEST * self.length), _top(disk, self.layout)
            if disk.outer_radius is None:
                yield Points([disk.position / self.unit], [0], size=9, colour=STEEL)
            else:
                height = disk.outer_radius - disk.bore_radius
                for base in (disk.bore_radius, -disk.outer_radius):
                    yield self._box(disk.position - width / 2, base, width, height, STEEL)
            below = -top - 0.012 * self.length - drop
            yield self._text(disk.position, below, f"disk {number}\n{disk.mass:.3g} kg", INK, "top")

    def bearings(self) -> Iterator[Element]:
        size = 0.035 * self.length
        for number, bearing in enumerate(self.layout.bearings, start=1):
            radius = self.layout.shaft_radius(bearing.position)
            for sign in (1, -1):
                corners = [(0, sign * radius), (-size / 2, sign * (radius + size)), (size / 2, sign * (radius + size))]
                points = [((bearing.position + x) / self.unit, y / self.unit) for x, y in corners]
                xs, ys = zip(*points)
                yield Area(xs, ys, colour=GROUND)
                if self.layout.support:
                    base = sign * (radius + size) - (sign < 0) * 0.35 * size
                    yield self._box(bearing.position - 0.7 * size, base, 1.4 * size, 0.35 * size, EARTH)
            below = -radius - (1.45 if self.layout.support else 1.0) * size
            yield self._text(bearing.position, below - 0.012 * self.length, f"bearing {number}", REFERENCE, "top")

    def marks_above(self) -> Iterator[Element]:
        """Unbalance, probes and effects: a line to each place, and its words where those of no other place are."""
        foot = self.layout.largest_radius + 0.9 * ROW * self.length
        for mark, first in _stacked(_marks(self.layout), self.length):
            level, start = foot + first * ROW * self.length, self.layout.shaft_radius(mark.place)
            colour = mark.lines[0][1]
            line = ((mark.place / self.unit,) * 2, (start / self.unit, level / self.unit))
            yield Line(*line, width=0.9, colour=colour)
            yield Points([mark.place / self.unit], [start / self.unit], "triangle down", colour=colour)
            side: Side = (
                "left" if mark.place < 0.1 * self.length else "right" if mark.place > 0.9 * self.length else "center"
            )
            for row, (words, own) in enumerate(mark.lines):
                yield self._text(mark.place, level + row * ROW * self.length, words, own, "bottom", side)

    def dimensions(self) -> Iterator[Element]:
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
            at, ends = level / self.unit, (left / self.unit, right / self.unit)
            yield Line(ends, (at, at), width=0.8, colour=REFERENCE)
            yield from (
                Points([end], [at], f"triangle {way}", 3.5, colour=REFERENCE)
                for end, way in zip(ends, ("left", "right"))
            )
            drop = next(previous_row) if short else 0.0
            length = f"{(right - left) / self.unit:.5g}"
            yield self._text((left + right) / 2, level - 0.006 * self.length - drop, length, REFERENCE, "top")
        for place in places:
            tick = (level - 0.01 * self.length) / self.unit, (level + 0.02 * self.length) / self.unit
            yield Line((place / self.unit,) * 2, tick, width=0.6, colour=REFERENCE)

    def _box(self, left: float, bottom: float, width: float, height: float, colour: str) -> Area:
        x, y = ((start / self.unit, (start + size) / self.unit) for start, size in ((left, width), (bottom, height)))
        return Area((x[0], x[1], x[1], x[0]), (y[0], y[0], y[1], y[1]), colour=colour)

    def _text(self, x: float, y: float, text: str, colour: str, edge: Edge, side: Side = "center") -> Words:
        return Words(x=x / self.unit, y=y / self.unit, text=text, colour=colour, edge=edge, side=side)


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
            lines[place].append((effect.name, MODEL))
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
