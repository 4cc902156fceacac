"""Critical rise of the deviance within an interval.

It is the quantile of the excess of the deviance at the true values over its minimum.

Around one maximum the rise is χ² with one degree of freedom, or, if the noise is also estimated, n ln(1 + F/(n − d)) with
F(1, n − d) from n residuals and d unknowns, which is exact for a linear model.

If the likelihood has several maxima, the truth's need not be the highest. With δ the difference of the mean at another
maximum, in units of the noise, less what the unknowns there can make up for, and standard normal noise ε, the deviance of
the other one is |δ|² + 2 ε·δ above the deviance of the truth's: if this is negative, the rise at the truth is larger by as much.
δ is orthogonal to all that moves the first part of the rise, so that the two are independent. The best maximum stands in
for the truth's.

If data can be simulated some thousand times, the likelihood ratio is calibrated by a parametric bootstrap instead, for each
unknown and around each maximum. Data are simulated at a maximum, with noise of the level that it has there, corrected for the
degrees of freedom. The rise of an unknown is the deviance of such data where it has the value that they were simulated at, all
others fitted, less the lowest deviance of all. Fits start from every maximum that the measured data have, so that the quantile
of the rise counts the curvature of the model, the limits of the search, and how often data of this maximum prefer another.

Few simulations know a quantile poorly. Of a model that is linear the rises of the same noise are known, and so is their
quantile. The mean of the highest simulated rises, over the mean of the highest linear ones, is the factor that it is taken by
(Bartlett's factor, but for the tail alone).

D. M. Bates and D. G. Watts, Nonlinear Regression Analysis and Its Applications (Wiley, 1988), chapter 6,
doi 10.1002/9780470316757; models that are not nested, one to be chosen: D. R. Cox, J. R. Stat. Soc. B 24 (1962) 406–424,
doi 10.1111/j.2517-6161.1962.tb00468.x; A. C. Davison and D. V. Hinkley, Bootstrap Methods and their Application (Cambridge, 1997),
sections 4.2 and 5.4 (tests and intervals by simulated likelihood ratios) and 9.3 (control variates), doi 10.1017/CBO9780511802843.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from scipy.optimize import brentq

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.inference.batched_maxima import BatchedLikelihood, Fits, batched_maxima
from ksmea.likelihood.fisher import Point, projected, span
from ksmea.likelihood.likelihood import Likelihood
from ksmea.numerics.screening import sobol

N_NORMAL = 4096  # normal draws, of a Sobol' sequence: the level is met within 0.1 %
HIGHEST = 100.0  # rise that is looked for


def critical_rise(likelihood: Likelihood, level: float, maxima: Sequence[Point] = ()) -> float:
    """The rise of the deviance at the ends of an interval of confidence `level`.

    `maxima` are all that are known, best first.
    """
    alone = linear_rise(likelihood, level)
    excess = _excess(likelihood, maxima)

    def too_likely(rise: float) -> float:
        return float(np.mean(_tail(likelihood, rise - excess))) - (1 - level)

    return float(brentq(too_likely, alone, HIGHEST)) if np.isfinite(alone) and too_likely(alone) > 0 else alone


def linear_rise(likelihood: Likelihood, level: float) -> float:
    """Critical rise for a single maximum of a linear model."""
    n, left = likelihood.n_residual, likelihood.n_residual - likelihood.n_free
    if not likelihood.noise_is_estimated:
        return float(scipy.stats.chi2.ppf(level, 1))
    return float(n * np.log1p(scipy.stats.f.ppf(level, 1, left) / left)) if left > 0 else np.inf


def _tail(likelihood: Likelihood, rise: Array) -> Array:
    """The chance of a larger rise around one maximum."""
    n, left = likelihood.n_residual, likelihood.n_residual - likelihood.n_free
    if not likelihood.noise_is_estimated:
        return np.asarray(scipy.stats.chi2.sf(rise, 1))
    return np.asarray(scipy.stats.f.sf(left * np.expm1(rise / n), 1, left))


def _excess(likelihood: Likelihood, maxima: Sequence[Point]) -> Array:
    """Excess of the deviance of the first maximum over the best, in noise realisations (n,).

    The first is assumed to belong to the true values.
    """
    if len(maxima) < 2:
        return np.zeros(1)
    differences = _differences(likelihood, *maxima)  # (n_other, m)
    triangle = np.linalg.qr(differences.T, mode="r")  # (k, n_other); δᵀδ' is that of its columns
    normal = scipy.stats.norm.ppf(sobol(N_NORMAL, len(triangle)) + 0.5 / N_NORMAL)
    rise = np.sum(differences**2, axis=1) + 2 * normal @ triangle
    return np.asarray(np.maximum(-np.min(rise, axis=1), 0.0))


def _differences(likelihood: Likelihood, best: Point, *others: Point) -> Array:
    """δ of other maxima (n_other, m)."""
    d, parameters = likelihood.d, likelihood.model.problem.parameters
    mean, *means = likelihood.model.response(np.array([point.theta[:d] for point in (best, *others)]))
    found = []
    for point, other in zip(others, means):
        of_means = likelihood.whitened_difference(other, mean, best.theta)
        of_priors = parameters.off_priors(point.theta) - parameters.off_priors(best.theta)
        rows = np.r_[: len(of_means), len(point.whitened) - len(of_priors) : len(point.whitened)]
        found.append(projected(np.concatenate([of_means, of_priors])[:, None], point.whitened[rows, :d])[:, 0])
    return np.array(found)


N_SIMULATED = 64  # data sets at each maximum
HIGHEST_LEVEL = 0.95  # to which so many know the factor; above it is the same
TAIL = 3.0  # times the chance of a larger rise: the share of the rises whose mean is taken
LEAST = 0.5  # of the rise of a linear model: less is not taken, and rises below it need not be exact
REACH = 12.0  # of the deviance above the lowest: maxima beyond are left out, since hardly a rise is as large
ALIKE = 0.02  # differences of deviances that do not matter
MAX_ROUNDS = 3  # of fits, each from where an unknown that was held led lower than was known


def can_be_simulated(likelihood: Likelihood) -> bool:
    """Whether data can be simulated and fitted some thousand times.

    Not if differences between runs are compared, if there are no residual degrees of freedom, if responses may be
    costly, as without a sensitivity or for new values of some unknowns, or if some unknowns have priors.
    """
    problem = likelihood.model.problem
    is_cheap = problem.has_sensitivity and not (len(problem.costly) or len(problem.parameters.with_prior))
    return is_cheap and likelihood.n_residual > likelihood.d and not likelihood.measurement.is_by_differences


def simulated_rise(likelihood: Likelihood, level: float, maxima: Sequence[Point], rng: np.random.Generator) -> Array:
    """Rise of the deviance at the ends of intervals of confidence `level`, by maximum and unknown.

    It is (n, d), of the n maxima, highest first, that are within `REACH` of the highest. Raises `LinAlgError` if a fit
    meets no finite response.
    """
    near = [point for point in maxima if point.deviance < maxima[0].deviance + REACH]
    normal = scipy.stats.norm.ppf(sobol(N_SIMULATED, likelihood.n_residual, rng))
    factors = [_factor(likelihood, min(level, HIGHEST_LEVEL), point, maxima, normal) for point in near]
    return linear_rise(likelihood, level) * np.array(factors)


def _factor(likelihood: Likelihood, level: float, point: Point, maxima: Sequence[Point], normal: Array) -> Array:
    """Ratio (d,) of the quantiles of the rises to the quantiles of a linear model.

    Data are simulated at one of some maxima from normal numbers (n_set, n).

    At a maximum near a search limit rises are smaller than at the values inside for which the interval is to hold: there it is 1
    at least.
    """
    truth = _unbiased(likelihood, point)
    at_truth = likelihood.at(truth)
    tangent = at_truth.whitened[: likelihood.n_residual, : likelihood.d]
    noise = normal @ np.linalg.qr(tangent, mode="complete")[0].T  # the first numbers move the unknowns
    starts = np.stack([truth, *(other.theta for other in maxima if other is not point)])
    data = BatchedLikelihood(likelihood, _simulated(likelihood, truth, noise))
    quantile = linear_rise(likelihood, level)
    rises = simulated_rises(data, starts, truth, likelihood.d, LEAST * quantile)
    linear = linear_rises(likelihood, tangent, noise)
    n_tail = int(np.ceil(min(TAIL * (1 - level), 1.0) * len(noise)))
    of_tail, of_linear = (np.mean(np.sort(each)[:, -n_tail:], axis=1) for each in (rises, linear))
    factors = of_tail / np.maximum(of_linear, np.finfo(float).tiny)
    return np.asarray(np.maximum(factors, 1.0 if _is_near_limit(likelihood, truth, tangent, quantile) else LEAST))


def _is_near_limit(likelihood: Likelihood, theta: Array, tangent: Array, rise: float) -> bool:
    """Whether the interval of any unknown at θ (p,) reaches its limit.

    The means are taken as linear with a tangent (n, d). An angle that is free to turn has no limit.
    """
    u, has_limit = theta[: likelihood.d], np.isinf(likelihood.period[: likelihood.d])
    away = np.minimum(u, 1 - u) * np.linalg.norm(_own(tangent), axis=0)
    return bool(np.any(away[has_limit] < np.sqrt(rise)))


def _unbiased(likelihood: Likelihood, point: Point) -> Array:
    """θ (p,) at a maximum, the noise corrected for the degrees of freedom that the fit took."""
    theta, n = point.theta.copy(), likelihood.n_residual
    theta[likelihood.d :] += 0.5 * np.log(n / (n - likelihood.n_free))
    return np.clip(theta, likelihood.lower, likelihood.upper)


def _simulated(likelihood: Likelihood, theta: Array, noise: Array) -> Array | ComplexArray:
    """Simulated data (n_set, n_speed, n_channel) at θ (p,) with noise (n_set, n).

    Noise is in units of its standard deviation, as rows of the information.
    """
    response = likelihood.model.response(theta[None, : likelihood.d])[0]
    sd = likelihood.noise(theta).sd(np.abs(response))
    shape = (len(noise), *response.shape)
    if likelihood.measurement.is_amplitude:
        return np.asarray(np.abs(np.abs(response) + sd * noise.reshape(shape)))
    real, imaginary = (part.reshape(shape) for part in np.split(noise, 2, axis=1))
    return np.asarray(response + sd * (real + 1j * imaginary) / np.sqrt(2))


def linear_rises(likelihood: Likelihood, tangent: Array, noise: Array) -> Array:
    """Rises (d, n_set) for noise (n_set, n), with means taken as linear with a tangent (n, d).

    Noise is in units of its standard deviation.
    """
    directions, own = span(tangent), _own(tangent)
    left = np.sum(noise**2, axis=1) - np.sum((noise @ directions) ** 2, axis=1)
    squared = (noise @ own).T ** 2 / np.maximum(np.sum(own**2, axis=0), np.finfo(float).tiny)[:, None]
    return np.asarray(likelihood.n_residual * np.log1p(squared / left) if likelihood.noise_is_estimated else squared)


def _own(tangent: Array) -> Array:
    """Part of each column of a tangent (n, d) orthogonal to the other columns.

    Its length is 1 / sd of the unknown.
    """
    parts = [projected(tangent[:, [index]], np.delete(tangent, index, axis=1)) for index in range(tangent.shape[1])]
    return np.concatenate(parts, axis=1)


def simulated_rises(likelihood: BatchedLikelihood, starts: Array, truth: Array, d: int, negligible: float) -> Array:
    """Excess of each data set's deviance with an unknown at its `truth` over the lowest, (d, n_set).

    `truth` is (p,). Fits start from `starts` (k, p). Rises below `negligible` are upper bounds.

    The unknown is held in fits from the truth, and from every maximum from which they can end lower than what is known. If one
    of them ends lower than all maxima, the next round starts there.
    """
    n = likelihood.n_set
    fits = batched_maxima(likelihood, np.repeat(starts, n, axis=0), np.tile(np.arange(n), len(starts)))
    lowest, held = np.full(n, np.inf), np.full((d, n), np.inf)
    theta = np.broadcast_to(truth, (d * n, len(truth)))
    fixed, sets, above = np.repeat(np.arange(d), n), np.tile(np.arange(n), d), np.full(d * n, -np.inf)
    for _ in range(MAX_ROUNDS):
        fits = fits.distinct(ALIKE)
        np.minimum.at(lowest, fits.sets, fits.deviance)
        unknown, row = (part.ravel() for part in np.indices((d, len(fits.sets))))
        theta = np.concatenate([theta, _held(likelihood, fits.part(row), unknown, truth[unknown])])
        fixed, sets = np.concatenate([fixed, unknown]), np.concatenate([sets, fits.sets[row]])
        above = np.concatenate([above, fits.deviance[row]])  # where no fit from there can end
        np.minimum.at(held, (fixed, sets), likelihood.deviance(theta, sets))
        known = held[fixed, sets]
        wanted = (known > lowest[sets] + negligible) & (known > above + ALIKE)
        if not np.any(wanted):
            break
        found = batched_maxima(likelihood, theta[wanted], sets[wanted], fixed[wanted])
        np.minimum.at(held, (fixed[wanted], found.sets), found.deviance)
        lower = found.part(np.flatnonzero(found.deviance < lowest[found.sets] - ALIKE)).distinct(np.inf)
        if not len(lower.sets):
            break
        fits = batched_maxima(likelihood, lower.theta, lower.sets)
        theta, fixed, sets, above = theta[:0], fixed[:0], sets[:0], above[:0]
    return np.asarray(held - lowest)


def _held(likelihood: BatchedLikelihood, fits: Fits, unknown: Indices, value: Array) -> Array:
    """Starts θ (k, p) of fits (k,) with an `unknown` (k,) held at a `value` (k,).

    Other unknowns are as they are, or along the tangent of the profile if that is better.
    """
    own = np.arange(fits.theta.shape[1]) == unknown[:, None]
    straight = np.where(own, value[:, None], fits.theta)
    step = (value - fits.theta[own])[:, None] * fits.tangents(unknown)
    along = fits.theta + np.clip(step, -likelihood.longest_step, likelihood.longest_step)
    along = np.where(own, value[:, None], np.clip(along, likelihood.lower, likelihood.upper))
    is_better = likelihood.deviance(along, fits.sets) < likelihood.deviance(straight, fits.sets)
    return np.where(is_better[:, None], along, straight)
