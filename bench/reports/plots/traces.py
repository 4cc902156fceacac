"""Traces and layouts of plots for plotly, alike on all pages; an axis that is linear about 0 and logarithmic beyond."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import cycle, islice
from typing import Any

import numpy as np
from matplotlib.scale import SymmetricalLogTransform

from ksmea.arrays import Array
from ksmea.show.charts.ticks import MOST_POWERS, symlog_ticks

# Each is seen on a white and on a dark ground (3 : 1 or more, WCAG 2.2 for graphics; tests/bench/test_pages.py).
BLUE, ORANGE, GREEN, PURPLE, OCHRE, GREY, _, TEAL = COLOURS = (
    "#2b7ab8", "#d1581f", "#3a8f4d", "#9a68ba", "#a88300", "#7a7a7a", "#cf5f9d", "#17889a",
)  # fmt: skip
LONG_NAME = 16  # characters, from which on the name of a row is broken
PLAIN_EXPONENT = 6  # numbers up to 10 to this power are written out on axes
STANDOFF = 6  # px between the numbers of an axis and its title
LOG_TICKS = 5  # of a logarithmic axis at most: over 1.5 decades and more they stand at 1, 2 and 5 or at powers
FADED = "rgba(122,122,122,0.14)"
PALE = "rgba(122,122,122,0.45)"  # of a wide line below others
DASHES = ("solid", "dash", "dot", "dashdot")

Trace = dict[str, Any]
Layout = dict[str, Any]


def layout(x: str = "", y: str = "", *, x_log: bool = False, y_log: bool = False, **more: Any) -> Layout:
    """The layout of a plot with one pair of axes; `more` goes over it."""
    return {
        "margin": {"l": 62, "r": 12, "t": 12, "b": 50},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"size": 12, "family": "system-ui, sans-serif"},
        "separators": ".",  # thousands have none, as in texts and tables
        "hoverlabel": {"bgcolor": "#1f252b", "bordercolor": "#1f252b", "font": {"color": "#ffffff"}, "namelength": -1},
        "legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0, "xanchor": "left"},
        "narrow": {"margin": {"l": 50, "r": 6, "t": 12, "b": 48}},
        "xaxis": axis(x, log=x_log),
        "yaxis": axis(y, log=y_log),
        **more,
    }


def axis(title: str = "", *, log: bool = False, **more: Any) -> Layout:
    """One axis; its numbers take the room that they need."""
    scale = {"type": "log", "tickformat": "~g", "nticks": LOG_TICKS} if log else {"minexponent": PLAIN_EXPONENT}
    return {
        "title": {"text": title, "standoff": STANDOFF},
        "automargin": True,
        "zeroline": False,
        "ticks": "outside",
        **scale,
        **more,
    }


def folded(name: str) -> str:
    """The name of a row at the left of a plot, broken after a comma so that a narrow page keeps room for what is drawn.

    >>> folded("complex, noise_known False, floor 0.1"), folded("rational, samples 13")
    ('complex,<br>noise_known False,<br>floor 0.1', 'rational,<br>samples 13')
    """
    return name.replace(", ", ",<br>") if len(name) > LONG_NAME else name


def line(x: Any, y: Any, name: str, colour: str = BLUE, **more: Any) -> Trace:
    return {
        "type": "scatter", "mode": "lines", "x": x, "y": y, "name": name, "line": {"color": colour, "width": 2}, **more,
    }  # fmt: skip


def points(x: Any, y: Any, name: str, colour: str = ORANGE, **more: Any) -> Trace:
    marker = {"color": colour, "size": 6} | more.pop("marker", {})
    return {"type": "scatter", "mode": "markers", "x": x, "y": y, "name": name, "marker": marker, **more}


def band(x: Array, low: Array, high: Array, name: str, colour: str = BLUE, **more: Any) -> list[Trace]:
    """What lies between two lines; where one is not a number there is nothing."""
    common = {"type": "scatter", "mode": "lines", "x": x, "line": {"width": 0}, "hoverinfo": "skip"} | more
    above = {**common, "y": high, "showlegend": False, "name": name, "legendgroup": name}
    below = {**common, "y": low, "fill": "tonexty", "fillcolor": faded(colour), "name": name, "legendgroup": name}
    return [above, {"showlegend": True, **below}]


def faded(colour: str, part: float = 0.22) -> str:
    """A colour that what is behind it shows through.

    >>> faded("#2b7ab8")
    'rgba(43,122,184,0.22)'
    """
    red, green, blue = (int(colour[at : at + 2], 16) for at in (1, 3, 5))
    return f"rgba({red},{green},{blue},{part:g})"


def level(at: float, *, along: str = "y", dash: str = "dot", **more: Any) -> Layout:
    """A straight line through a whole panel at a value of an axis."""
    ends = {"y0": at, "y1": at, "x0": 0, "x1": 1, "xref": "x domain", "yref": "y"}
    if along == "x":
        ends = {"x0": at, "x1": at, "y0": 0, "y1": 1, "xref": "x", "yref": "y domain"}
    return {"type": "line", "line": {"color": GREY, "width": 1.2, "dash": dash}, **ends, **more}


def styles(names: Sequence[str]) -> Mapping[str, tuple[str, str]]:
    """A colour and a dash for each name; where colours come again the dash is another."""
    every = ((colour, dash) for dash in cycle(DASHES) for colour in COLOURS)
    return dict(zip(names, islice(every, len(names))))


def broken(x: Array, breaks: Sequence[int]) -> Array:
    """Values (n,) to be drawn as a line for each run."""
    return np.insert(np.asarray(x, dtype=float), list(breaks), np.nan)


@dataclass(frozen=True)
class SymlogAxis:
    """Positions of values on an axis that is linear up to `linear` to both sides."""

    linear: float

    def positions(self, values: Array | list[float]) -> Array:
        """Where values (n,) stand."""
        found: Array = self._transform(np.asarray(values, dtype=float))
        return found

    def ticks(self, low: float, high: float, most: int = MOST_POWERS) -> Layout:
        """What an axis shows between two values: plain numbers at 0 and, to each side, at `most` powers of ten."""
        at = symlog_ticks(low, high, self.linear, most)
        return {"tickvals": self.positions(at), "ticktext": [f"{each:.12g}".replace("-", "−") for each in at]}

    @cached_property
    def _transform(self) -> Callable[[Array], Array]:
        transform: Callable[[Array], Array] = SymmetricalLogTransform(
            base=10, linthresh=self.linear, linscale=1
        ).transform
        return transform
