"""Empirical distribution of running times (ECDF): the share of pairs of target and run that are reached within a cost.

The cost is that per unknown. Runs are taken as they are: a method that ends before its budget stays where it is. COCO would
simulate restarts from other runs (Hansen et al., Optim. Methods Softw. 36 (2021) 114–144, doi 10.1080/10556788.2020.1808977);
here a repetition has noise of its own, so that a run of another one is no restart on the same data.
"""

from __future__ import annotations

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
    """Area under the ECDF of each run (n_run,) over the logarithm of the cost from 1 to `most`, as a share of all of it.

    It is the mean over the targets (n_run, n_target) of how early each is reached: 1 at a cost of 1, 0 at `most` or never.

    >>> area(np.array([[1.0, 10.0, np.inf]]), 100.0)
    array([0.5])
    """
    if most <= 1:
        return np.zeros(len(hits))
    early = 1 - np.log(np.maximum(hits, 1.0)) / np.log(most)
    return np.asarray(np.mean(np.maximum(early, 0.0), axis=1))
