"""Fits of an effect along a path of its unknowns, and from screenings at values on it.

Rising rates of a sweep are such a path.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ksmea.arrays import Array
from ksmea.fits.fitting import START_DISTANCE, BaselineFits, Fit, maxima_from, start_nearby
from ksmea.fits.search import Effort
from ksmea.fits.starts import screened_at
from ksmea.fits.variable_projection import NOTHING, linear_unknowns, projected, unbalance_planes
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.noise import Noise
from ksmea.numerics.screening import sobol
from ksmea.problem.case import Case

PATH_ITERATIONS = 4  # of each fit on a path of values
FEW_VALUES = 8  # of unknowns that are costly to change
PROJECTED = 5  # times as many points as of a scan are screened by variable projection
LAST_DECADE = 0.1  # of the last value of a path, from where on its values are screened


def fit_along(case: Case, baseline: BaselineFits, path: Array, effort: Effort) -> Fit:
    """Fit of an effect from the best points on a path and of screenings.

    The path consists of fits at values (n, e) SI of the effect's unknowns, each from the end of the last one, the first from the
    fit of the baseline model. Of several unknowns each one without a prior then follows its part of the path alone, from the best
    point so far. Screenings are made at the values of the last decade; if all unknowns have priors, at the last ones. If several planes
    have unknown unbalance, one is made by variable projection too: a sweep has many maxima, and a screening at random unbalance misses
    the best ones.
    """
    likelihood, d = likelihood_of(case), baseline.best.likelihood.d
    e = path.shape[1]
    items = case.problem.parameters.items[d : d + e]
    lower, upper = np.array([[item.lower, item.upper] for item in items]).T
    values = (path - lower) / (upper - lower)
    points = _points_along(likelihood, start_nearby(case.problem, baseline.best), d, values)
    free = [column for column, item in enumerate(items) if item.prior is None]
    for column in free if e > 1 else []:
        theta = min(points, key=lambda point: point.deviance).theta
        alone = np.tile(theta[d : d + e], (len(values), 1))
        alone[:, column] = values[:, column]
        points += _points_along(likelihood, theta, d, alone)
    best = sorted(points, key=lambda point: point.deviance)[: effort.survivors]
    last = values[np.abs(path[:, 0]) >= LAST_DECADE * np.abs(path[-1, 0])] if free else values[-1:]
    screened = screened_at(case, baseline.screened.thinned(effort.scan), last)
    starts = [likelihood.start(u) for u in screened.apart(effort.starts, START_DISTANCE).points]
    points = [maximise(likelihood, point.theta, tolerance=1e-4) for point in best]
    points += maxima_from(likelihood, starts, effort)
    by_projection = [likelihood.start(u) for u in projected_starts(case, baseline.best.noise, d, effort, last)]
    if by_projection:
        points += maxima_from(likelihood, by_projection, dataclasses.replace(effort, survivors=len(by_projection)))
    return Fit(likelihood, min(points, key=lambda point: point.deviance))


def projected_starts(case: Case, noise: Noise, d: int, effort: Effort, values: Array | None = None) -> Array:
    """Points (n, d) of an extended problem from a screening by variable projection.

    The effect's unknowns from d on have values (m, e) if given. Empty for amplitudes, or unless several planes have
    unknown unbalance.
    """
    measurement, parameters = case.measurement, case.problem.parameters
    planes = unbalance_planes(case.problem)
    if measurement.is_amplitude or measurement.is_by_differences or not planes:
        return np.empty((0, len(parameters)))
    n = 2 ** (PROJECTED * effort.scan - 1).bit_length()
    points, linear = parameters.from_decades(sobol(n, len(parameters))), NOTHING
    costly = case.problem.costly
    points[:, costly] = np.rint(FEW_VALUES * points[:, costly]) / FEW_VALUES
    if values is None:
        linear = linear_unknowns(case.problem, np.arange(d, len(parameters)))
    else:
        points[:, d : d + values.shape[1]] = values[np.arange(n) % len(values)]
    return projected(case, noise, planes, points, linear).apart(effort.starts, START_DISTANCE).points


def _points_along(likelihood: Likelihood, theta: Array, d: int, values: Array) -> list[Point]:
    """Fits at values (n, e) in the unit cube of the unknowns from d on.

    Each starts from the end of the last one, the first from θ (p,).
    """
    fixed, points = np.arange(d, d + values.shape[1]), []
    for value in values:
        theta = np.concatenate([theta[:d], value, theta[fixed[-1] + 1 :]])
        points.append(maximise(likelihood, theta, fixed=fixed, max_iterations=PATH_ITERATIONS, tolerance=1e-2))
        theta = points[-1].theta
    return points
