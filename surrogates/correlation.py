"""Correlation functions R(θ, u, v), products over the coordinates of a function of θ_k (u_k − v_k)².

θ_k is an inverse squared length in the unit cube for both of them, so that limits of θ mean the same for either.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial

import numpy as np

from ksmea.arrays import Array


def squared_differences(samples: Array) -> Array:
    """Samples (n, d) → (u_ik − u_jk)², (d, n, n)."""
    columns = samples.T
    return (columns[:, :, None] - columns[:, None, :]) ** 2


class Correlation(ABC):
    """A correlation function, its matrix among samples and its slope with respect to ln θ."""

    @abstractmethod
    def among(self, theta: Array, squared: Array) -> Array:
        """θ (d,) and squared differences (d, n, n) → R (n, n)."""

    @abstractmethod
    def log_slope(self, theta: Array, squared: Array, weight: Array) -> Array:
        """Σ_ij weight_ij ∂ln R_ij / ∂ln θ_k, (d,); the caller has put R_ij into the weight (n, n)."""

    @abstractmethod
    def between(self, theta: Array, points: Array, samples: Array) -> Array:
        """Rows r(u)ᵀ of eq. (17) for points (k, d) and samples (n, d) → (k, n)."""

    def rows(self, theta: Array, samples: Array) -> Callable[[Array], Array]:
        """`between` as a function of the points alone, for samples that many points are compared with."""
        return partial(self.between, theta, samples=samples)


class Gaussian(Correlation):
    """R = exp(−Σ_k θ_k h_k²), eq. (11) as DACE reads it."""

    def among(self, theta: Array, squared: Array) -> Array:
        exponent = np.tensordot(-theta, squared, axes=1)
        return np.exp(exponent, out=exponent)

    def log_slope(self, theta: Array, squared: Array, weight: Array) -> Array:
        return -theta * (squared.reshape(len(theta), -1) @ weight.ravel())

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
        a = np.sqrt(5 * theta[:, None, None] * squared)
        return np.prod(1 + a + a**2 / 3, axis=0) * np.exp(-a.sum(axis=0))

    def log_slope(self, theta: Array, squared: Array, weight: Array) -> Array:
        # with g = (1 + a + a²/3) e^(−a): dg/da = −a (1 + a)/3 e^(−a) and da/dln θ = a/2
        a = np.sqrt(5 * theta[:, None, None] * squared)
        slope = -(a**2) / 6 * (1 + a) / (1 + a + a**2 / 3)
        return np.tensordot(slope, weight, axes=2)

    def between(self, theta: Array, points: Array, samples: Array) -> Array:
        polynomial = np.ones((len(points), len(samples)))
        exponent = np.zeros_like(polynomial)
        for k, root in enumerate(np.sqrt(5 * theta)):
            a = root * np.abs(points[:, k, None] - samples[:, k])
            polynomial *= 1 + a + a**2 / 3
            exponent -= a
        return polynomial * np.exp(exponent, out=exponent)


CORRELATIONS: dict[str, Correlation] = {"gaussian": Gaussian(), "matern52": Matern52()}
