"""Colours by what they mean, alike in pictures and on pages.

Each is seen on a white and on a dark ground (3 : 1 or more, WCAG 2.2 for graphics; tests/bench/test_pages.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle, islice, product

CATEGORIES = tuple(f"category {number}" for number in range(1, 8))  # what has no other meaning, one after the other
INK = "ink"  # what is measured or printed, where nothing else has a colour
MODEL, MEASURED, INTERVAL, PAPER, REFERENCE, CONTEXT, ALIKE = (
    "model", "measured", "interval", "paper", "reference", "context", "alike",
)  # fmt: skip
BEFORE, AFTER = PAPER, MODEL  # a model that is given up, and the one in its place
STEEL, PALE_STEEL, EARTH, GROUND = "steel", "pale steel", "earth", "ground"  # areas

BLUE, ORANGE, GREEN, PURPLE, OCHRE, GREY, PINK, TEAL = (
    "#2b7ab8", "#d1581f", "#3a8f4d", "#9a68ba", "#a88300", "#7a7a7a", "#cf5f9d", "#17889a",
)  # fmt: skip
PALETTE = {
    MODEL: BLUE, MEASURED: GREY, PAPER: ORANGE, INTERVAL: GREEN, REFERENCE: GREY, CONTEXT: GREY, ALIKE: TEAL, INK: GREY,
    STEEL: "#7f97ab", PALE_STEEL: "#c9d3dc", EARTH: "#e6dcc8", GROUND: "#ffffff",
    **dict(zip(CATEGORIES, (BLUE, ORANGE, GREEN, PURPLE, OCHRE, PINK, TEAL))),
}  # fmt: skip
ON_PAPER = PALETTE | {INK: "#222222", MEASURED: "#222222", REFERENCE: "#444444"}  # a white ground alone
DASHES = ("solid", "dash", "dot", "dashdot")
SYMBOLS = ("circle", "square", "diamond", "triangle down", "triangle up", "cross", "star")


def category(number: int) -> str:
    """The colour of the category of this number, from 0; behind the last one they come again."""
    return CATEGORIES[number % len(CATEGORIES)]


def symbol(number: int) -> str:
    """The symbol of the category of this number, from 0."""
    return SYMBOLS[number % len(SYMBOLS)]


def styles(names: Sequence[str]) -> Mapping[str, tuple[str, str]]:
    """A colour and a dash for each name; where colours come again the dash is another.

    >>> styles(["one", "two"])
    {'one': ('category 1', 'solid'), 'two': ('category 2', 'solid')}
    """
    every = ((colour, dash) for dash, colour in cycle(product(DASHES, CATEGORIES)))
    return dict(zip(names, islice(every, len(names))))
