"""Mean ranks over instances with bootstrap intervals, and agreement between both halves of the seeds.

Scores (n_instance, n_method) are lower for better; tied methods share their mean rank.

Instances are drawn with replacement within each family, so that every family keeps its weight, and jointly for all methods, so
that they stay paired. Repetitions are not drawn: they belong to their instance. Percentile intervals: Efron & Tibshirani, An
Introduction to the Bootstrap, 1993, ch. 13.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from bench.reports.tables import interval as interval_of_rate
from ksmea.arrays import Array

DIGITS = 9  # of mean ranks, beyond which they differ by rounding


@dataclass(frozen=True)
class Ranking:
    """Mean rank, its interval (2, n_method) and share of first places of each method.

    The share is of samples of instances.
    """

    mean: Array
    ends: Array
    first: Array


@dataclass(frozen=True)
class Agreement:
    """Kendall's τ between the rankings of two halves with its interval.

    Not a number where there is one method or half.
    """

    tau: float
    low: float
    high: float


def ranks(scores: Array) -> Array:
    """Ranks (n_instance, n_method) from 1, ties shared."""
    return np.asarray(scipy.stats.rankdata(scores, axis=1))


def ranking(scores: Array, weights: Array) -> Ranking:
    """Mean ranks, and what they are on samples of the instances, `weights` (n, n_instance)."""
    of_instance = ranks(scores)
    draws = _means(of_instance, weights)
    first = np.isclose(draws, draws.min(axis=1, keepdims=True))
    return Ranking(of_instance.mean(axis=0), interval(draws), np.mean(first / first.sum(axis=1, keepdims=True), axis=0))


def agreement(one: Array, other: Array, weights: Array) -> Agreement:
    """Kendall's τ-b between the mean ranks of two scores of the same instances and methods.

    Source: Biometrika 33 (1945) 239–251.
    """
    if np.shape(one)[1] < 2 or not len(one) or not len(weights):
        return Agreement(np.nan, np.nan, np.nan)
    halves = ranks(one), ranks(other)
    taus = _tau(*(_means(half, weights) for half in halves))
    low, high = interval(taus[np.isfinite(taus)]) if np.isfinite(taus).any() else (np.nan, np.nan)
    [tau] = _tau(*(half.mean(axis=0, keepdims=True) for half in halves))
    return Agreement(float(tau), float(low), float(high))


def _means(of_instance: Array, weights: Array) -> Array:
    return np.asarray(weights @ of_instance / weights.sum(axis=1, keepdims=True))


def _tau(one: Array, other: Array) -> Array:
    """Kendall's τ-b (n,) of each pair of rows (n, n_method).

    Concordant less discordant pairs of methods, over the geometric mean of the numbers of untied pairs in both rows.
    """
    signs = [np.sign(np.round(each[:, :, None] - each[:, None], DIGITS)) for each in (one, other)]
    untied = [np.sum(each**2, axis=(1, 2)) for each in signs]
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sum(signs[0] * signs[1], axis=(1, 2)) / np.sqrt(untied[0] * untied[1]))


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
    """Percentile interval of samples (n, …), as (2, …).

    Values of samples themselves, so that infinite ones may stand among them.
    """
    ends = (1 - LEVEL) / 2, (1 + LEVEL) / 2
    return np.asarray(np.quantile(draws, ends, axis=0, method="inverted_cdf"))


def interval_of_shares(shares: Array, draws: Array, n_instance: int) -> Array:
    """Interval (2, …) of shares (…) whose samples are (n, …).

    Samples of what is 0 or 1 on every instance do not vary: there it is Wilson's, of as many draws as there are
    instances.
    """
    none, all_of_them = (interval_of_rate(count, n_instance) for count in (0, n_instance))
    low, high = interval(draws)
    return np.array([np.where(shares == 1, all_of_them[0], low), np.where(shares == 0, none[1], high)])
