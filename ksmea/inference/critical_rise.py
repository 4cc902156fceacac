"""How far the deviance may rise within an interval: the quantile of what it is higher at the truth than at its minimum.

Around one maximum that is χ² with one degree of freedom, or, where the noise is estimated along, n ln(1 + F/(n − d)) with
F(1, n − d) from n residuals and d unknowns, which is exact for a linear model.

Where the likelihood has several maxima, the truth's need not be the highest. With δ the difference of the mean at another
maximum, in units of the noise, less what the unknowns there can make up for, and standard normal noise ε, the deviance of
the other one is |δ|² + 2 ε·δ above that of the truth's: where this is negative, the rise at the truth is larger by as much.
δ is orthogonal to all that moves the first part of the rise, so that the two are independent. The best maximum stands in
for the truth's.

D. M. Bates and D. G. Watts, Nonlinear Regression Analysis and Its Applications (Wiley, 1988), chapter 6,
doi 10.1002/9780470316757; models that are not nested, one to be chosen: D. R. Cox, J. R. Stat. Soc. B 24 (1962) 406–424,
doi 10.1111/j.2517-6161.1962.tb00468.x.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from scipy.optimize import brentq

from ksmea.arrays import Array
from ksmea.likelihood.fisher import Point, projected
from ksmea.likelihood.likelihood import Likelihood
from ksmea.numerics.screening import sobol

N_NORMAL = 4096  # normal draws, of a Sobol' sequence: the level is met within 0.1 %
HIGHEST = 100.0  # rise that is looked for


def critical_rise(likelihood: Likelihood, level: float, maxima: Sequence[Point] = ()) -> float:
    """The rise of the deviance at the ends of an interval of confidence `level`; `maxima` are all that are known, best first."""
    alone = linear_rise(likelihood, level)
    excess = _excess(likelihood, maxima)

    def too_likely(rise: float) -> float:
        return float(np.mean(_tail(likelihood, rise - excess))) - (1 - level)

    return float(brentq(too_likely, alone, HIGHEST)) if np.isfinite(alone) and too_likely(alone) > 0 else alone


def linear_rise(likelihood: Likelihood, level: float) -> float:
    """The same for one maximum of a linear model."""
    n, left = likelihood.n_residual, likelihood.n_residual - likelihood.d
    if not likelihood.noise_is_estimated:
        return float(scipy.stats.chi2.ppf(level, 1))
    return float(n * np.log1p(scipy.stats.f.ppf(level, 1, left) / left)) if left > 0 else np.inf


def _tail(likelihood: Likelihood, rise: Array) -> Array:
    """The chance of a larger rise around one maximum."""
    n, left = likelihood.n_residual, likelihood.n_residual - likelihood.d
    if not likelihood.noise_is_estimated:
        return np.asarray(scipy.stats.chi2.sf(rise, 1))
    return np.asarray(scipy.stats.f.sf(left * np.expm1(rise / n), 1, left))


def _excess(likelihood: Likelihood, maxima: Sequence[Point]) -> Array:
    """How much higher the deviance of the first of some maxima is than that of the best, in draws of the noise (n,), were the
    first the truth's."""
    if len(maxima) < 2:
        return np.zeros(1)
    differences = _differences(likelihood, *maxima)  # (n_other, m)
    triangle = np.linalg.qr(differences.T, mode="r")  # (k, n_other); δᵀδ' is that of its columns
    normal = scipy.stats.norm.ppf(sobol(N_NORMAL, len(triangle)) + 0.5 / N_NORMAL)
    rise = np.sum(differences**2, axis=1) + 2 * normal @ triangle
    return np.asarray(np.maximum(-np.min(rise, axis=1), 0.0))


def _differences(likelihood: Likelihood, best: Point, *others: Point) -> Array:
    """δ of other maxima (n_other, m)."""
    d = likelihood.d
    mean, *means = likelihood.model.response(np.array([point.theta[:d] for point in (best, *others)]))
    away = [likelihood.whitened_difference(other, mean, best.theta)[:, None] for other in means]
    return np.array([projected(delta, point.whitened[: len(delta), :d])[:, 0] for delta, point in zip(away, others)])
