"""Mean ranks over instances, how sure they are, and whether both halves of the seeds say the same.

Scores (n_instance, n_method) are lower for better; methods that tie share their mean rank.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from bench.reports.contest.resampling import interval
from ksmea.arrays import Array

DIGITS = 9  # of mean ranks, beyond which they differ by rounding


@dataclass(frozen=True)
class Ranking:
    """By method: mean rank, its interval (2, n_method), and the share of samples of instances in which it is the first."""

    mean: Array
    ends: Array
    first: Array


@dataclass(frozen=True)
class Agreement:
    """Kendall's τ between the rankings of two halves with its interval; not a number where there is one method or half."""

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
    """Kendall's τ-b (Biometrika 33 (1945) 239–251) between the mean ranks of two scores of the same instances and methods."""
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
    """τ-b (n,) of each pair of rows (n, n_method): of all pairs, agreeing less disagreeing ones over those that do not tie."""
    signs = [np.sign(np.round(each[:, :, None] - each[:, None], DIGITS)) for each in (one, other)]
    untied = [np.sum(each**2, axis=(1, 2)) for each in signs]
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sum(signs[0] * signs[1], axis=(1, 2)) / np.sqrt(untied[0] * untied[1]))
