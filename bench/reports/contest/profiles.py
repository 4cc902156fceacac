"""Performance and data profiles: on which share of the instances a method is fast, by itself and beside the others.

`times` (n_instance, n_method) are expected running times to one target, infinite where no run reaches it. An instance that no
method solves counts as unsolved by all.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array


def performance_ratios(times: Array) -> Array:
    """By how much each method is slower than the fastest one on the same instance (Dolan & Moré, Math. Program. 91 (2002)
    201–213, eq. (2.1)); infinite where it does not solve it.

    >>> performance_ratios(np.array([[10.0, 20.0], [30.0, np.inf], [np.inf, np.inf]]))
    array([[ 1.,  2.],
           [ 1., inf],
           [inf, inf]])
    """
    times = np.asarray(times, dtype=float)
    fastest = np.min(times, axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(times), times / fastest, np.inf)


def simplex_gradients(times: Array, unknowns: Array) -> Array:
    """Running times in units of d + 1 evaluations, what a simplex gradient costs (Moré & Wild, SIAM J. Optim. 20 (2009)
    172–191, eq. (2.4)); `unknowns` (n_instance,) are d."""
    return np.asarray(np.asarray(times) / (np.asarray(unknowns)[:, None] + 1))


def profile(values: Array, grid: Array) -> Array:
    """Share of the instances (n_grid, n_method) whose ratio or time (n_instance, n_method) is at or below each of the grid."""
    return np.asarray(np.mean(np.asarray(values)[None] <= np.asarray(grid)[:, None, None], axis=1))
