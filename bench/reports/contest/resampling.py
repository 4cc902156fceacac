"""Bootstrap over instances: how far a result would differ on other instances of the same families.

Instances are drawn with replacement within each family, so that every family keeps its weight, and for all methods the same
ones, so that they stay paired. Repetitions are not drawn: they belong to their instance. Percentile intervals: Efron &
Tibshirani, *An Introduction to the Bootstrap*, 1993, ch. 13.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.reports.rates import interval as interval_of_rate
from ksmea.arrays import Array

N_RESAMPLE = 1000  # the ends of 95 % intervals are then good to about a percentile
LEVEL = 0.95
LEAST_INSTANCES = 5  # samples of fewer hardly vary: an interval of them says too little


def resamples(families: Sequence[str], rng: np.random.Generator, n: int = N_RESAMPLE) -> Array:
    """How often each instance stands in each sample, (n, n_instance)."""
    names = np.asarray(families)
    counts = np.zeros((n, len(names)))
    for family in dict.fromkeys(families):
        mine = np.flatnonzero(names == family)
        counts[:, mine] = rng.multinomial(len(mine), np.full(len(mine), 1 / len(mine)), size=n)
    return counts


def interval(draws: Array) -> Array:
    """Percentile interval of samples (n, …), as (2, …); values of samples themselves, so that infinite ones may stand among
    them."""
    ends = (1 - LEVEL) / 2, (1 + LEVEL) / 2
    return np.asarray(np.quantile(draws, ends, axis=0, method="inverted_cdf"))


def interval_of_shares(shares: Array, draws: Array, n_instance: int) -> Array:
    """Interval (2, …) of shares (…) whose samples are (n, …). Samples of what is 0 or 1 on every instance do not vary: there
    it is Wilson's, of as many draws as there are instances."""
    none, all_of_them = (interval_of_rate(count, n_instance) for count in (0, n_instance))
    low, high = interval(draws)
    return np.array([np.where(shares == 1, all_of_them[0], low), np.where(shares == 0, none[1], high)])
