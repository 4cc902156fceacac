"""Starts for the fit of an effect whose force follows a law at one place, from the recovered force.

If a stop is touched near resonances only, the response changes only there: from values without a stop the likelihood
says little of where it is large. But a force that is free at every speed fits whatever acts at the place, and gives
the other unknowns as well (`unknown_force`). The law comes nearest to that force at some coefficients (`law_start`).
From there it is fitted together with the unknowns, by 1X alone and then with all harmonics, in the measured motion;
if several are steady, in the one next to it. This likelihood has no edges.

The effect itself, in the motion that a slow run comes to, is fitted from the end of that fit. The slow run's
likelihood has edges, at which a speed changes over from one motion to another. If the end lies beyond an edge, or
its residuals are far larger than with the free force, fits also start from the best of a cloud of points.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.fits.fitting import END, Fit
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point
from ksmea.location.force_law import SMALLEST, TOLERANCE, LawLikelihood, chance_beyond_free_force
from ksmea.location.law_start import UNSEEN, inside, nearest_start
from ksmea.location.location import fitted_site, missing_to_locate
from ksmea.location.unknown_force import SiteFit, Unmodelled
from ksmea.nonlinear.laws import Law
from ksmea.numerics.screening import log_ratio, mean_log_misfit, sobol
from ksmea.plugins.effect import ForceLaw
from ksmea.problem.case import Case
from ksmea.problem.held import holding_inputs
from ksmea.problem.load import FORCE

N_START = 16  # of the fit beside a free force
MAX_ITERATIONS = 50  # of each fit in the measured motion
SAME = 1.0  # deviance by which two responses differ that have the same motions at all speeds
RARE = 1e-3  # the chance below which a fit is not taken to leave noise alone
N_CLOUD = 128  # points around it, a power of two
N_BATCH = 16  # of these are evaluated at once, and left out where one has no steady motion
N_KEPT = 3  # of all, those that fits start from


def can_recover(case: Case, position: float) -> bool:
    """Whether data of a problem determine a force at a position, m, that is free at every speed.

    Amplitudes do not. The problem must take unit loads.
    """
    if case.measurement.is_by_differences:  # a free force is of what was read
        return False
    case = case.at_1x()
    problem = case.problem
    try:
        if missing_to_locate(problem, case.measurement.kind):
            return False
        middle = problem.parameters.to_si(np.full((1, len(problem.parameters)), 0.5))
        problem.load_response(middle, Unmodelled(FORCE, position).loads)
    except SettingError:  # what the problem has already does not go with unit loads
        return False
    return True


def starts_from_force(
    extended: Case, without: Case, position: float, law: ForceLaw, ceiling: float = np.inf, near: Array | None = None
) -> Array:
    """Starting points (n, d), unit cube, of a fit with a force by a law at a position, m.

    Empty if no law with a steady motion is found, or if a free force has a deviance above `ceiling`: no law comes
    lower. Numbers known to a tolerance are held at the values of a point `near` (SI) of the problem without the force, by
    default as stated: no free force is then refused by its deviance, as other numbers may lower it. The data are such that
    `can_recover`. Raises `SettingError` for a law that is not one of `ksmea.nonlinear.laws`."""
    parameters = extended.problem.parameters
    if len(parameters.own) == len(parameters):
        return _starts(extended, without, position, law, ceiling)
    x = np.array([item.stated for item in parameters])
    if near is not None:
        x[: len(near)] = near

    def held(case: Case) -> Case:
        return case.by(holding_inputs(case.problem, x[: len(case.problem.parameters)]))

    found = _starts(held(extended), held(without), position, law)
    starts = np.tile(parameters.to_cube(x), (len(found), 1))
    starts[:, parameters.own] = found
    return starts


def _starts(extended: Case, without: Case, position: float, law: ForceLaw, ceiling: float = np.inf) -> Array:
    """Starting points of a problem whose unknowns are all searched, by the problem without the force."""
    if not isinstance(law, Law):
        raise SettingError(f"force_at: expected a law of ksmea.nonlinear.laws, got {law!r}; subclass Law")
    at_rotation = without.at_1x()
    problem, limits = at_rotation.problem, extended.problem.parameters
    site = fitted_site(at_rotation, Unmodelled(FORCE, position), N_START)
    none = np.empty((0, len(limits)))
    if at_rotation is without and likelihood_of(without).deviance_of(site.point.mean) > ceiling:
        return none
    start = nearest_start(site, law)
    unit = np.array([size for _, _, size in law.coefficients])
    parts = np.abs(start.coefficients / unit)
    if not parts.max() > 0:
        return none
    scale = np.maximum(parts, SMALLEST * parts.max()) * unit
    likelihood = LawLikelihood(site, law, scale, start.motion)
    likelihood.lower[likelihood.d :] = limits.lower[likelihood.d :] / scale
    likelihood.upper[likelihood.d :] = limits.upper[likelihood.d :] / scale
    with suppress(np.linalg.LinAlgError):
        theta = np.concatenate([start.theta, start.coefficients / scale])
        best = maximise(likelihood, theta, tolerance=TOLERANCE, max_iterations=MAX_ITERATIONS)

        def in_cube(theta: Array) -> Array:
            x = [problem.parameters.to_si(theta[:, : likelihood.d]), theta[:, likelihood.d :] * scale]
            return inside(limits.to_cube(np.hstack(x)), limits.period)

        found = _with_all_harmonics(extended, start.motion, in_cube(best.theta[None])[0])
        if found is None or not _is_enough(found, site, likelihood):
            cloud = in_cube(np.vstack([best.theta, best.theta + _draws(best)]))
            known = np.empty((0, len(limits))) if found is None else found.u[None]
            return np.vstack([known, _in_agreement(extended, cloud)])
        if _is_of_slow_run(found, extended):
            return found.u[None]
        cloud = inside(found.u + _draws(found.point)[:, : len(limits)], limits.period)
        return np.vstack([found.u, _in_agreement(extended, cloud)])
    return none


def _with_all_harmonics(extended: Case, motion: ComplexArray, u: Array) -> Fit | None:
    """Effect fitted from a point (d,) of the unit cube, in the steady motions next to a given one.

    The given motion of its site is (n_speed, 2), m. None if the fit meets a point without a steady motion."""
    likelihood = likelihood_of(extended.by(extended.problem.next_to(motion)))
    with suppress(np.linalg.LinAlgError):
        return Fit(likelihood, maximise(likelihood, likelihood.start(u), tolerance=END, max_iterations=MAX_ITERATIONS))
    return None


def _is_of_slow_run(fit: Fit, extended: Case) -> bool:
    """Whether a slow run comes to the motions that a fit is next to."""
    with suppress(np.linalg.LinAlgError):
        return likelihood_of(extended).deviance(fit.point.theta) < fit.deviance + SAME
    return False


def _is_enough(fit: Fit, site: SiteFit, likelihood: LawLikelihood) -> bool:
    """Whether a fit leaves no more at 1X beyond what the free force does than noise may."""
    at_1x = [channel.is_1x for channel in fit.problem.channels]
    deviance = float(np.sum(likelihood.whitened(fit.response()[None][..., at_1x]) ** 2))
    return chance_beyond_free_force(site, likelihood, deviance) > RARE


def _draws(best: Point) -> Array:
    """Steps (n, p) from a maximum as likely as its information says; none along what the data do not show."""
    _, sizes, directions = np.linalg.svd(best.whitened, full_matrices=False)
    shown = sizes > UNSEEN * sizes.max()
    drawn = scipy.stats.norm.ppf(sobol(N_CLOUD, int(shown.sum())) + 0.5 / N_CLOUD)
    return np.asarray((drawn / sizes[shown]) @ directions[shown])


def _in_agreement(case: Case, points: Array) -> Array:
    """The `N_KEPT` of points (n, d) of the unit cube whose response at 1X comes nearest to the data.

    The misfit is the mean |ln ratio|: one speed that is on the other motion counts no more than its ratio."""
    problem, is_1x = case.problem, [channel.is_1x for channel in case.measurement.channels]
    seen = case.measurement.values[:, is_1x]
    misfits = np.full(len(points), np.inf)
    for rows in np.split(np.arange(len(points)), range(N_BATCH, len(points), N_BATCH)):
        with suppress(np.linalg.LinAlgError):
            response = problem.response(problem.parameters.to_si(points[rows]))
            misfits[rows] = mean_log_misfit(log_ratio(response[..., is_1x][:, seen != 0], seen[seen != 0]))
    order = np.argsort(misfits)[:N_KEPT]
    return np.asarray(points[order[np.isfinite(misfits[order])]])
