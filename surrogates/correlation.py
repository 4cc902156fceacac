"""Correlation functions R(θ, u, v), products over the coordinates of a function of θ_k (u_k − v_k)².

θ_k is an inverse squared length in the unit cube for both of them, so that limits of θ mean the same for either.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ksmea.arrays import Array, Indices


@dataclass(frozen=True)
class SamplePairs:
    """Pairs i < j of samples, which determine a symmetric matrix (n, n) but for its diagonal."""

    n: int
    places: Indices  # (n_pair,) above the diagonal of a matrix, counted row after row
    squared: Array  # (d, n_pair) (u_ik − u_jk)²

    @classmethod
    def of(cls, samples: Array) -> SamplePairs:
        """Pairs of samples (n, d)."""
        n, columns = len(samples), samples.T
        first, second = np.triu_indices(n, k=1)
        return cls(n, first * n + second, (columns[:, first] - columns[:, second]) ** 2)

    def upper(self, values: Array) -> Array:
        """Upper triangle (n, n) with values (n_pair,), zeros elsewhere."""
        matrix = np.zeros(self.n**2)
        matrix[self.places] = values
        return matrix.reshape(self.n, self.n)

    def values(self, matrix: Array) -> Array:
        """(n_pair,) of a matrix (n, n)."""
        return matrix.ravel()[self.places]


class Correlation(ABC):
    """A correlation function, its values among samples and their slope with respect to ln θ."""

    @abstractmethod
    def among(self, theta: Array, squared: Array) -> Array:
        """θ (d,) and squared differences (d, n_pair) → R_ij of each pair (n_pair,)."""

    @abstractmethod
    def log_slope(self, theta: Array, squared: Array, weight: Array) -> Array:
        """Σ weight ∂ln R_ij / ∂ln θ_k over pairs, (d,); the caller has put R_ij into the weight (n_pair,)."""

    @abstractmethod
    def between(self, theta: Array, points: Array, samples: Array) -> Array:
        """Rows r(u)ᵀ of eq. (17) for points (k, d) and samples (n, d) → (k, n)."""

    def rows(self, theta: Array, samples: Array) -> Callable[[Array], Array]:
        """`between` as a function of the points alone, for samples that many points are compared with."""
        return partial(self.between, theta, samples=samples)


class Gaussian(Correlation):
    """R = exp(−Σ_k θ_k h_k²), eq. (11) as DACE reads it."""

    def among(self, theta: Array, squared: Array) -> Array:
        exponent: Array = -theta @ squared
        return np.exp(exponent, out=exponent)

    def log_slope(self, theta: Array, squared: Array, weight: Array) -> Array:
        return -theta * (squared @ weight)

    def between(self, theta: Array, points: Array, samples: Array) -> Array:
        return self.rows(theta, samples)(points)

    def rows(self, theta: Array, samples: Array) -> Callable[[Array], Array]:
        # −‖a − b‖² = 2 aᵀb − ‖a‖² − ‖b‖² as one matrix product; centred, so that little cancels in it.
        centre, root = samples.mean(axis=0), np.sqrt(theta)
        b = root * (samples - centre)
        return partial(_gaussian, centre, root, np.column_stack([b, np.ones(len(b)), np.sum(b**2, axis=1)]))


def _gaussian(centre: Array, root: Array, right: Array, points: Array) -> Array:
    """Rows of `Gaussian` for points (k, d), from what samples alone determine."""
    a = root * (points - centre)
    left = np.empty((len(a), right.shape[1]))
    left[:, :-2] = 2 * a
    left[:, -2] = -np.sum(a**2, axis=1)
    left[:, -1] = -1.0
    exponent: Array = left @ right.T
    return np.exp(exponent, out=exponent)


class Matern52(Correlation):
    """R = Π_k (1 + a_k + a_k²/3) exp(−a_k), a_k = √(5 θ_k) |h_k|.

    With θ = 1/ℓ² it is the Matérn 5/2 of DiceKriging (Roustant, Ginsbourger & Deville 2012, doi 10.18637/jss.v051.i01).
    """

    def among(self, theta: Array, squared: Array) -> Array:
        a = np.sqrt(5 * theta[:, None] * squared)
        return np.prod(1 + a + a**2 / 3, axis=0) * np.exp(-a.sum(axis=0))

    def log_slope(self, theta: Array, squared: Array, weight: Array) -> Array:
        # with g = (1 + a + a²/3) e^(−a): dg/da = −a (1 + a)/3 e^(−a) and da/dln θ = a/2
        a = np.sqrt(5 * theta[:, None] * squared)
        slope = -(a**2) / 6 * (1 + a) / (1 + a + a**2 / 3)
        return slope @ weight

    def between(self, theta: Array, points: Array, samples: Array) -> Array:
        polynomial = np.ones((len(points), len(samples)))
        exponent = np.zeros_like(polynomial)
        for k, root in enumerate(np.sqrt(5 * theta)):
            a = root * np.abs(points[:, k, None] - samples[:, k])
            polynomial *= 1 + a + a**2 / 3
            exponent -= a
        return polynomial * np.exp(exponent, out=exponent)


CORRELATIONS: dict[str, Correlation] = {"gaussian": Gaussian(), "matern52": Matern52()}
