"""How methods are drawn: a colour, a line and a marker each, by their order, best first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ksmea.show.figures.style import COLOURS, MARKERS

LINES: tuple[Literal["-", "--", ":"], ...] = ("-", "--", ":")
COLUMNS = 2  # of panels: more are too small to read on a page
MOST_IN_COLUMN = 16  # methods of a legend in a panel
N_MARKER = 5  # on a line


@dataclass(frozen=True)
class Style:
    colour: str
    line: Literal["-", "--", ":"]
    marker: str


def styles(methods: Sequence[str]) -> dict[str, Style]:
    """A style for each method; the colours of those behind the seventh are the same, with another line and marker."""
    lines = [(colour, line) for line in LINES for colour in COLOURS]
    return {method: Style(*pair, marker) for method, pair, marker in zip(methods, cycle(lines), cycle(MARKERS))}


def panels_of(groups: Sequence[str], methods: Sequence[str], height: float = 3.2) -> tuple[Figure, dict[str, Axes]]:
    """A figure with a panel for each group of instances and a legend of all methods: in the last place where it is free, else
    beside them."""
    columns = min(COLUMNS, len(groups))
    rows = math.ceil(len(groups) / columns)
    width = 3.9 if columns > 1 else 7.0
    n_free = rows * columns - len(groups)
    figure = Figure(figsize=(width * columns + (0.0 if n_free else 2.0), height * rows + 0.8), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False)
    style: dict[str, Any] = {"handles": handles(methods), "fontsize": 8, "frameon": False, "handlelength": 3.5}
    if n_free:
        free = grid.flat[-1]
        free.set_axis_off()
        free.legend(loc="center", ncols=math.ceil(len(methods) / MOST_IN_COLUMN), **style)
    else:
        figure.legend(loc="outside right upper", **style)
    return figure, dict(zip(groups, grid.flat))


def handles(methods: Sequence[str]) -> list[Line2D]:
    """Entries of a legend."""
    return [
        Line2D([], [], color=style.colour, linestyle=style.line, marker=style.marker, markersize=4, label=method)
        for method, style in styles(methods).items()
    ]


def draw_line(axes: Axes, x: np.ndarray, y: np.ndarray, style: Style, number: int) -> None:
    """A step line with a few markers, placed differently for each `number` so that they do not hide each other."""
    gap = max(len(x) // N_MARKER, 1)
    axes.step(
        x,
        y,
        where="post",
        color=style.colour,
        linestyle=style.line,
        linewidth=1.5,
        marker=style.marker,
        markersize=4,
        markevery=(3 * number % gap, gap),
    )
