"""The fit of an effect whose force follows a law at one place: from the force as it is recovered there.

A stop that is touched near resonances only changes the response there altogether: seen from values without it, the likelihood says
little of where it is large. But a force that is free at every speed fits whatever acts at the
place, and gives the unknowns beside it (`unknown_force`); the law comes nearest to that force somewhere (`law_start`); from there it is
fitted together with the unknowns, in the motion that was measured: where several are steady, the one next to it. This likelihood has
no edges. The fit of the effect itself, in the motion that a slow run comes to, starts from the best of a cloud around that: at its
edges a speed changes over from one motion to another.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import scipy

from ksmea.arrays import Array
from ksmea.contracts import Problem
from ksmea.diagnosis.force_law import SMALLEST, TOLERANCE, LawLikelihood
from ksmea.diagnosis.law_start import UNSEEN, inside, nearest_start
from ksmea.diagnosis.location import fitted_site, missing_to_locate
from ksmea.diagnosis.unknown_force import Unmodelled
from ksmea.difference_likelihood import likelihood_of
from ksmea.errors import SettingError
from ksmea.force_laws import Law
from ksmea.harmonics import at_1x
from ksmea.load import FORCE
from ksmea.maximisation import maximise
from ksmea.measurement import Measurement
from ksmea.model import Model
from ksmea.point import Point
from ksmea.screening import log_ratio, mean_log_misfit, sobol

N_START = 16  # of the fit beside a free force
MAX_ITERATIONS = 50  # of the fit in the measured motion
N_CLOUD = 128  # points around it, a power of two
N_BATCH = 16  # of these are evaluated at once, and left out where one has no steady motion
N_KEPT = 3  # of all, those that fits start from


def can_recover(problem: Problem, measurement: Measurement, position: float) -> bool:
    """Whether data of a problem tell a force at a position, m, that is free at every speed, as amplitudes do not, and it takes unit
    loads."""
    if measurement.is_by_differences:  # a free force is of what was read
        return False
    problem, at_rotation = at_1x(problem, measurement)
    try:
        if missing_to_locate(problem, at_rotation.kind):
            return False
        middle = problem.parameters.to_si(np.full((1, len(problem.parameters)), 0.5))
        problem.load_response(middle, Unmodelled(FORCE, position).loads)
    except SettingError:  # what the problem has already does not go with unit loads
        return False
    return True


def starts_from_force(
    extended: Problem, measurement: Measurement, without: Problem, position: float, law: Law, ceiling: float = np.inf
) -> Array:
    """Points (n, d) of the unit cube from which to fit a problem that an effect has extended: a force by a law at a position, m.
    There are none where no law is found that has a steady motion, or where a free force leaves a deviance above a ceiling: no law
    comes lower. The data are such that `can_recover`."""
    problem, at_rotation = at_1x(without, measurement)
    site = fitted_site(problem, at_rotation, Unmodelled(FORCE, position), N_START)
    none = np.empty((0, len(extended.parameters)))
    if problem is without and likelihood_of(Model(problem), measurement).deviance_of(site.point.mean) > ceiling:
        return none
    start = nearest_start(site, law)
    unit = np.array([size for _, _, size in law.coefficients])
    parts = np.abs(start.coefficients / unit)
    if not parts.max() > 0:
        return none
    scale = np.maximum(parts, SMALLEST * parts.max()) * unit
    likelihood = LawLikelihood(site, law, scale, start.motion)
    limits = extended.parameters
    likelihood.lower[likelihood.d :] = limits.lower[likelihood.d :] / scale
    likelihood.upper[likelihood.d :] = limits.upper[likelihood.d :] / scale
    with suppress(np.linalg.LinAlgError):
        theta = np.concatenate([start.theta, start.coefficients / scale])
        best = maximise(likelihood, theta, tolerance=TOLERANCE, max_iterations=MAX_ITERATIONS)
        cloud = np.vstack([best.theta, best.theta + _draws(best)])
        x = np.hstack([problem.parameters.to_si(cloud[:, : likelihood.d]), cloud[:, likelihood.d :] * scale])
        return _in_agreement(extended, measurement, inside(extended.parameters.to_cube(x), limits.period))
    return none


def _draws(best: Point) -> Array:
    """Steps (n, p) from a maximum as likely as its information says; none along what the data do not show."""
    _, sizes, directions = np.linalg.svd(best.whitened, full_matrices=False)
    shown = sizes > UNSEEN * sizes.max()
    drawn = scipy.stats.norm.ppf(sobol(N_CLOUD, int(shown.sum())) + 0.5 / N_CLOUD)
    return np.asarray((drawn / sizes[shown]) @ directions[shown])


def _in_agreement(problem: Problem, measurement: Measurement, points: Array) -> Array:
    """Those of points (n, d) of the unit cube whose response at 1X comes nearest to the data, by the mean |ln ratio|: one speed that
    is on the other motion counts no more than its ratio."""
    seen = measurement.values[:, [channel.is_1x for channel in measurement.channels]]
    misfits = np.full(len(points), np.inf)
    for rows in np.split(np.arange(len(points)), range(N_BATCH, len(points), N_BATCH)):
        with suppress(np.linalg.LinAlgError):
            response = problem.response(problem.parameters.to_si(points[rows]))
            at_rotation = response[..., [channel.is_1x for channel in measurement.channels]]
            misfits[rows] = mean_log_misfit(log_ratio(at_rotation[:, seen != 0], seen[seen != 0]))
    order = np.argsort(misfits)[:N_KEPT]
    return np.asarray(points[order[np.isfinite(misfits[order])]])
