"""A rotor to scale: shaft, disks, bearings, unbalance and probes over the length of the shaft."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
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
from ksmea.show.charts.parts.rotor_words import GAP, OVERHANG, ROW, Box, Label, Placed, Side, placed, width_of
from ksmea.units import GRAM_MILLIMETRE, MICROMETRE, MILLIMETRE

Edge = Literal["top", "bottom"]
WIDTH = 8.0  # inches
IN_METRES = 3.0  # m, from which length on the axis is in m
THINNEST = 0.008  # of the length: a thinner disk is drawn as wide as this
SAG = 0.04  # of the length: the largest sag as it is drawn
MANY = 8  # disks, bearings and seals: more are numbered in rows of their own
SEAL, COUPLING, LUMPED = category(3), category(4), category(5)
SIZE = 0.035  # of the length: a bearing


def rotor_chart(layout: RotorLayout, title: str = "") -> Chart:
    """The rotor in one plane, both axes of one scale; its axis is in mm, of long rotors in m."""
    unit, name = (1.0, "m") if layout.length >= IN_METRES else (MILLIMETRE, "mm")
    draw = _Scaled(layout, unit)
    on_shaft = (*draw.shaft(), *draw.disks(), *draw.bearings(), *draw.seals(), *draw.masses_and_couplings())
    elements = [*on_shaft, *draw.sag(), *draw.words_below(), *draw.numbers(), *draw.marks_above(), *draw.dimensions()]
    low, high = draw.reach()
    ends = (-OVERHANG * layout.length / unit, (1 + OVERHANG) * layout.length / unit)
    x = Axis(f"position along the shaft ({name})", low=ends[0], high=ends[1])
    radius = layout.largest_radius / unit
    y = Axis(
        f"radius ({name})",
        low=low / unit,
        high=high / unit,
        ticks={float(at): f"{abs(at):.4g}" for at in (-radius, 0.0, radius)},
    )
    return one_panel(
        elements, x, y, title, "Shaft sections, disks, bearings, unbalance planes and probes, with lengths between them.",
        height=_height(layout, low, high), width=WIDTH, is_to_scale=True,
    )  # fmt: skip


def _height(layout: RotorLayout, low: float, high: float) -> float:
    return float(np.clip(WIDTH * 0.9 * (high - low) / ((1 + 2 * OVERHANG) * layout.length), 1.9, 8.1))


class _Scaled:
    """A drawing in the unit of its axes. Lengths of symbols are in proportion to the length of the shaft."""

    def __init__(self, layout: RotorLayout, unit: float) -> None:
        self.layout, self.unit = layout, unit
        self.length, self.is_crowded = layout.length, _is_crowded(layout)
        row, radius = ROW * self.length, layout.largest_radius
        self.above = placed(
            [Label(each.place, each.words, radius + 0.9 * row, has_leader=True) for each in _marks(layout)], self.length
        )
        self.below = [] if self.is_crowded else placed(_below(layout), self.length, _bodies(layout))
        lowest = max((each.box.outer for each in self.below), default=0.0)
        if self.is_crowded:
            lowest = self._first_number() + len(_numbered(layout)) * row
        self.level = -max(radius, lowest) - 0.4 * row  # of the dimensions
        self.lengths = placed([*self._lengths()], self.length)

    def reach(self) -> tuple[float, float]:
        """From below the dimensions to above the marks, m."""
        rows = [each.box.outer for each in self.above]
        return (
            -max((each.box.outer for each in self.lengths), default=-self.level),
            max(rows, default=self.layout.largest_radius) + 0.4 * ROW * self.length,
        )

    def _first_number(self) -> float:
        return max(self.layout.largest_radius, 0.1 * self.length) + 0.3 * ROW * self.length

    def shaft(self) -> Iterator[Element]:
        for each in self.layout.sections:
            yield from self._ring(each, COUPLING if each.kind == "coupling" else PALE_STEEL)
        for each in self.layout.layers:
            yield from self._ring(each, ALIKE)
        overhang = 0.03 * self.length / self.unit
        ends = (-overhang, self.length / self.unit + overhang)
        yield Line(ends, (0, 0), "dashdot", 0.7, colour=REFERENCE)

    def disks(self) -> Iterator[Element]:
        for disk in self.layout.disks:
            width = max(disk.thickness, THINNEST * self.length)
            if disk.outer_radius is None:
                yield Points([disk.position / self.unit], [0], size=9, colour=STEEL)
            else:
                height = disk.outer_radius - disk.bore_radius
                for base in (disk.bore_radius, -disk.outer_radius):
                    yield self._box(disk.position - width / 2, base, width, height, STEEL)

    def bearings(self) -> Iterator[Element]:
        size = SIZE * self.length
        for bearing in self.layout.bearings:
            radius = self.layout.shaft_radius(bearing.position)
            for sign in (1, -1):
                corners = [(0, sign * radius), (-size / 2, sign * (radius + size)), (size / 2, sign * (radius + size))]
                points = [((bearing.position + x) / self.unit, y / self.unit) for x, y in corners]
                xs, ys = zip(*points)
                yield Area(xs, ys, colour=GROUND)
                if _has_base(self.layout, bearing):
                    base = sign * (radius + size) - (sign < 0) * 0.35 * size
                    name = "pedestal" if bearing.has_pedestal else ""
                    yield self._box(bearing.position - 0.7 * size, base, 1.4 * size, 0.35 * size, EARTH, name)

    def seals(self) -> Iterator[Element]:
        for seal in self.layout.seals:
            radius = self.layout.shaft_radius(seal.position) + 0.012 * self.length
            places = [seal.position / self.unit] * 2
            yield Points(places, [radius / self.unit, -radius / self.unit], "diamond", 4.0, colour=SEAL, name="seal")

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

    def words_below(self) -> Iterator[Element]:
        """Names of disks with their masses, of bearings and seals."""
        for each in self.below:
            colour = INK if each.label.lines[0].startswith("disk") else REFERENCE
            yield self._words(each, colour)

    def numbers(self) -> Iterator[Element]:
        """Numbers of disks, bearings and seals in a row each, below a crowded rotor.

        Numbers without room are left out.
        """
        if not self.is_crowded:
            return
        for row, (name, places) in enumerate(_numbered(self.layout).items()):
            at, free = -self._first_number() - row * ROW * self.length, -math.inf  # from where on there is room
            for number, place in enumerate(places, start=1):
                words = f"{name} {number}" if number == 1 else str(number)
                half = (width_of(words, self.length) + GAP * self.length) / 2
                if place - half >= free:
                    free = place + half
                    yield self._text(place, at, words, INK, "top")

    def marks_above(self) -> Iterator[Element]:
        """Unbalance, probes and effects: a line to each place, and words clear of the words of other places."""
        for mark, at in zip(_marks(self.layout), self.above):
            level, start = at.inner, self.layout.shaft_radius(mark.place)
            colour = mark.lines[0][1]
            line = ((mark.place / self.unit,) * 2, (start / self.unit, level / self.unit))
            yield Line(*line, width=0.9, colour=colour)
            yield Points([mark.place / self.unit], [start / self.unit], "triangle down", colour=colour)
            for row, (words, own) in enumerate(mark.lines):
                yield self._text(mark.place, level + row * ROW * self.length, words, own, "bottom", at.side)

    def dimensions(self) -> Iterator[Element]:
        """Lengths between all places where something sits or a section ends, below the rotor."""
        places, at = self._stops(), self.level / self.unit
        for left, right in pairwise(places):
            ends = (left / self.unit, right / self.unit)
            yield Line(ends, (at, at), width=0.8, colour=REFERENCE)
            yield from (
                Points([end], [at], f"triangle {way}", 3.5, colour=REFERENCE)
                for end, way in zip(ends, ("left", "right"))
            )
        yield from (self._words(each, REFERENCE) for each in self.lengths)
        for place in places:
            tick = (self.level - 0.01 * self.length) / self.unit, (self.level + 0.02 * self.length) / self.unit
            yield Line((place / self.unit,) * 2, tick, width=0.6, colour=REFERENCE)

    def _stops(self) -> list[float]:
        """Places (m) between which lengths are given."""
        layout = self.layout
        bearings = sorted(each.position for each in layout.bearings)
        disks = [] if self.is_crowded else [disk.position for disk in layout.disks]
        bearings = _apart(bearings, ROW * self.length) if self.is_crowded else bearings
        return _apart(sorted({0.0, layout.length, *disks, *bearings}), 1e-6 * self.length)

    def _lengths(self) -> Iterator[Label]:
        for left, right in pairwise(self._stops()):
            start = -self.level + 0.006 * self.length
            yield Label((left + right) / 2, (f"{(right - left) / self.unit:.5g}",), start)

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

    def _words(self, each: Placed, colour: str) -> Words:
        """Words below the shaft, all lines as one text."""
        return self._text(each.label.place, -each.inner, "\n".join(each.label.lines), colour, "top", each.side)

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


def _below(layout: RotorLayout) -> list[Label]:
    """Names of what sits on the shaft, along it, each below what it names."""
    apart = 0.012 * layout.length
    disks = [
        Label(disk.position, (f"disk {number}", f"{disk.mass:.3g} kg"), _top(disk, layout) + apart)
        for number, disk in enumerate(layout.disks, start=1)
    ]
    bearings = [
        Label(each.position, (f"bearing {number}",), _bottom(each, layout) + apart)
        for number, each in enumerate(layout.bearings, start=1)
    ]
    seals = [
        Label(each.position, (f"seal {number}",), layout.shaft_radius(each.position) + 2 * apart)
        for number, each in enumerate(layout.seals, start=1)
    ]
    return sorted([*disks, *bearings, *seals], key=lambda label: label.place)


def _bodies(layout: RotorLayout) -> list[Box]:
    """Disks and bearings as drawn, which no words lie on."""
    found = []
    for disk in layout.disks:
        half = max(disk.thickness, THINNEST * layout.length) / 2
        found.append(Box(disk.position - half, disk.position + half, 0.0, _top(disk, layout)))
    for each in layout.bearings:
        half = 0.7 * SIZE * layout.length
        found.append(Box(each.position - half, each.position + half, 0.0, _bottom(each, layout)))
    return found


def _bottom(bearing: BearingPlace, layout: RotorLayout) -> float:
    """The lower end of a bearing with its base, m from the axis."""
    return layout.shaft_radius(bearing.position) + (1.45 if _has_base(layout, bearing) else 1.0) * SIZE * layout.length


def _has_base(layout: RotorLayout, bearing: BearingPlace) -> bool:
    return bool(layout.support) or bearing.has_pedestal


def _top(disk: DiskOutline, layout: RotorLayout) -> float:
    """Half the height of a disk as it is drawn, m."""
    return disk.outer_radius if disk.outer_radius is not None else 2 * layout.shaft_radius(disk.position)


@dataclass(frozen=True)
class _Mark:
    """Words above one place (m), in lines with their colours."""

    place: float
    lines: tuple[tuple[str, str], ...]

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(words for words, _ in self.lines)


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


def _apart(places: list[float], least: float) -> list[float]:
    """Rising places, without places that are at most `least` behind the one before."""
    kept = places[:1]
    for place in places[1:]:
        if place - kept[-1] > least:
            kept.append(place)
    return kept
