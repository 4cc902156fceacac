"""Where intervals that are open on a side end in a picture."""
# Shorter than 40 lines: figures use it without plotly.

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array

BEYOND = 0.1  # of the spread of all that is drawn: as far behind it an open side ends


def drawn_ends(low: Array, high: Array, values: Array, *, is_log: bool = False) -> tuple[Array, Array]:
    """Both ends (n,) of intervals, of which an open one, NaN, lies beyond all ends and values (m,) on its side: on a logarithmic
    axis by a factor, where an end that is not above 0 is as an open one, and such values are not drawn.

    >>> drawn_ends(np.array([np.nan, 1.0]), np.array([3.0, 4.0]), np.array([5.0, 6.0]))
    (array([0.5, 1. ]), array([3., 4.]))
    """
    if is_log:
        first, last = drawn_ends(
            *(np.log(each, where=each > 0, out=np.full(len(each), np.nan)) for each in (low, high, values))
        )
        return np.exp(first), np.exp(last)
    every = np.concatenate([low, high, values])
    every = every[np.isfinite(every)]
    if not len(every):
        return low, high
    reach = BEYOND * (np.ptp(every) or np.abs(every[0]) or 1.0)
    return np.where(np.isnan(low), every.min() - reach, low), np.where(np.isnan(high), every.max() + reach, high)
