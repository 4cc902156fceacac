"""Joint fits of unknowns and of numbers that are known to a tolerance.

A search takes such numbers as stated, which makes its result wrong by many times the error of the noise; from there the maximum of the
joint likelihood (`ksmea/likelihood/likelihood.py`) is a few steps away. If the data determine a number far more sharply than its
tolerance, as sharp resonances do Young's modulus, the likelihood has other maxima on the way. Unless the first one fits data of known
noise as well as the right model would, fits then also start along the direction of these numbers that the data determine best.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.fits.fitting import BaselineFits, Fit
from ksmea.inference.maximisation import best_maxima, maximise, with_best_noise
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point, projected
from ksmea.likelihood.likelihood import Likelihood
from ksmea.numerics.screening import Screened
from ksmea.problem.held import holding_inputs
from ksmea.problem.problem import joint_values

SHARP = (
    10.0  # standard deviations of the noise by which data move with one of a number: beyond, one start is not enough
)
STARTS = (-2.0, -1.0, 1.0, 2.0)  # further ones, in standard deviations of the numbers
FIRST_ITERATIONS, BESIDE_ITERATIONS, SURVIVORS = 8, 12, 2
MOST_STARTS = 3  # of the maxima with numbers as stated
REACH = 25.0  # of the deviance: fits that end so much higher are left there


def joint_maxima(likelihood: Likelihood, starts: Sequence[Array]) -> list[Point]:
    """Different maxima of a joint likelihood, highest first.

    The searches start from points (d,) of the unit cube at which numbers are as stated.
    """
    first = maximise(likelihood, likelihood.start(starts[0]), max_iterations=FIRST_ITERATIONS, tolerance=1e-2)
    further = [likelihood.start(u) for u in starts[1:]]
    if sharpest := _along_sharpest(likelihood, starts[0], first):
        first = maximise(likelihood, first)
        further += [] if _is_as_good_as_right(likelihood, first) else [_beside(likelihood, u) for u in sharpest]
    if not further:
        return [with_best_noise(likelihood, maximise(likelihood, first))]
    found = best_maxima(
        likelihood, [first.theta, *further], first_iterations=FIRST_ITERATIONS, survivors=SURVIVORS, reach=REACH
    )
    return [with_best_noise(likelihood, maximise(likelihood, point)) for point in found[:1]] + found[1:]


def _is_as_good_as_right(likelihood: Likelihood, point: Point) -> bool:
    """Whether data of known noise lie as near a maximum as near the right model.

    Then no other maximum is much higher. The deviance of the right model is a sum of n squares of normal residuals, n ± √(2n).
    """
    n = likelihood.n_residual
    return not likelihood.noise_is_estimated and point.deviance <= n + np.sqrt(2 * n)


def _beside(likelihood: Likelihood, u: Array) -> Array:
    """θ with the numbers as they are in u (d,), and all other unknowns fitted to that."""
    problem = likelihood.case.problem
    held = likelihood_of(likelihood.case.by(holding_inputs(problem, problem.parameters.to_si(u))))
    own, whole = problem.parameters.own, u.copy()
    whole[own] = maximise(held, held.start(u[own]), max_iterations=BESIDE_ITERATIONS, tolerance=1.0).theta[: len(own)]
    return likelihood.start(whole)


def _along_sharpest(likelihood: Likelihood, start: Array, point: Point) -> list[Array]:
    """Further points (d,) along the direction of numbers best determined by the data.

    There are some only if it is determined sharply.
    """
    parameters = likelihood.model.problem.parameters
    columns, (value, sd) = parameters.with_prior, parameters.priors
    others = np.setdiff1d(np.arange(point.whitened.shape[1]), columns)
    of_data = point.whitened[: len(point.whitened) - len(columns)]
    seen = projected(of_data[:, columns] * sd, of_data[:, others])
    _, singular, directions = np.linalg.svd(seen, full_matrices=False)
    if singular[0] < SHARP:
        return []
    found = []
    for size in STARTS:
        u = start.copy()
        u[columns] = np.clip(value + size * sd * directions[0], 0.0, 1.0)
        found.append(u)
    return found


def joint_baseline(fits: BaselineFits) -> BaselineFits:
    """Fits of the joint problem from those with numbers as stated; themselves if all numbers are exact."""
    problem = fits.best.problem
    if (joint := problem.joint) is problem:
        return fits
    likelihood = likelihood_of(fits.best.case.by(joint))
    x = [fit.x for fit in (fits.best, *fits.others)]
    starts = [joint.parameters.to_cube(joint_values(problem, joint, each)) for each in x]
    best, *others = (Fit(likelihood, point) for point in joint_maxima(likelihood, starts[:MOST_STARTS]))
    screened = fits.screened
    points = [joint_values(problem, joint, each) for each in problem.parameters.to_si(screened.points)]
    return BaselineFits(best, tuple(others), Screened(joint.parameters.to_cube(np.array(points)), screened.misfits))
