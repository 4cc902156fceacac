"""Where intervals that are open on a side end in a picture."""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array


def drawn_ends(low: Array, high: Array, values: Array) -> tuple[Array, Array]:
    """Both ends (n,) of intervals, of which an open one, NaN, lies at the farthest of all ends and values (m,) on its side.

    >>> drawn_ends(np.array([np.nan, 1.0]), np.array([3.0, 4.0]), np.array([5.0, 6.0]))
    (array([1., 1.]), array([3., 4.]))
    """
    every = np.concatenate([low, high, values])
    every = every[np.isfinite(every)]
    if not len(every):
        return low, high
    return np.where(np.isnan(low), every.min(), low), np.where(np.isnan(high), every.max(), high)
