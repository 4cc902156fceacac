"""Colours by what they mean, alike in pictures and on pages.

Each role has a colour on a white ground and one on a dark ground; lines and symbols have 3 : 1 or more there (WCAG 2.2 for graphics). A page is written
with the first, and shows the second where the reader's system is dark. Model, paper, interval and ink differ by
ΔE 2000 ≥ 12 for normal, protan and deutan vision; all others also by their symbol or dash.
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

BOTH = {  # each role on a white and on a dark ground; hues and ink have 4.5 : 1 or more there
    MODEL: ("#0b62a8", "#5aaef0"), PAPER: ("#c44a10", "#ff8b52"), INTERVAL: ("#007a5c", "#33c79e"),
    ALIKE: ("#007a5c", "#33c79e"), INK: ("#1a1d21", "#e6e8ea"), MEASURED: ("#1a1d21", "#e6e8ea"),
    REFERENCE: ("#555d66", "#a8b0b8"), CONTEXT: ("#8a949e", "#77828d"),
    STEEL: ("#7f97ab", "#7189a0"), PALE_STEEL: ("#c9d3dc", "#3f4c58"), EARTH: ("#e6dcc8", "#4d4636"),
    GROUND: ("#ffffff", "#14181c"),
    **dict(zip(CATEGORIES, (
        ("#0b62a8", "#5aaef0"), ("#c44a10", "#ff8b52"), ("#007a5c", "#33c79e"), ("#9c4488", "#e59acb"),
        ("#8c1d1d", "#e8d94c"), ("#5b2a86", "#a58ad0"), ("#2f6f73", "#3fa7a0"),
    ))),
}  # fmt: skip
LIGHT = {role: on_white for role, (on_white, _) in BOTH.items()}  # pictures, printed and saved figures
DARK = {role: on_dark for role, (_, on_dark) in BOTH.items()}
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
