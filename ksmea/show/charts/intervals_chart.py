"""Unknowns with their intervals on one axis, each relative to a value of its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ksmea.records.estimate import Shown
from ksmea.show.charts.chart import Axis, Chart, Element, Level, Points, named_rows, one_panel
from ksmea.show.charts.colours import REFERENCE, category, symbol
from ksmea.show.text import rounded_alike, with_ends

OPEN_REACH = 1.15  # times the farthest end that is drawn: where the axis, and an interval that is open, end
FAR = 10.0  # times the reach of the intervals that are believed, beyond which arrows are drawn; tables have the values
MOST_OF = 75  # per cent of the believed intervals set the reach: one that is hardly known would hide all others
AT_EDGE = 0.97  # of the way to the edge: where arrows are
ROW = 0.48  # inches for each unknown
TITLE = "Parameters with their intervals"


def intervals_chart(
    unknowns: Mapping[str, Mapping[str, Shown]], truth: Mapping[str, float], caption: str, title: str = TITLE
) -> Chart:
    """Values and intervals of the unknowns, by name, in each series, by name, as deviations in per cent.

    Deviations are from the value of the last series that has the unknown, in per cent of it; of an angle, in per cent
    of 1 rad. `truth` has true values in the same units. The axis reaches at most `FAR` times as far as three quarters of
    the intervals of these last series; a value or an end beyond, and an open end, is an arrow at its edge.
    """
    series = list(dict.fromkeys(name for of in unknowns.values() for name in of))
    names = list(unknowns)
    believed = {name: list(of.values())[-1] for name, of in unknowns.items()}
    zero = {name: each.value for name, each in believed.items()}
    scale = {name: _scale(believed[name]) or _reach(of.values()) for name, of in unknowns.items()}
    every = [_farthest(each, zero[name], scale[name]) for name, of in unknowns.items() for each in of.values()]
    reaches = [_farthest(each, zero[name], scale[name]) for name, each in believed.items()]
    known = [each for each in reaches if each > 0]
    own = float(np.percentile(known, MOST_OF, method="higher")) if known else 0.0
    edge = OPEN_REACH * (min(max(every, default=0.0), FAR * own if own else np.inf) or 1.0)
    elements: list[Element] = [Level(at=0.0, along="x", dash="solid", width=0.8)]
    arrows: list[Element] = []
    for number, series_name in enumerate(series):
        offset = 0.5 * ((number + 0.5) / len(series) - 0.5)
        mine = [
            (at + offset, name, of[series_name]) for at, (name, of) in enumerate(unknowns.items()) if series_name in of
        ]
        beyond = [each for each in mine if abs(_pct(each[2].value, zero[each[1]], scale[each[1]])) > edge]
        inside = [each for each in mine if each not in beyond]
        colour = category(number)
        at = [_pct(each.value, zero[name], scale[name]) for _, name, each in inside]
        left, right = (
            [_end(getattr(each, end), sign * edge, zero[name], scale[name]) for _, name, each in inside]
            for end, sign in (("low", -1), ("high", 1))
        )
        said = [_said(name, each) for _, name, each in inside]
        rows = [row for row, _, _ in inside]
        elements.append(
            Points(at, rows, symbol(number), 6.0, left=left, right=right, name=series_name, colour=colour, said=said)
        )
        out = [(*each, 1 if each[2].value > zero[each[1]] else -1) for each in beyond]
        for one, low, high in zip(inside, left, right):
            out += [(*one, way) for way, end in ((-1, low), (1, high)) if way * end >= edge]
        for row, name, each, way in out:
            shape = "triangle right" if way > 0 else "triangle left"
            arrows.append(Points([way * AT_EDGE * edge], [row], shape, 7.0, colour=colour, said=[_said(name, each)]))
    elements += arrows
    if true := [(at, name) for at, name in enumerate(names) if np.isfinite(truth.get(name, np.nan))]:
        at = [_pct(truth[name], zero[name], scale[name]) for _, name in true]
        said = [f"{name}: {_with_digits_of(truth[name], believed[name])}" for _, name in true]
        elements.append(Points(at, [row for row, _ in true], "x", 7.0, name="true value", colour=REFERENCE, said=said))
    label = f'difference from "{series[-1]}" (%)' if len(series) > 1 else "difference from the value found (%)"
    caption += " Angles: 100 % is 1 rad." if any(_is_angle(each) for each in believed.values()) else ""
    caption += " Arrows: beyond that edge or open, as the table says." if arrows else ""
    x = Axis(label, low=-edge, high=edge, better="middle")
    return one_panel(elements, x, named_rows(names), title, caption, height=0.2 + ROW * len(names))


def _said(name: str, each: Shown) -> str:
    return f"{name}: {with_ends(each.value, each.low, each.high)} {each.unit}"


def _with_digits_of(value: float, shown: Shown) -> str:
    """A value, rounded to the digits that an interval of another one warrants."""
    return rounded_alike(value, shown.low, shown.high)[0]


def _scale(shown: Shown) -> float:
    """Scale of 100 %: the value, or 1 rad of an angle, whose value is only counted from somewhere."""
    return float(np.degrees(1.0)) if _is_angle(shown) else abs(shown.value)


def _is_angle(shown: Shown) -> bool:
    return shown.unit == "deg"


def _farthest(shown: Shown, zero: float, scale: float) -> float:
    """How far a value and the ends of its interval lie from a value, in per cent."""
    return max(abs(_pct(end, zero, scale)) for end in (shown.value, shown.low, shown.high) if np.isfinite(end))


def _pct(value: float, zero: float, scale: float) -> float:
    return 100 * (value - zero) / scale


def _end(value: float, edge: float, zero: float, scale: float) -> float:
    """An end of an interval; one that is open lies at the edge."""
    return edge if np.isnan(value) else _pct(value, zero, scale)


def _reach(shown: Any) -> float:
    """Reach of the interval of an unknown whose value is 0."""
    ends = [abs(end) for each in shown for end in (each.low, each.high) if np.isfinite(end)]
    return max(ends, default=0.0) or 1.0
