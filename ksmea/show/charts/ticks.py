"""Ticks of logarithmic axes: at 1, 2 and 5 of few decades, else at powers of ten, with plain numbers beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axis import Axis
from matplotlib.scale import SymmetricalLogTransform
from matplotlib.ticker import Formatter, Locator, LogLocator, MaxNLocator, NullFormatter

from ksmea.arrays import Array

FEW, HALF = 2.0, 0.5  # decades: of an axis with ticks at 1, 2 and 5, and of one with ticks at even steps
EVEN = 5  # steps of the latter
MOST_POWERS = 4  # to each side of 0
TOLERANCE = 1e-9  # of a decade
LEAST, BEYOND = 1e-4, 1e6  # numbers from the first to below the second are written out


def plain_ticks(axis: Axis) -> None:
    """Plain numbers beside an axis whose scale is "log" or "symlog"; to be called when its scale is set. Others stay as they are."""
    if axis.get_scale() == "log":
        axis.set_major_locator(PlainLogLocator())
    elif axis.get_scale() == "symlog":
        axis.set_major_locator(PlainSymlogLocator(axis))
    else:
        return
    axis.set_major_formatter(PlainFormatter())
    axis.set_minor_formatter(NullFormatter())


class PlainLogLocator(LogLocator):
    """Ticks at 1, 2 and 5 of an axis of few decades, at even steps of one of less than half a decade, else at powers of ten."""

    def tick_values(self, vmin: float, vmax: float) -> Any:
        low, high = sorted((vmin, vmax))
        decades = math.log10(high / low) if low > 0 else math.inf
        if decades < HALF:
            return MaxNLocator(EVEN, steps=(1, 2, 5, 10)).tick_values(low, high)
        self.set_params(subs=(1.0, 2.0, 5.0) if decades < FEW else (1.0,))
        return super().tick_values(vmin, vmax)


class PlainSymlogLocator(Locator):
    """Ticks of an axis that is linear about 0 and logarithmic to both sides."""

    def __init__(self, axis: Axis) -> None:
        transform = axis.get_transform()
        assert isinstance(transform, SymmetricalLogTransform), "an axis of another scale"
        self._linear = float(transform.linthresh)

    def __call__(self) -> Any:
        assert self.axis is not None, "a locator of no axis"
        return self.tick_values(*self.axis.get_view_interval())

    def tick_values(self, vmin: float, vmax: float) -> Any:
        return symlog_ticks(min(vmin, vmax), max(vmin, vmax), self._linear)


def symlog_ticks(low: float, high: float, linear: float, most: int = MOST_POWERS) -> Array:
    """0 and, to both sides, `most` powers of ten beyond the linear part of an axis; even steps where that is all of it or none of
    these lies inside.

    >>> symlog_ticks(-30.0, 2000.0, 10.0), symlog_ticks(0.0, 4.0, 10.0)
    (array([ -10.,    0.,   10.,  100., 1000.]), array([0., 1., 2., 3., 4.]))
    """
    first = math.ceil(math.log10(linear) - TOLERANCE)
    powers = np.arange(first, math.floor(math.log10(max(-low, high, linear)) + TOLERANCE) + 1)
    if max(-low, high) <= linear:
        ticks = np.asarray(MaxNLocator(EVEN, steps=(1, 2, 5, 10)).tick_values(low, high), dtype=float)
    else:
        sizes = 10.0 ** powers[:: -(-len(powers) // most) or 1]
        ticks = np.concatenate([-sizes[::-1], [0.0], sizes])
    inside: Array = ticks[(ticks >= low) & (ticks <= high)]
    if len(inside) > 1:
        return inside
    return np.asarray(MaxNLocator(EVEN, steps=(1, 2, 5, 10)).tick_values(low, high), dtype=float)


class PlainFormatter(Formatter):
    """Numbers written out, or where one of an axis has many zeros, all as powers of ten."""

    def __call__(self, value: float, position: int | None = None) -> str:
        return written([value])[0]

    def format_ticks(self, values: Any) -> list[str]:
        low, high = sorted(self.axis.get_view_interval()) if self.axis is not None else (-math.inf, math.inf)
        shown = [value for value in values if low <= value <= high]
        return written(values, is_plain=_are_plain(shown))


def written(values: Sequence[float] | Array, is_plain: bool | None = None) -> list[str]:
    """Numbers as the ticks of one axis.

    >>> written([0.05, 1.0, 20000.0]), written([1e-8, 1e-4, 1.0])
    (['0.05', '1', '20000'], ['$10^{-8}$', '$10^{-4}$', '$10^{0}$'])
    """
    as_text = _plain if (_are_plain(values) if is_plain is None else is_plain) else _power
    return [as_text(float(value)) for value in values]


def _are_plain(values: Sequence[float] | Array) -> bool:
    sizes = np.abs(np.asarray(values, dtype=float))
    return bool(np.all((sizes == 0) | ((sizes >= LEAST) & (sizes < BEYOND))))


def _plain(value: float) -> str:
    return f"{value or 0.0:.6g}".replace("-", "−")


def _power(value: float) -> str:
    if value == 0:
        return "0"
    power = math.floor(math.log10(abs(value)) + 1e-9)
    factor = f"{value / 10.0**power:.3g}"
    before = {"1": "", "-1": "-"}.get(factor, rf"{factor}\cdot")
    return f"${before}10^{{{power}}}$"
