"""Trend of a Kriging model: the polynomial f(u)ᵀβ that the correlated departures are added to, eq. (9)."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError

DEGREES = {"constant": 0, "linear": 1, "quadratic": 2}


def n_terms(name: str, d: int) -> int:
    """Number of terms p of the full polynomial, cross terms included.

    >>> [n_terms(name, 5) for name in ("constant", "linear", "quadratic")]
    [1, 6, 21]
    """
    return comb(d + DEGREES[name], d)


@dataclass(frozen=True)
class Trend:
    """Polynomial terms in coordinates that run over [-1, 1] on the samples.

    The affine change of coordinates leaves the span of the terms, and so every prediction, as it is; it keeps F well
    conditioned where the samples fill a small part of the unit cube.
    """

    name: str
    centre: Array  # (d,)
    half_width: Array  # (d,)

    def terms(self, u: Array) -> Array:
        """Points (k, d) → rows f(u)ᵀ (k, p), ordered 1, v_1 … v_d, v_1², v_1 v_2 … v_d²."""
        v = (u - self.centre) / self.half_width
        k, d = v.shape
        terms = np.empty((k, n_terms(self.name, d)))
        terms[:, 0] = 1.0
        if DEGREES[self.name] >= 1:
            terms[:, 1 : d + 1] = v
        if DEGREES[self.name] == 2:
            first = d + 1
            for i in range(d):
                terms[:, first : first + d - i] = v[:, i : i + 1] * v[:, i:]
                first += d - i
        return terms


def trend_over(name: str, samples: Array) -> Trend:
    """The trend with its coordinates fitted to samples (n, d), after a check that these determine it."""
    n, d = samples.shape
    lower, upper = samples.min(axis=0), samples.max(axis=0)
    half_width = np.where(upper > lower, (upper - lower) / 2, 1.0)
    trend = Trend(name, (lower + upper) / 2, half_width)
    rank, p = np.linalg.matrix_rank(trend.terms(samples)), n_terms(name, d)
    if rank < p:
        raise SettingError(
            f"a {name} trend has {p} terms and the {n} samples determine {rank} of them:"
            f" spread the samples over all {d} directions, or try a trend of lower degree"
        )
    return trend
