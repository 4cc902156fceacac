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
from ksmea.rotordynamics.layout import BearingPlace, DiskOutline, RotorLayout, ShaftSection
from ksmea.show.charts.chart import Area, Axis, Chart, Element, Line, Points, Words, one_panel
from ksmea.show.charts.colours import (
    ALIKE,
    EARTH,
    GROUND,
    INK,
    INTERVAL,
    MODEL,
    PALE_STEEL,
    PAPER,
    REFERENCE,
    STEEL,
    category,
)
from ksmea.units import GRAM_MILLIMETRE, MICROMETRE, MILLIMETRE

Side = Literal["left", "center", "right"]
Edge = Literal["top", "bottom"]
WIDTH = 8.0  # inches
IN_METRES = 3.0  # m, from which length on the axis is in m
THINNEST = 0.008  # of the length: a thinner disk is drawn as wide as this
ROW = 0.055  # of the length, between rows of text
WORDS = 0.085  # of the length, as wide as those of a disk
SAG = 0.04  # of the length: the largest sag as it is drawn
MANY = 8  # disks, bearings and seals: more are numbered in rows of their own
NUMBER, FIRST = 0.05, 0.075  # of the length, as wide as a number there and as the first with its name
SEAL, COUPLING, LUMPED = category(3), category(4), category(5)
NEAR = 0.24  # of the length: words of places closer than this stand in different rows


def rotor_chart(layout: RotorLayout, title: str = "") -> Chart:
    """The rotor in one plane, both axes of one scale; its axis is in mm, of long rotors in m."""
    unit, name = (1.0, "m") if layout.length >= IN_METRES else (MILLIMETRE, "mm")
    draw = _Scaled(layout, unit)
    on_shaft = (*draw.shaft(), *draw.disks(), *draw.bearings(), *draw.seals(), *draw.masses_and_couplings())
    elements = [*on_shaft, *draw.sag(), *draw.numbers(), *draw.marks_above(), *draw.dimensions()]
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
    """A drawing in the unit of its axes. Lengths of symbols are in proportion to the length of the shaft."""

    def __init__(self, layout: RotorLayout, unit: float) -> None:
        self.layout, self.unit = layout, unit
        self.length, self.is_crowded = layout.length, _is_crowded(layout)

    @staticmethod
    def reach(layout: RotorLayout) -> tuple[float, float]:
        """From below the dimensions to above the marks, m."""
        radius = layout.largest_radius
        rows = max((first + len(mark.lines) for mark, first in _stacked(_marks(layout), layout.length)), default=0)
        above = radius + (1.6 + rows) * ROW * layout.length
        lower = (
            len(_numbered(layout)) * ROW * layout.length if _is_crowded(layout) else max(_drops(layout), default=0.0)
        )
        below = max(radius, 0.1 * layout.length) + lower
        return -below - 3.7 * ROW * layout.length, above

    def shaft(self) -> Iterator[Element]:
        for each in self.layout.sections:
            yield from self._ring(each, COUPLING if each.kind == "coupling" else PALE_STEEL)
        for each in self.layout.layers:
            yield from self._ring(each, ALIKE)
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
            if not self.is_crowded:
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
                if self._has_base(bearing):
                    base = sign * (radius + size) - (sign < 0) * 0.35 * size
                    name = "pedestal" if bearing.has_pedestal else ""
                    yield self._box(bearing.position - 0.7 * size, base, 1.4 * size, 0.35 * size, EARTH, name)
            below = -radius - (1.45 if self._has_base(bearing) else 1.0) * size
            if not self.is_crowded:
                yield self._text(bearing.position, below - 0.012 * self.length, f"bearing {number}", REFERENCE, "top")

    def _has_base(self, bearing: BearingPlace) -> bool:
        return bool(self.layout.support) or bearing.has_pedestal

    def seals(self) -> Iterator[Element]:
        for number, seal in enumerate(self.layout.seals, start=1):
            radius = self.layout.shaft_radius(seal.position) + 0.012 * self.length
            places = [seal.position / self.unit] * 2
            yield Points(places, [radius / self.unit, -radius / self.unit], "diamond", 4.0, colour=SEAL, name="seal")
            if not self.is_crowded:
                yield self._text(seal.position, -radius - 0.02 * self.length, f"seal {number}", REFERENCE, "top")

    def masses_and_couplings(self) -> Iterator[Element]:
        for each in self.layout.masses:
            yield Points([each.position / self.unit], [0], "square", 7.0, colour=LUMPED, name="lumped mass")
        for place in self.layout.couplings:
            reach = 1.3 * self.layout.shaft_radius(place) / self.unit
            yield Line((place / self.unit,) * 2, (-reach, reach), "dash", 1.5, colour=COUPLING, name="coupling")

    def sag(self) -> Iterator[Element]:
        """The axis as it hangs under the weight, far larger than to scale."""
        sag, places = self.layout.sag, self.layout.node_positions
        if sag is None or not np.max(np.abs(sag)) > 0:
            return
        largest = float(np.max(np.abs(sag)))
        drawn = -sag * SAG * self.length / largest / self.unit
        name = f"static sag, largest {largest / MICROMETRE:.3g} µm"
        yield Line(places / self.unit, drawn, width=1.2, colour=MODEL, name=name)

    def numbers(self) -> Iterator[Element]:
        """Numbers of disks, bearings and seals in a row each, below a crowded rotor.

        Numbers without room are left out.
        """
        if not self.is_crowded:
            return
        level = -max(self.layout.largest_radius, 0.1 * self.length) - 0.3 * ROW * self.length
        for row, (name, places) in enumerate(_numbered(self.layout).items()):
            at, free = level - row * ROW * self.length, -math.inf  # from where on there is room
            for number, place in enumerate(places, start=1):
                if place >= free:
                    free = place + (FIRST if number == 1 else NUMBER) * self.length
                    yield self._text(place, at, f"{name} {number}" if number == 1 else str(number), INK, "top")

    def marks_above(self) -> Iterator[Element]:
        """Unbalance, probes and effects: a line to each place, and words clear of the words of other places."""
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
        if self.is_crowded:
            stops = {0.0, layout.length, *_apart(sorted(each.position for each in layout.bearings), ROW * self.length)}
        places = _apart(sorted(stops), 1e-6 * self.length)
        level = self.reach(layout)[0] + 1.2 * ROW * self.length
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

    def _ring(self, each: ShaftSection, colour: str) -> Iterator[Element]:
        """The upper and lower half of a cylinder or cone; one area is the whole of a solid one."""
        left, right = (each.outer_radius, each.inner_radius), (each.outer_radius_right, each.inner_radius_right)
        ends = [own if other is None else other for own, other in zip(left, right)]
        x = tuple(place / self.unit for place in (each.start, each.end, each.end, each.start))
        name = {"shaft": "", "layer": "layer", "coupling": "coupling in line"}[each.kind]
        is_solid = left[1] == 0 and ends[1] == 0
        for sign in (1,) if is_solid else (1, -1):
            inner = (-left[0], -ends[0]) if is_solid else (sign * left[1], sign * ends[1])
            heights = (inner[0], inner[1], sign * ends[0], sign * left[0])
            yield Area(x, tuple(height / self.unit for height in heights), colour=colour, name=name)

    def _box(self, left: float, bottom: float, width: float, height: float, colour: str, name: str = "") -> Area:
        x, y = ((start / self.unit, (start + size) / self.unit) for start, size in ((left, width), (bottom, height)))
        return Area((x[0], x[1], x[1], x[0]), (y[0], y[0], y[1], y[1]), colour=colour, name=name)

    def _text(self, x: float, y: float, text: str, colour: str, edge: Edge, side: Side = "center") -> Words:
        return Words(x=x / self.unit, y=y / self.unit, text=text, colour=colour, edge=edge, side=side)


