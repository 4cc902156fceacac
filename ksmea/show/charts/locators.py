"""The ticks of `ticks.py` on axes of matplotlib."""

from __future__ import annotations

import math
from typing import Any

from matplotlib.axis import Axis
from matplotlib.scale import SymmetricalLogTransform
from matplotlib.ticker import Formatter, Locator, LogLocator, NullLocator

from ksmea.show.charts.ticks import are_plain, even_ticks, symlog_ticks, written

FEW, HALF = 2.0, 0.5  # decades: of an axis with ticks at 1, 2 and 5, and of one with ticks at even steps


def plain_ticks(axis: Axis) -> None:
    """Plain numbers next to an axis whose scale is "log" or "symlog"; to be called when its scale is set.

    It has no ticks between them, as on a page: over five decades 64 of them take most of the time of a picture. Others stay
    as they are.
    """
    if axis.get_scale() == "log":
        axis.set_major_locator(PlainLogLocator())
    elif axis.get_scale() == "symlog":
        axis.set_major_locator(PlainSymlogLocator(axis))
    else:
        return
    axis.set_major_formatter(PlainFormatter())
    axis.set_minor_locator(NullLocator())


class PlainLogLocator(LogLocator):
    """Ticks at 1, 2 and 5 of an axis of few decades, else at powers of ten.

    An axis of less than half a decade has even steps.
    """

    def tick_values(self, vmin: float, vmax: float) -> Any:
        low, high = sorted((vmin, vmax))
        decades = math.log10(high / low) if low > 0 else math.inf
        if decades < HALF:
            return even_ticks(low, high)
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


class PlainFormatter(Formatter):
    """Numbers written out, or where one of an axis has many zeros, all as powers of ten."""

    def __call__(self, value: float, position: int | None = None) -> str:
        return written([value])[0]

    def format_ticks(self, values: Any) -> list[str]:
        low, high = sorted(self.axis.get_view_interval()) if self.axis is not None else (-math.inf, math.inf)
        shown = [value for value in values if low <= value <= high]
        return written(values, is_plain=are_plain(shown))
