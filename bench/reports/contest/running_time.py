"""Running time to targets: expectation, distribution, performance profiles and break-even price.

- ERT, the expected running time if an unsuccessful run is followed by another one: cost of all runs until the target, or until
  their end, per run that reaches it (Auger & Hansen, IEEE CEC 2005, 1777–1784; Hansen et al., Optim. Methods Softw. 36 (2021)
  114–144, doi 10.1080/10556788.2020.1808977).
- ECDF: the share of pairs of target and run that are reached within a cost per unknown. A method that ends before its budget
  stays at its last value. COCO would simulate restarts from other runs; here a repetition has its own noise, so that another run
  is not a restart on the same data.
- Profiles: the share of the instances on which a method is fast, alone and relative to the others. `times`
  (n_instance, n_method) are ERTs, infinite if no run reaches the target; an instance without any success counts as unsolved by all.
- Break-even: the price of one true-model evaluation from which a surrogate pays. A target takes N evaluations and an overhead of
  the method's own, total = N · price + overhead; the overhead is the time until the target less the true model's time,
  which is assumed to be spread evenly over its evaluations.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array


def ecdf(hits: Array, grid: Array) -> Array:
    """Share of `hits` (any shape, infinite where not reached) at or below each cost of the grid (n_grid,).

    >>> ecdf(np.array([[1.0, 10.0], [5.0, np.inf]]), np.array([1.0, 5.0, 100.0]))
    array([0.25, 0.5 , 0.75])
    """
    every = np.sort(np.ravel(hits))
    return np.asarray(np.searchsorted(every, grid, side="right") / len(every))


def area(hits: Array, most: float) -> Array:
    """Area under the ECDF of each run (n_run,) over the logarithm of the cost from 1 to `most`.

    It is a share of the whole area.

    It is the mean over the targets (n_run, n_target) of how early each is reached: 1 at a cost of 1, 0 at `most` or never.

    >>> area(np.array([[1.0, 10.0, np.inf]]), 100.0)
    array([0.5])
    """
    if most <= 1:
        return np.zeros(len(hits))
    early = 1 - np.log(np.maximum(hits, 1.0)) / np.log(most)
    return np.asarray(np.mean(np.maximum(early, 0.0), axis=1))


def break_even(evaluations: float, overhead: float, others: Sequence[tuple[float, float]]) -> float:
    """Price (s) from which a method takes less total time than the fastest of the others.

    Each method has its evaluations and overhead (s). The price is 0 if it always does, NaN if it never does.

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


def performance_ratios(times: Array) -> Array:
    """Ratio of each method's time to the fastest one's on each instance; infinite if it does not solve it.

    Source: Dolan & Moré, Math. Program. 91 (2002) 201–213, eq. (2.1).

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
    """Running times in units of d + 1 evaluations, the cost of a simplex gradient.

    `unknowns` (n_instance,) are d. Source: Moré & Wild, SIAM J. Optim. 20 (2009) 172–191, eq. (2.4).
    """
    return np.asarray(np.asarray(times) / (np.asarray(unknowns)[:, None] + 1))


def profile(values: Array, grid: Array) -> Array:
    """Share of the instances (n_grid, n_method) at or below each value of the grid.

    The values are ratios or times (n_instance, n_method).
    """
    return np.asarray(np.mean(np.asarray(values)[None] <= np.asarray(grid)[:, None, None], axis=1))


def spent(hits: Array, ends: Array) -> Array:
    """Cost of each run until each target, (n_run, n_target).

    `hits`, infinite where not reached, else its end (n_run,).
    """
    return np.where(np.isfinite(hits), hits, np.asarray(ends)[:, None])


def expected_running_time(costs: Array, successes: Array) -> Array:
    """ERT of summed costs and numbers of successes, of any common shape; infinite without a success.

    Two runs reach the target at 10 and 30, one ends at 100 without:

    >>> float(expected_running_time(10.0 + 30.0 + 100.0, 2))
    70.0
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.asarray(successes) > 0, np.divide(costs, successes), np.inf)


def resampled_running_time(costs: Array, successes: Array, weights: Array) -> Array:
    """ERT (n, …) of samples of instances.

    Costs and successes (n_instance, …), and how often each is drawn (n, n_instance).
    """
    return expected_running_time(np.tensordot(weights, costs, 1), np.tensordot(weights, successes, 1))
