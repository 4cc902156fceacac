"""Ticks of logarithmic axes: at 1, 2 and 5 of few decades, else at powers of ten.

Plain numbers stand next to them. An axis may be linear about 0 and logarithmic beyond. No drawing library is needed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array

EVEN = 5  # steps of an axis with ticks at even steps
MOST_POWERS = 4  # to each side of 0
TOLERANCE = 1e-9  # of a decade
LEAST, BEYOND = 1e-4, 1e6  # numbers from the first to below the second are written out
SIGNIFICANT = 6  # digits of a tick
LINEAR_PART = 1 / (1 - 1 / 10)  # decades that the linear part to one side takes, as matplotlib's "symlog" has it


def even_ticks(low: float, high: float) -> Array:
    """At most `EVEN` steps of 1, 2 or 5 times a power of ten, from below one end to above the other.

    >>> even_ticks(0.0, 4.0)
    array([0., 1., 2., 3., 4.])
    """
    least = (high - low) / EVEN or 1.0
    power = 10.0 ** math.floor(math.log10(least))
    step = power * next(each for each in (1, 2, 5, 10) if each * power >= least * (1 - TOLERANCE))
    return np.asarray(
        step * np.arange(math.floor(low / step + TOLERANCE), math.ceil(high / step - TOLERANCE) + 1), dtype=float
    )


def symlog_positions(values: Sequence[float] | Array, linear: float) -> Array:
    """Positions of values on an axis that is linear up to `linear` to both sides.

    They are in units of the axis at 0.

    >>> symlog_positions([-10.0, 0.0, 0.5, 10.0], 1.0).round(3).tolist()
    [-2.111, 0.0, 0.556, 2.111]
    """
    found = np.asarray(values, dtype=float)
    size = np.maximum(np.abs(found), linear)
    beyond = np.sign(found) * linear * (LINEAR_PART + np.log10(size / linear))
    at: Array = np.where(np.abs(found) <= linear, LINEAR_PART * found, beyond)
    return at


def symlog_ticks(low: float, high: float, linear: float, most: int = MOST_POWERS) -> Array:
    """0 and, to both sides, `most` powers of ten beyond the linear part of an axis.

    Even steps where that is all of it or none of these lies inside.

    >>> symlog_ticks(-30.0, 2000.0, 10.0), symlog_ticks(0.0, 4.0, 10.0)
    (array([ -10.,    0.,   10.,  100., 1000.]), array([0., 1., 2., 3., 4.]))
    """
    first = math.ceil(math.log10(linear) - TOLERANCE)
    powers = np.arange(first, math.floor(math.log10(max(-low, high, linear)) + TOLERANCE) + 1)
    if max(-low, high) <= linear:
        ticks = even_ticks(low, high)
    else:
        sizes = 10.0 ** powers[:: -(-len(powers) // most) or 1]
        ticks = np.concatenate([-sizes[::-1], [0.0], sizes])
    inside: Array = ticks[(ticks >= low) & (ticks <= high)]
    if len(inside) > 1:
        return inside
    return even_ticks(low, high)


def written(values: Sequence[float] | Array, is_plain: bool | None = None) -> list[str]:
    """Numbers as the ticks of one axis.

    >>> written([0.05, 1.0, 20000.0]), written([1e-8, 1e-4, 1.0])
    (['0.05', '1', '20000'], ['$10^{-8}$', '$10^{-4}$', '$10^{0}$'])
    >>> written([-1e-5, 0.1 + 0.2], is_plain=True)
    ['−0.00001', '0.3']
    """
    as_text = _plain if (are_plain(values) if is_plain is None else is_plain) else _power
    return [as_text(float(value)) for value in values]


def are_plain(values: Sequence[float] | Array) -> bool:
    sizes = np.abs(np.asarray(values, dtype=float))
    return bool(np.all((sizes == 0) | ((sizes >= LEAST) & (sizes < BEYOND))))


def _plain(value: float) -> str:
    digits = np.format_float_positional(value or 0.0, precision=SIGNIFICANT, fractional=False, trim="-")
    return digits.replace("-", "−")


def _power(value: float) -> str:
    if value == 0:
        return "0"
    power = math.floor(math.log10(abs(value)) + 1e-9)
    factor = f"{value / 10.0**power:.3g}"
    before = {"1": "", "-1": "-"}.get(factor, rf"{factor}\cdot")
    return f"${before}10^{{{power}}}$"
