"""Which methods differ by more than chance: paired tests over instances.

Friedman's test asks whether any do. Then each pair is tested by Wilcoxon's signed-rank test, zero differences split between both
sides, and the p values are corrected by Holm's procedure (Demšar, J. Mach. Learn. Res. 7 (2006) 1–30). Nemenyi's test of mean
ranks is not used: whether it tells two methods apart depends on which others take part (Benavoli, Corani & Mangili, J. Mach.
Learn. Res. 17 (2016) 1–10).

Scores (n_instance, n_method) are lower for better; infinite where a method has nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
import scipy

from ksmea.arrays import Array

LEVEL = 0.05  # of all pairs together, below which two methods are told apart
LEAST_METHODS = 3  # that Friedman's test compares


@dataclass(frozen=True)
class Friedman:
    """χ² (corrected for ties) with n_method − 1 degrees of freedom; not a number if it does not apply."""

    chi2: float
    p: float


def friedman(scores: Array) -> Friedman:
    """Friedman's test of whether all methods rank alike."""
    n_method = np.shape(scores)[1]
    if n_method < LEAST_METHODS:
        return Friedman(np.nan, np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        found = scipy.stats.friedmanchisquare(*np.transpose(scores))
    if np.isnan(found.statistic):  # all tie everywhere
        return Friedman(0.0, 1.0)
    return Friedman(float(found.statistic), float(found.pvalue))


def pairs_frame(scores: Array, methods: Sequence[str]) -> pd.DataFrame:
    """A row per pair: instances on which the first is better, worse or alike; whether the two differ.

    `p` is Wilcoxon's, `p_holm` its correction by Holm; `told_apart` says whether the latter is below `LEVEL`.
    """
    rows = []
    for one, other in combinations(range(len(methods)), 2):
        difference = _difference(scores[:, one], scores[:, other])
        better, worse = int(np.sum(difference < 0)), int(np.sum(difference > 0))
        rows.append(
            {
                "method": methods[one],
                "other": methods[other],
                "better": better,
                "worse": worse,
                "alike": len(difference) - better - worse,
                "p": _wilcoxon(difference),
            }
        )
    frame = pd.DataFrame(rows, columns=["method", "other", "better", "worse", "alike", "p"])
    frame["p_holm"] = holm(frame["p"].to_numpy(float))
    frame["told_apart"] = frame["p_holm"] < LEVEL
    return frame


def _difference(one: Array, other: Array) -> Array:
    """one − other; where both have nothing they are alike."""
    with np.errstate(invalid="ignore"):
        return np.where(one == other, 0.0, one - other)


def _wilcoxon(difference: Array) -> float:
    if not np.any(difference):
        return 1.0
    return float(scipy.stats.wilcoxon(difference, zero_method="zsplit").pvalue)


def holm(p: Array) -> Array:
    """p values (n,) corrected for all of them together (Holm, Scand. J. Stat. 6 (1979) 65–70).

    >>> holm(np.array([0.01, 0.04, 0.03])).round(3)
    array([0.03, 0.06, 0.06])
    """
    order = np.argsort(p)
    corrected = np.empty(len(p))
    corrected[order] = np.minimum(np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1)), 1.0)
    return corrected


def cliques(ordered: Sequence[str], pairs: pd.DataFrame) -> list[tuple[str, ...]]:
    """Longest stretches of methods, ordered by mean rank, in which no pair differs significantly."""
    apart = {frozenset(pair) for pair in pairs.loc[pairs["told_apart"], ["method", "other"]].itertuples(index=False)}
    found: list[tuple[int, int]] = []
    for first in range(len(ordered)):
        last = first
        while last + 1 < len(ordered) and all(
            frozenset((ordered[last + 1], other)) not in apart for other in ordered[first : last + 1]
        ):
            last += 1
        if last > first and not (found and last <= found[-1][1]):
            found.append((first, last))
    return [tuple(ordered[first : last + 1]) for first, last in found]
