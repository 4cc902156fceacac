"""Charts as plain data: panels with axes, and their elements.

Elements are lines, points, bands, boxes, bars, levels and words.

A chart is described once, by one function of the records that it shows. `picture.py` makes a PNG or SVG of it and
`interactive.py` a plot of a page, so that both show the same. Values are in the units that axes name; not a number is a gap.
Colours are roles (`colours.py`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from ksmea.arrays import Array
from ksmea.show.charts.colours import MODEL, REFERENCE

Values = Sequence[float] | Array
Along = Literal["x", "y"]
Dash = str  # one of `colours.DASHES`


@dataclass(frozen=True)
class Axis:
    """One axis.

    Ends that are None follow from what is drawn. `better` says on which side better values lie.
    """

    label: str = ""
    scale: Literal["linear", "log", "symlog"] = "linear"
    low: float | None = None
    high: float | None = None
    linear: float = 1.0  # of a symlog axis: it is linear from −linear to linear, and logarithmic beyond
    ticks: Mapping[float, str] | None = None  # words at values, in place of numbers; none at all where empty
    is_whole: bool = False  # its values are counts
    is_reversed: bool = False
    group: str = ""  # axes of one group have the same ends
    better: Literal["", "low", "high", "middle"] = ""


@dataclass(frozen=True, kw_only=True)
class Element:
    """Common attributes of all that is drawn.

    Elements of one name share an entry of the legend; without a name they have no entry. `said` is shown at the
    pointer: a text for each point, or one with values as in '{y:.2f} Hz at {x:.0f} rpm'. A page chooses elements by
    their `tags` (`Choice`).
    """

    name: str = ""
    colour: str = MODEL
    opacity: float = 1.0
    said: str | Sequence[str] = ""
    tags: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Line(Element):
    """A line through points (n,)."""

    x: Values
    y: Values
    dash: Dash = "solid"
    width: float = 1.6  # points
    is_stepped: bool = False  # each value holds up to the next point
    symbol: str = ""  # at each point
    most_symbols: int = 0  # where there are more points, at some of them; 0: at each


@dataclass(frozen=True)
class Points(Element):
    """Symbols at points (n,), with intervals in y (`low`, `high`) or in x (`left`, `right`).

    These are ends, not lengths.
    """

    x: Values
    y: Values
    symbol: str = "circle"
    size: float = 5.0  # points
    is_open: bool = False
    low: Values | None = None
    high: Values | None = None
    left: Values | None = None
    right: Values | None = None


@dataclass(frozen=True)
class Band(Element):
    """Area between two lines (n,)."""

    x: Values
    low: Values
    high: Values
    is_stepped: bool = False


@dataclass(frozen=True)
class Boxes(Element):
    """A box for each of (n,) sets of values: median, quartiles, and whiskers at percentiles."""

    at: Values
    values: Sequence[Values]
    whiskers: tuple[float, float] = (0.0, 100.0)
    along: Along = "y"  # the axis of the values
    width: float = 0.55
    with_points: bool = False  # each value too, on a page


@dataclass(frozen=True)
class Bars(Element):
    """Bars (n,) from `base` on, with intervals."""

    at: Values
    size: Values
    base: Values | None = None  # 0, or what each stands on
    along: Along = "y"  # the axis of the sizes
    width: float = 0.8
    low: Values | None = None
    high: Values | None = None


@dataclass(frozen=True, kw_only=True)
class Level(Element):
    """A straight line through the whole panel at a value of an axis, with words at its end."""

    at: float
    along: Along = "y"  # the axis that the value is of
    dash: Dash = "dot"
    width: float = 1.0
    label: str = ""
    colour: str = REFERENCE


@dataclass(frozen=True, kw_only=True)
class Span(Element):
    """All between two values of an axis."""

    low: float
    high: float
    along: Along = "y"
    colour: str = REFERENCE
    opacity: float = 0.12


@dataclass(frozen=True, kw_only=True)
class Words(Element):
    """A text at a point, moved by `offset` (points, right and up).

    A leader to the point is drawn if `has_leader`.
    """

    x: float
    y: float
    text: str
    colour: str = REFERENCE
    size: float = 8.0  # points
    offset: tuple[float, float] = (0.0, 0.0)
    side: Literal["left", "center", "right"] = "center"  # which side of the text is at the point
    edge: Literal["top", "middle", "bottom"] = "middle"
    has_leader: bool = False
    has_ground: bool = False  # what lies behind it is covered


@dataclass(frozen=True)
class Area(Element):
    """A filled polygon through points (n,), with an edge."""

    x: Values
    y: Values
    edge: str = REFERENCE


@dataclass(frozen=True)
class Heat(Element):
    """A table of shares (n_row, n_column), 0 to 1, as darkness; row 0 is at y = 0.

    Its words are written in it; without any, shares above 0 in per cent.
    """

    shares: Array
    words: tuple[tuple[str, ...], ...] = ()

    @property
    def written(self) -> tuple[tuple[str, ...], ...]:
        return self.words or tuple(
            tuple(f"{100 * share:.0f}" if share > 0 else "" for share in row) for row in self.shares
        )


@dataclass(frozen=True)
class Space(Element):
    """A line through points (n,) of a panel in space."""

    x: Values
    y: Values
    z: Values
    width: float = 1.0


@dataclass(frozen=True)
class Panel:
    """Elements in one pair of axes; later ones lie above earlier ones. With `z` the panel is in space."""

    elements: tuple[Element, ...]
    x: Axis = field(default_factory=Axis)
    y: Axis = field(default_factory=Axis)
    title: str = ""
    height: float = 3.6  # inches
    is_to_scale: bool = False  # both axes have one scale
    z: Axis | None = None


@dataclass(frozen=True)
class Choice:
    """Choice of visible elements on a page.

    Visible are elements whose tag `key` is the chosen option, and all without such a tag.
    """

    key: str
    label: str
    options: tuple[str, ...]
    with_all: bool = True  # the first option shows all of them
    chosen: str = ""  # at first; '': all, or the first option


@dataclass(frozen=True)
class Chart:
    """Stacks of panels, one panel over another, `across` stacks side by side.

    The title is what was found or is shown; the caption says in words what is seen, for those too who do not see it.
    """

    title: str
    caption: str
    stacks: tuple[tuple[Panel, ...], ...]
    across: int = 1
    width: float = 8.0  # inches, of a picture
    choices: tuple[Choice, ...] = ()
    of_stacks: str = (
        ""  # what each stack is of, by its first title ('cell'): of many a page shows one at a time, by choice
    )
    most: int = 9  # stacks in a picture
    main: int = 0  # number of the panel that is drawn on given axes

    @property
    def panels(self) -> tuple[Panel, ...]:
        return tuple(panel for stack in self.stacks for panel in stack)

    def titled(self, words: str) -> Chart:
        """This chart with words in brackets behind its title.

        An example is how many runs it shows of an unfinished experiment.
        """
        return replace(self, title=f"{self.title} ({words})".lstrip())


def named_rows(names: Iterable[str], label: str = "", group: str = "", *, beyond: float = 0.6) -> Axis:
    """Axis of named rows, the first at the top.

    Row n is at y = n; the axis ends `beyond` the outer rows.

    >>> named_rows(["first", "second"]).ticks
    {0.0: 'first', 1.0: 'second'}
    """
    ticks = {float(at): name for at, name in enumerate(names)}
    return Axis(label, low=-beyond, high=len(ticks) - 1 + beyond, ticks=ticks, is_reversed=True, group=group)


def one_panel(elements: Iterable[Element], x: Axis, y: Axis, title: str, caption: str, **more: Any) -> Chart:
    """A chart of one panel; `more` are fields of the panel (`height`, `is_to_scale`) and of the chart."""
    own = {name: more.pop(name) for name in ("height", "is_to_scale") if name in more}
    return Chart(title, caption, ((Panel(tuple(elements), x, y, **own),),), **more)


def stacked_bars(at: Values, parts: Mapping[str, tuple[Array, str]]) -> Iterator[Bars]:
    """Bars to the right, of parts by name with their sizes (n,) and colours, one behind the other."""
    base = np.zeros(len(at))
    for name, (size, colour) in parts.items():
        yield Bars(at, size, base, "x", name=name, colour=colour, said=f"{name}: {{x:.3g}}")
        base = base + size


def ends_of(panels: Iterable[Panel], along: Along) -> tuple[float, float]:
    """The least and the largest value that the elements of panels have on an axis; 1 and 1 without values.

    On a logarithmic axis only values above 0 count.
    """
    found = [np.ones(0)]
    for panel in panels:
        values = [
            np.asarray(each, dtype=float).ravel() for element in panel.elements for each in _values(element, along)
        ]
        is_log = (panel.x if along == "x" else panel.y).scale == "log"
        found += [each[np.isfinite(each) & ((each > 0) | (not is_log))] for each in values]
    every = np.concatenate(found)
    return (float(every.min()), float(every.max())) if every.size else (1.0, 1.0)


def _values(element: Element, along: Along) -> Iterable[Values]:
    match element:
        case Line() | Area():
            yield element.x if along == "x" else element.y
        case Points():
            ends = (element.x, element.left, element.right) if along == "x" else (element.y, element.low, element.high)
            yield from (each for each in ends if each is not None)
        case Band():
            yield from (element.x,) if along == "x" else (element.low, element.high)
        case Boxes():
            yield from element.values if element.along == along else (element.at,)
        case Bars():
            base = np.zeros(len(element.size)) if element.base is None else np.asarray(element.base)
            yield from (base, base + np.asarray(element.size)) if element.along == along else (element.at,)
        case Level():
            yield [element.at] if element.along == along else []
        case Words():
            yield [element.x if along == "x" else element.y]


def broken(values: Values, breaks: Sequence[int]) -> Array:
    """Values to be drawn as one line for each run: not a number before each further run.

    >>> broken(np.array([1.0, 2.0, 1.0, 2.0]), [2])
    array([ 1.,  2., nan,  1.,  2.])
    """
    return np.insert(np.asarray(values, dtype=float), list(breaks), np.nan)