def _numbered(layout: RotorLayout) -> dict[str, list[float]]:
    """Places (m) of what has a number, along the shaft, by the name of its kind."""
    places = {
        "disk": [disk.position for disk in layout.disks],
        "bearing": [bearing.position for bearing in layout.bearings],
        "seal": [seal.position for seal in layout.seals],
    }
    return {name: found for name, found in places.items() if found}


def _is_crowded(layout: RotorLayout) -> bool:
    return sum(map(len, _numbered(layout).values())) > MANY


def _drops(layout: RotorLayout) -> list[float]:
    """How far (m) the words of each disk are lowered: by two lines if they are next to a near disk."""
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
    """Words above one place (m), in lines with their colours."""

    place: float
    lines: tuple[tuple[str, str], ...]


def _marks(layout: RotorLayout) -> list[_Mark]:
    lines: dict[float, list[tuple[str, str]]] = defaultdict(list)
    directions: dict[tuple[float, int | None], list[str]] = defaultdict(list)
    for probe, housing in zip(layout.probes, layout.housings or (None,) * len(layout.probes)):
        of_place = directions[probe.position, housing]
        if probe.direction not in of_place:
            of_place.append(probe.direction)
    for (place, housing), found in directions.items():
        where = "" if housing is None else f" on housing {housing + 1}"
        lines[place].append((f"probe {', '.join(map(named, found))}{where}", INTERVAL))
    for plane in layout.unbalance:
        angle = f" at {math.degrees(plane.phase):.0f}°" if plane.phase else ""
        lines[plane.position].append((f"unbalance {plane.magnitude / GRAM_MILLIMETRE:.4g} g mm{angle}", PAPER))
    for effect in layout.effects:
        for place in effect.positions:
            lines[place].append((effect.name, MODEL))
    return [_Mark(place, tuple(found)) for place, found in sorted(lines.items())]


def _stacked(marks: list[_Mark], length: float) -> list[tuple[_Mark, int]]:
    """Each mark with the lowest row in which its lines keep clear of the lines of neighbouring marks."""
    placed: list[tuple[_Mark, int]] = []
    for mark in marks:
        near = [(first, first + len(each.lines)) for each, first in placed if mark.place - each.place < NEAR * length]
        free = [0, *(end for _, end in near)]
        first = min(row for row in free if all(row + len(mark.lines) <= low or row >= end for low, end in near))
        placed.append((mark, first))
    return placed


def _apart(places: list[float], least: float) -> list[float]:
    """Rising places, without places that are at most `least` behind the one before."""
    kept = places[:1]
    for place in places[1:]:
        if place - kept[-1] > least:
            kept.append(place)
    return kept
