"""Words of a rotor's drawing, in rows clear of each other down to pages of 360 px.

Lengths are parts of the shaft's, so that one placement serves each width of a page and the picture. All are chosen for
the narrowest page, whose 12 px letters take the largest part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal

Side = Literal["left", "center", "right"]
CHARACTER = 0.028  # of the length: the mean width of a letter where 1.12 lengths are 290 px wide
ROW = 0.066  # of the length: a line of text there
GAP = 0.02  # of the length, between words side by side
OVERHANG = 0.06  # of the length: as far as the drawing goes beyond an end of the shaft
BEYOND = 0.035  # of the length: as far as words go beyond that, short of the numbers of the axis
SIDES: tuple[Side, ...] = ("center", "left", "right")
PART = {"center": 0.5, "left": 0.0, "right": 1.0}  # of the words' width that lies left of their place


@dataclass(frozen=True)
class Label:
    """Lines of words at a place along the shaft (m), at least `start` (m) away from its axis."""

    place: float
    lines: tuple[str, ...]
    start: float
    has_leader: bool = False  # a line joins it with the shaft


@dataclass(frozen=True)
class Box:
    """A rectangle that words keep clear of: along the shaft, and away from its axis (m)."""

    left: float
    right: float
    inner: float
    outer: float

    def overlaps(self, other: Box) -> bool:
        along = self.left < other.right and other.left < self.right
        return along and self.inner < other.outer and other.inner < self.outer


@dataclass(frozen=True)
class Placed:
    """Label with the distance (m) of its first line from the axis.

    `side` of its words is at the place.
    """

    label: Label
    inner: float
    side: Side
    box: Box


def placed(labels: Sequence[Label], length: float, bodies: Sequence[Box] = ()) -> list[Placed]:
    """Labels as near to the axis as they are clear of bodies, earlier labels and their leaders."""
    found: list[Placed] = []
    for label in labels:
        taken = [*bodies, *(each.box for each in found)]
        leaders = [_leader(each, length) for each in found if each.label.has_leader]
        levels = sorted({label.start, *(box.outer for box in taken if box.outer > label.start)})
        tried = [_at(label, level, side, length) for level, side in product(levels, SIDES)]
        inside = [each for each in tried if _is_inside(each.box, length)] or tried
        clear = [each for each in inside if not any(each.box.overlaps(box) for box in (*taken, *leaders))]
        clear = clear or inside[-1:]  # beyond all others, across the leader of one
        words = [each.box for each in found]
        uncrossed = [each for each in clear if not any(_leader(each, length).overlaps(box) for box in words)]
        found.append(uncrossed[0] if uncrossed and label.has_leader else clear[0])
    return found


def width_of(words: str, length: float) -> float:
    """Width of a line of text on the narrowest page, m."""
    return CHARACTER * length * len(words)


def _at(label: Label, level: float, side: Side, length: float) -> Placed:
    width = max(width_of(line, length) for line in label.lines)
    left = label.place - PART[side] * width
    gap = GAP * length / 2
    outer = level + ROW * length * len(label.lines)
    return Placed(label, level, side, Box(left - gap, left + width + gap, level, outer))


def _is_inside(box: Box, length: float) -> bool:
    over = (OVERHANG + BEYOND) * length
    return box.left >= -over and box.right <= length + over


def _leader(each: Placed, length: float) -> Box:
    """The line from the shaft to the words, which may touch their side."""
    thin = 1e-3 * length
    return Box(each.label.place - thin, each.label.place + thin, 0.0, each.inner)
