"""Medians, quartiles and paired ratios: what repetitions in turn tell on a machine that is also busy with other things.

A ratio is taken within a turn, where both sides met the same neighbours and the same clock rate, and its median and quartiles over
the turns. The ratio of two medians would have the changes between turns in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Quartiles:
    """Median, first and third quartile."""

    median: float
    q1: float
    q3: float


def quartiles(values: object) -> Quartiles:
    """Of any numbers.

    >>> quartiles([4.0, 1.0, 3.0, 2.0, 5.0])
    Quartiles(median=3.0, q1=2.0, q3=4.0)
    """
    q1, median, q3 = np.quantile(np.asarray(values, dtype=float), [0.25, 0.5, 0.75])
    return Quartiles(float(median), float(q1), float(q3))


def paired_ratio(theirs: object, ours: object) -> Quartiles:
    """Of theirs over ours, turn by turn.

    >>> paired_ratio([10.0, 40.0, 30.0], [1.0, 2.0, 3.0])
    Quartiles(median=10.0, q1=10.0, q3=15.0)
    """
    return quartiles(np.asarray(theirs, dtype=float) / np.asarray(ours, dtype=float))


def largest_difference(theirs: object, ours: object) -> float:
    """The largest absolute difference over the largest absolute value of ours; not a number where shapes differ.

    >>> largest_difference([1.0, 2.1], [1.0, -2.0]), largest_difference([1.0], [1.0, 2.0])
    (2.05, nan)
    """
    one, other = np.asarray(theirs), np.asarray(ours)
    if one.shape != other.shape:
        return float("nan")
    scale = np.max(np.abs(other), initial=0.0)
    difference = float(np.max(np.abs(one - other), initial=0.0))
    return difference / float(scale) if scale > 0 else difference


def exponent(sizes: object, seconds: object) -> float:
    """Of the power law c·sizeᵖ that fits best in logarithms.

    >>> round(exponent([1, 10, 100], [3.0, 30.0, 300.0]), 6)
    1.0
    """
    return float(np.polyfit(np.log(np.asarray(sizes, float)), np.log(np.asarray(seconds, float)), 1)[0])
