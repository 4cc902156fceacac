"""Unknowns with their intervals, each relative to a value of its own, so that all of them stand on one axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.plan.page import Plot
from bench.reports.plots.traces import COLOURS, axis, layout, level
from ksmea.show.text import rounded_alike, with_ends

OPEN_REACH = 1.15  # times the farthest end that is drawn: where the axis, and an interval that is open, end
FAR = 10.0  # times the reach of the intervals that are believed, beyond which arrows are drawn; tables have the values
AT_EDGE = 0.97  # of the way to the edge: where arrows are
SYMBOLS = ("circle", "diamond", "square", "triangle-up")
ROW = 46  # px for each unknown


@dataclass(frozen=True)
class Shown:
    """A value with the ends of its interval in `unit`, not a number where open."""

    value: float
    low: float
    high: float
    unit: str


def interval_plot(unknowns: Mapping[str, Mapping[str, Shown]], truth: Mapping[str, float], alternative: str) -> Plot:
    """Of each unknown, by name, the value and interval of each series, by name; `truth` has true values in the same units.
    What is drawn is the difference from the value of the last series that has the unknown, in per cent of it, of an angle in per
    cent of 1 rad, as far as `FAR` times what the intervals of these reach; a value beyond is an arrow at that edge."""
    series = list(dict.fromkeys(name for of in unknowns.values() for name in of))
    names = list(unknowns)
    believed = {name: list(of.values())[-1] for name, of in unknowns.items()}
    zero = {name: each.value for name, each in believed.items()}
    scale = {name: _scale(believed[name]) or _reach(of.values()) for name, of in unknowns.items()}
    every = [_farthest(each, zero[name], scale[name]) for name, of in unknowns.items() for each in of.values()]
    own = max((_farthest(each, zero[name], scale[name]) for name, each in believed.items()), default=0.0)
    edge = OPEN_REACH * (min(max(every, default=0.0), FAR * own if own else np.inf) or 1.0)
    traces: list[dict[str, Any]] = []
    arrows: list[dict[str, Any]] = []
    for number, series_name in enumerate(series):
        offset = 0.5 * ((number + 0.5) / len(series) - 0.5)
        mine = [
            (at, name, unknowns[name][series_name]) for at, name in enumerate(names) if series_name in unknowns[name]
        ]
        beyond = [each for each in mine if abs(_pct(each[2].value, zero[each[1]], scale[each[1]])) > edge]
        inside = [each for each in mine if each not in beyond]
        traces.append(_trace(series_name, inside, zero, scale, edge, offset, number))
        arrows += [_arrow(series_name, each, zero, edge, offset, number) for each in beyond]
    traces += arrows
    if known := [(at, name) for at, name in enumerate(names) if np.isfinite(truth.get(name, np.nan))]:
        traces.append(
            {
                "type": "scatter", "mode": "markers", "name": "true value", "y": [at for at, _ in known],
                "x": [_pct(truth[name], zero[name], scale[name]) for _, name in known],
                "marker": {"symbol": "x-thin", "size": 11, "line": {"width": 2, "color": "#7a7a7a"}},
                "text": [f"{name}: {_with_digits_of(truth[name], believed[name])}" for _, name in known], "hovertemplate": "%{text}<extra>true value</extra>",
            }
        )  # fmt: skip
    made = layout(f'difference from "{series[-1]}" (%)' if len(series) > 1 else "difference from the value found (%)")
    made["xaxis"]["range"] = [-edge, edge]
    labels = [f"{name} " for name in names]
    made["yaxis"] = axis(tickvals=list(range(len(names))), ticktext=labels, range=[len(names) - 0.5, -0.5])
    made["shapes"] = [level(0, along="x", dash="solid")]
    said = alternative + (" Angles: 100 % is 1 rad." if any(_is_angle(each) for each in believed.values()) else "")
    said += " Arrows: beyond that edge, as the table says." if arrows else ""
    return Plot("Unknowns with their intervals", said, {"data": traces, "layout": made}, height=110 + ROW * len(names))


def _trace(
    series_name: str, mine: Sequence[tuple[int, str, Shown]], zero: Mapping[str, float], scale: Mapping[str, float], edge: float, offset: float, number: int
) -> dict[str, Any]:  # fmt: skip
    at = [_pct(each.value, zero[name], scale[name]) for _, name, each in mine]
    low, high = (
        [_end(getattr(each, end), sign * edge, zero[name], scale[name]) for _, name, each in mine]
        for end, sign in (("low", -1), ("high", 1))
    )
    colour = COLOURS[number % len(COLOURS)]
    return {
        "type": "scatter",
        "mode": "markers",
        "name": series_name,
        "x": at,
        "y": [row + offset for row, _, _ in mine],
        "marker": {"color": colour, "size": 9, "symbol": SYMBOLS[number % len(SYMBOLS)]},
        "error_x": {
            "type": "data",
            "symmetric": False,
            "array": [end - value for end, value in zip(high, at)],
            "arrayminus": [value - end for end, value in zip(low, at)],
            "thickness": 1.8,
            "width": 4,
        },
        "text": [_said(name, each) for _, name, each in mine],
        "hovertemplate": "%{text}<extra>" + series_name + "</extra>",
    }


def _arrow(
    series_name: str, one: tuple[int, str, Shown], zero: Mapping[str, float], edge: float, offset: float, number: int
) -> dict[str, Any]:
    """In place of a value that is not drawn."""
    row, name, each = one
    is_right = each.value > zero[name]
    return {
        "type": "scatter",
        "mode": "markers",
        "name": series_name,
        "showlegend": False,
        "x": [AT_EDGE * (edge if is_right else -edge)],
        "y": [row + offset],
        "marker": {
            "color": COLOURS[number % len(COLOURS)],
            "size": 11,
            "symbol": "triangle-right" if is_right else "triangle-left",
        },
        "text": [_said(name, each)],
        "hovertemplate": "%{text}<extra>" + series_name + "</extra>",
    }


def _said(name: str, each: Shown) -> str:
    return f"{name}: {with_ends(each.value, each.low, each.high)} {each.unit}"


def _with_digits_of(value: float, shown: Shown) -> str:
    """A value, rounded to the digits that an interval of another one warrants."""
    return rounded_alike(value, shown.low, shown.high)[0]


def _scale(shown: Shown) -> float:
    """What 100 % is: the value, or 1 rad of an angle, whose value is only counted from somewhere."""
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
    """Of an unknown whose value is 0: how far its interval reaches."""
    ends = [abs(end) for each in shown for end in (each.low, each.high) if np.isfinite(end)]
    return max(ends, default=0.0) or 1.0
