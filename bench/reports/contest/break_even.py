"""From which price of one evaluation of the true model a surrogate pays.

To reach a target takes, expected as ERT is, N evaluations and an overhead of the method's own, the surrogate and the search:
total = N · price + overhead. A run's overhead until a target is its time until then without that of the true model, which is
taken as spread evenly over its evaluations.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def break_even(evaluations: float, overhead: float, others: Sequence[tuple[float, float]]) -> float:
    """The price (s) from which on a method takes less time in total than the fastest of the others, each with its evaluations
    and overhead (s); 0 where it always does, not a number where it never does.

    A surrogate takes 20 evaluations and 4 s, a direct search 1000 evaluations and 0.1 s:

    >>> round(break_even(20.0, 4.0, [(1000.0, 0.1)]), 5)
    0.00398
    """
    price = 0.0
    if not np.isfinite(evaluations):
        return np.nan
    for more, less_overhead in others:
        if not np.isfinite(more):
            continue
        if more <= evaluations:
            return np.nan
        price = max(price, (overhead - less_overhead) / (more - evaluations))
    return float(price)
