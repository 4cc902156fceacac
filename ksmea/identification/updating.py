"""Updating of a surrogate: expected improvement of the next sample; measures of the stopping rules.

Expected improvement of a sum of squares whose terms a surrogate predicts, as in target vector estimation (A. K. Uhrenholt and
B. S. Jensen, Efficient Bayesian optimization for target vector estimation, PMLR 89 (2019) 2661–2670): a surrogate that predicts
residuals r_i ~ N(m_i, v_i) makes the misfit Q = Σ r_i² a non-central χ², weighted if the v_i differ, and a true evaluation gains
max(T − Q, 0) with T the lowest misfit known. They take equal v_i and approximate the distribution by a power of a Gaussian. Here
the v_i are kept, and the expectation comes from the saddlepoint of Q, which is as good far out in the tail: that is where nearly
all of a search is.

The measures (SMC and SDF) are evaluated over the data (n_speed, n_channel) at the surrogate's optimum.
"""

from __future__ import annotations

import numpy as np
from scipy.special import erfcx, ndtr

from ksmea.arrays import Array, ComplexArray

LEAST = 1e-12  # of variances and of T, in units of the noise: keeps the saddlepoint of what is exact finite
STEPS = 60  # of Newton's iteration; 5 to 10 are usual
FAR = 1e3  # from where the tail expectation is taken from its series, which rounding would else eat up


def log_expected_improvement(mean: Array, variance: Array, lowest: float) -> Array:
    """Logarithm of the expected improvement, ln E[max(T − Q, 0)], (k,).

    Q = Σ r_i², r_i ~ N(m_i, v_i) independent, for m and v (k, m) and T > 0.

    Below the mean of Q the density is tilted by e^(−sQ) so that its mean is T, and Gaussian then (Daniels 1954,
    doi 10.1214/aoms/1177728652; of quadratic forms: Kuonen 1999, doi 10.1093/biomet/86.4.929):

    E = exp(K(−s) + s T) σ (φ(0) − w e^(w²/2) Φ(−w)), K′(−s) = T, σ² = K″(−s), w = s σ,

    with K the cumulant generating function. Above the mean Q is taken for Gaussian.

    >>> improvement = log_expected_improvement(np.zeros((1, 20)), np.ones((1, 20)), 10.0)
    >>> f"{np.exp(improvement[0]):.3f}"  # of χ² with 20 degrees of freedom; exact: 0.044
    '0.039'
    """
    variance = np.maximum(variance, LEAST)
    expected = np.sum(mean**2 + variance, axis=1)
    improvement = np.empty(len(mean))
    below = lowest < expected
    improvement[below] = _log_tail(mean[below] ** 2, variance[below], lowest)
    sd = np.sqrt(np.sum(2 * variance[~below] ** 2 + 4 * variance[~below] * mean[~below] ** 2, axis=1))
    z = (lowest - expected[~below]) / sd
    improvement[~below] = np.log(sd * (z * ndtr(z) + np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)))
    return improvement


def improvement_residual(mean: Array, variance: Array, lowest: float) -> Array:
    """√(ln T − ln E), (k, 1): a residual whose square is least where the expected improvement is largest.

    E is below T, as no misfit is below 0; a prediction that is not a number stays one.
    """
    lowest = max(lowest, LEAST)
    shortfall = np.log(lowest) - log_expected_improvement(mean, variance, lowest)
    return np.asarray(np.sqrt(np.maximum(shortfall, 0.0))[:, None])


def _log_tail(squared: Array, variance: Array, lowest: float) -> Array:
    """The tilted expectation for m² and v (k, m) with T below the mean of Q."""
    tilt = _tilt(squared, variance, lowest)[:, None]
    shrunk = 1.0 + 2.0 * tilt * variance
    exponent = np.sum(-0.5 * np.log(shrunk) - tilt * squared / shrunk, axis=1) + tilt[:, 0] * lowest
    sd = np.sqrt(np.sum(2 * (variance / shrunk) ** 2 + 4 * variance * squared / shrunk**3, axis=1))
    w = tilt[:, 0] * sd
    tail = np.where(w > FAR, w**-2.0, 1.0 - w * np.sqrt(np.pi / 2) * erfcx(w / np.sqrt(2))) / np.sqrt(2 * np.pi)
    return np.asarray(exponent + np.log(sd * tail))


def _tilt(squared: Array, variance: Array, lowest: float) -> Array:
    """Tilt s ≥ 0 with K′(−s) = Σ v/(1 + 2sv) + m²/(1 + 2sv)² = T, (k,).

    It is found by Newton's method on K′^(−1/2), which is straight if one term rules and concave otherwise: steps from s
    = 0 never pass the root.
    """
    tilt = np.zeros(len(squared))
    for _ in range(STEPS):
        shrunk = 1.0 + 2.0 * tilt[:, None] * variance
        first = np.sum(variance / shrunk + squared / shrunk**2, axis=1)
        second = np.sum(2 * (variance / shrunk) ** 2 + 4 * variance * squared / shrunk**3, axis=1)
        step = 2 * first / second * (np.sqrt(first / lowest) - 1.0)
        tilt = np.maximum(tilt + step, 0.0)
        if np.all(np.abs(step) <= 1e-10 * tilt):
            break
    return tilt


def squared_multiple_correlation(
    predicted: Array | ComplexArray, modelled: Array | ComplexArray, measured: Array | ComplexArray
) -> float:
    """SMC = 1 − Σ |ŷ − y_FE|² / Σ |y_FE − y_measured|², eq. (23).

    It compares the surrogate's error with the residual, so it is not a measure of fit. Without noise both sums go to
    zero together. If the true model meets the data exactly, the ratio is not defined, and −inf leaves the decision
    to SDF.

    >>> squared_multiple_correlation(np.array([1.1]), np.array([1.0]), np.array([2.0]))
    0.99
    """
    residual = float(np.sum(np.abs(modelled - measured) ** 2))
    if residual == 0:
        return -np.inf
    return 1 - float(np.sum(np.abs(predicted - modelled) ** 2)) / residual


def simple_difference(predicted: Array | ComplexArray, modelled: Array | ComplexArray) -> float:
    """SDF = Σ |ŷ − y_FE|, eq. (24), m."""
    return float(np.sum(np.abs(predicted - modelled)))
