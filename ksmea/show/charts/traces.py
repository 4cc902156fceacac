"""Elements of a panel as what plotly.js draws: traces, shapes and annotations of its axes."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ksmea.arrays import Array
from ksmea.show.charts import chart as of
from ksmea.show.charts.chart import Axis, Element, Panel, Values
from ksmea.show.charts.colours import LIGHT
from ksmea.show.charts.ticks import symlog_positions

Trace = dict[str, Any]
Layout = dict[str, Any]

SYMBOLS = {
    "circle": "circle", "square": "square", "diamond": "diamond", "triangle down": "triangle-down", "triangle up": "triangle-up",
    "triangle left": "triangle-left",
    "triangle right": "triangle-right",
    "cross": "cross", "star": "star", "x": "x-thin", "plus": "cross-thin", "bar": "line-ew", "post": "line-ns", "point": "circle",
    "arrow up": "arrow-up",
    "arrow right": "arrow-right",
}  # fmt: skip
THIN = ("x", "plus", "bar", "post")  # symbols that are lines
PX = 1.5  # of a point, for symbols; lines have 1.1
LEAST_TEXT = 12  # px of words
FAINT = 0.22  # opacity of bands
PALEST = 0.06  # opacity of a share of 0
MOST_POINTS = 2000  # values of a box of which each is drawn; of more, quartiles alone
CLEAR = "rgba(0,0,0,0)"


def faded(colour: str, part: float = FAINT) -> str:
    """A colour that what is behind it shows through.

    >>> faded("#2b7ab8")
    'rgba(43,122,184,0.22)'
    """
    red, green, blue = (int(colour[at : at + 2], 16) for at in (1, 3, 5))
    return f"rgba({red},{green},{blue},{part:g})"


def _template(said: str) -> str:
    """A text with values as plotly fills it in.

    >>> _template("mode 1: {y:.2f} Hz at {x:.0f} rpm")
    'mode 1: %{y:.2f} Hz at %{x:.0f} rpm<extra></extra>'
    """
    return re.sub(r"\{([xyz])(:[^}]*)?\}", r"%{\1\2}", said) + "<extra></extra>"


def _steps(is_stepped: bool) -> Layout:
    """Layout of a stepped line: each value holds up to the next point."""
    return {"shape": "hv"} if is_stepped else {}


def _area(element: of.Area, colour: str) -> Trace:
    made: Trace = {"type": "scatter", "mode": "lines", "fill": "toself", "fillcolor": colour}
    made |= {"x": [*element.x, element.x[0]], "y": [*element.y, element.y[0]]}
    return made | {"line": {"color": LIGHT[element.edge], "width": 1}, "hoverinfo": "skip"}


def _heat(element: of.Heat, colour: str) -> Trace:
    made: Trace = {"type": "heatmap", "z": element.shares, "text": element.written, "texttemplate": "%{text}"}
    made |= {"colorscale": [[0, faded(colour, PALEST)], [1, colour]], "showscale": False}
    return made | {"zmin": 0, "zmax": 1}


class PanelTraces:
    """Elements of one panel as traces, shapes and annotations of its axes."""

    def __init__(self, panel: Panel, number: int) -> None:
        end = "" if number == 1 else str(number)
        self.panel, self.end = panel, end
        self.axes = {"xaxis": f"x{end}", "yaxis": f"y{end}"}
        self.x, self.y = place_on(panel.x), place_on(panel.y)

    def heading(self) -> Layout:
        """The title of the panel, above it; what it chooses stands in the control."""
        place = (
            {"xref": f"x{self.end} domain", "yref": f"y{self.end} domain"}
            if self.panel.z is None
            else {"xref": "paper", "yref": "paper"}
        )
        text = self.panel.title.replace("\n", "<br>")
        return {"text": text, "x": 0, "y": 1, "xanchor": "left", "yanchor": "bottom", "showarrow": False, **place}

    def traces(self, element: Element) -> Iterator[Trace]:
        colour = LIGHT[element.colour]
        common: Trace = {"name": element.name, "opacity": element.opacity, **self.axes}
        common |= {"legendgroup": element.name} if element.name else {}
        common |= self._said(element)
        match element:
            case of.Line():
                yield self._line(element, colour) | common
            case of.Points():
                yield {"type": "scatter", "mode": "markers", **self._points(element, colour), **common}
            case of.Band():
                yield from self._band(element, colour, common)
            case of.Boxes():
                yield from self._boxes(element, colour, common)
            case of.Bars():
                yield self._bars(element, colour, common)
            case of.Area():
                yield _area(element, colour) | common
            case of.Heat():
                yield _heat(element, colour) | common
            case of.Space():
                yield self._space(element, colour)
            case of.Level() | of.Span() | of.Words():
                pass  # shapes and notes
            case _:
                raise TypeError(f"page: expected an element of a chart, got {type(element).__name__}")

    def shapes(self, element: Element) -> Iterator[Layout]:
        if isinstance(element, of.Level | of.Span):
            along, across = ("y", "x") if element.along == "y" else ("x", "y")
            place = self.y if along == "y" else self.x
            ends = (element.at, element.at) if isinstance(element, of.Level) else (element.low, element.high)
            first, last = map(float, place(ends))
            box = {f"{along}0": first, f"{along}1": last, f"{across}0": 0, f"{across}1": 1}
            refs = {f"{along}ref": f"{along}{self.end}", f"{across}ref": f"{across}{self.end} domain"}
            colour = LIGHT[element.colour]
            if isinstance(element, of.Level):
                yield {
                    "type": "line",
                    "line": {"color": colour, "width": 1.2 * element.width, "dash": element.dash},
                    "opacity": element.opacity,
                    **box,
                    **refs,
                }
            else:
                yield {
                    "type": "rect",
                    "line": {"width": 0},
                    "fillcolor": faded(colour, element.opacity),
                    "layer": "below",
                    **box,
                    **refs,
                }

    def notes(self, element: Element) -> Iterator[Layout]:
        if isinstance(element, of.Words):
            dx, dy = element.offset
            at = {
                "x": self._note_at(element.x, self.panel.x, self.x),
                "y": self._note_at(element.y, self.panel.y, self.y),
            }
            moved = (
                {"ax": 1.3 * dx, "ay": -1.3 * dy, "arrowhead": 0, "arrowwidth": 0.8}
                if element.has_leader
                else {"xshift": 1.3 * dx, "yshift": 1.3 * dy}
            )
            text = {
                "text": element.text.replace("\n", "<br>"),
                "font": {"size": max(round(1.3 * element.size), LEAST_TEXT)},
                "align": element.side,
            }
            ground = {"bgcolor": "rgba(127,127,127,0.12)"} if element.has_ground else {}
            refs = {"xref": f"x{self.end}", "yref": f"y{self.end}", "xanchor": element.side, "yanchor": element.edge}
            yield {"showarrow": element.has_leader, **at, **moved, **text, **refs, **ground}
        if isinstance(element, of.Level) and element.label:
            is_flat = element.along == "y"
            scale, place = (self.panel.y, self.y) if is_flat else (self.panel.x, self.x)
            own, other = ("y", "x") if is_flat else ("x", "y")
            refs = {f"{own}ref": f"{own}{self.end}", f"{other}ref": f"{other}{self.end} domain"}
            where = {own: self._note_at(element.at, scale, place), other: 0.01 if is_flat else 0.97}
            style = (
                {"xanchor": "left", "yanchor": "bottom"}
                if is_flat
                else {"xanchor": "right", "yanchor": "top", "textangle": -90}
            )
            yield {"text": element.label, "showarrow": False, "font": {"size": LEAST_TEXT}, **where, **refs, **style}

    @staticmethod
    def _note_at(value: float, scale: Axis, place: Callable[[Values], Array]) -> float:
        """Annotations stand at the logarithm on a logarithmic axis, as no other thing of plotly does."""
        return math.log10(value) if scale.scale == "log" else float(place([value])[0])

    def _said(self, element: Element) -> Trace:
        if isinstance(element.said, str):
            return {"hovertemplate": _template(element.said)} if element.said else {}
        return {"hovertext": list(element.said), "hovertemplate": "%{hovertext}<extra></extra>"}

    def _line(self, element: of.Line, colour: str) -> Trace:
        style = {"color": colour, "width": 1.15 * element.width, "dash": element.dash, "simplify": False}
        made: Trace = {"type": "scatter", "mode": "lines", "line": style | _steps(element.is_stepped)}
        made |= {"x": self.x(element.x), "y": self.y(element.y)}
        if element.symbol:
            symbol = {"symbol": SYMBOLS[element.symbol], "size": 6, "color": colour}
            made |= {"mode": "lines+markers", "marker": symbol | {"maxdisplayed": element.most_symbols}}
        return made

    def _band(self, element: of.Band, colour: str, common: Trace) -> Iterator[Trace]:
        """Its upper end, and its lower one filled up to that."""
        edge = {**common, "type": "scatter", "mode": "lines", "x": self.x(element.x)}
        edge |= {"line": {"width": 0, **_steps(element.is_stepped)}, "hoverinfo": "skip"}
        fill = {"fill": "tonexty", "fillcolor": faded(colour, FAINT * element.opacity), "opacity": 1}
        yield {**edge, "y": self.y(element.high), "showlegend": False}
        yield {**edge, "y": self.y(element.low), **fill}

    def _space(self, element: of.Space, colour: str) -> Trace:
        made: Trace = {"type": "scatter3d", "mode": "lines", "x": element.x, "y": element.y, "z": element.z}
        made |= {"line": {"color": colour, "width": 3 * element.width}, "scene": f"scene{self.end}"}
        return made | {"hoverinfo": "skip", "name": element.name, "legendgroup": element.name}

    def _points(self, element: of.Points, colour: str) -> Trace:
        is_thin = element.symbol in THIN
        symbol = SYMBOLS[element.symbol] + ("-open" if element.is_open or is_thin else "")
        made: Trace = {"x": self.x(element.x), "y": self.y(element.y)}
        made["marker"] = {
            "symbol": symbol,
            "size": PX * element.size,
            "color": colour,
            "line": {"width": 2 if element.is_open or is_thin else 0, "color": colour},
        }
        for name, middle, low, high in (
            ("y", element.y, element.low, element.high),
            ("x", element.x, element.left, element.right),
        ):
            if low is not None and high is not None:
                place = self.x if name == "x" else self.y
                up, down = place(high) - place(middle), place(middle) - place(low)
                made[f"error_{name}"] = {
                    "type": "data",
                    "symmetric": False,
                    "array": up,
                    "arrayminus": down,
                    "thickness": 1.4,
                    "width": 3,
                }
        return made

    def _boxes(self, element: of.Boxes, colour: str, common: Trace) -> Iterator[Trace]:
        place = self.y if element.along == "y" else self.x
        own, other = ("y", "x") if element.along == "y" else ("x", "y")
        for at, of_box in zip(element.at, element.values):
            values = np.asarray(of_box, dtype=float)
            values = values[np.isfinite(values)]
            if not len(values):
                continue
            ends = (element.whiskers[0], 25, 50, 75, element.whiskers[1])
            low, first, median, third, high = place(
                np.percentile(values, ends)
            )  # plotly's own quartiles are others than those of tables
            box = {
                "q1": [first],
                "median": [median],
                "q3": [third],
                "lowerfence": [low],
                "upperfence": [high],
                f"{other}0": at,
            }
            style = {
                "line": {"color": colour, "width": 1.6},
                "marker": {"color": colour, "size": 3},
                "whiskerwidth": 0.4,
                "width": element.width,
            }
            points = (
                {own: [place(values)], "boxpoints": "all", "jitter": 0.6, "pointpos": 0}
                if element.with_points and len(values) <= MOST_POINTS
                else {}
            )
            yield {"type": "box", "orientation": "v" if own == "y" else "h", **box, **style, **points, **common}

    def _bars(self, element: of.Bars, colour: str, common: Trace) -> Trace:
        own, other = ("y", "x") if element.along == "y" else ("x", "y")
        place = self.y if own == "y" else self.x
        size = np.asarray(element.size, dtype=float)
        base = np.zeros_like(size) if element.base is None else np.asarray(element.base, dtype=float)
        bars = {own: place(base + size) - place(base), other: element.at, "base": place(base), "width": element.width}
        ends: Trace = {}
        if element.low is not None and element.high is not None:
            up, down = (
                np.nan_to_num(each)
                for each in (np.asarray(element.high) - base - size, base + size - np.asarray(element.low))
            )
            ends = {
                f"error_{own}": {"type": "data", "symmetric": False, "array": up, "arrayminus": down, "thickness": 1.2}
            }
        return {
            "type": "bar",
            "orientation": "v" if own == "y" else "h",
            "marker": {"color": colour},
            **bars,
            **ends,
            **common,
        }


def place_on(scale: Axis) -> Callable[[Values], Array]:
    """Where values stand on an axis: themselves, but on one of a kind that plotly lacks."""
    if scale.scale != "symlog":
        return lambda values: np.asarray(values, dtype=float)
    return lambda values: symlog_positions(values, scale.linear)
