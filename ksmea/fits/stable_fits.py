"""Fits with effects whose rotor is stable at all measured speeds.

Data of a steady response are of no other.

The likelihood knows nothing of it: the synchronous response is finite on both sides of the threshold. Most fits are nowhere
near it; one that is beyond is made again, with unstable values refused.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array
from ksmea.fits.fitting import TRIAL_ITERATIONS, Fit, settled
from ksmea.inference.intervals import Estimate
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.likelihood import Likelihood
from ksmea.numerics.parallel import ALONE, Workers
from ksmea.problem.problem import Problem
from ksmea.rotordynamics.stability import last_stable

EXACT = 0.01  # of the deviance among stable values: on the border steps grow ever shorter, and lower it by ever less


def stable_fit(fit: Fit, start: Array, below: float = np.inf) -> Fit:
    """Fit at which its rotor is stable.

    If the given fit is unstable, it is the highest maximum among stable values reached from a stable start θ (p,) and
    from the last stable point on the straight way from there to the fit. If the start is unstable too, the fit is
    unchanged. A search that would not come `below` a deviance is given up at the stable values that it has.
    """
    problem = fit.problem
    if problem.is_stable(fit.x):
        return fit
    bounded = _bounded(fit)
    if not bounded.is_stable(start):
        return fit
    way = fit.point.theta - start
    starts = (start, start + last_stable(lambda part: bounded.is_stable(start + part * way)) * way)
    if fit.deviance > below:  # among all values
        return Fit(bounded, min(map(bounded.at, starts), key=lambda point: point.deviance))
    found: list[Point] = []
    for theta in starts:
        ceiling = min([below, *(point.deviance for point in found)])
        found.append(
            maximise(
                bounded, theta, max_iterations=TRIAL_ITERATIONS, tolerance=EXACT, least_gain=EXACT, ceiling=ceiling
            )
        )
    return Fit(bounded, min(found, key=lambda point: point.deviance))


def better_stable(fit: Fit, other: Fit, start: Array, below: float = np.inf) -> Fit:
    """The better one of a fit and another one, which is stable (`stable_fit`) if it is the better one."""
    if other.deviance >= fit.deviance:
        return fit
    return min(fit, stable_fit(other, start, below), key=lambda each: each.deviance)


def settled_stable(fit: Fit, level: float, workers: Workers = ALONE) -> tuple[Fit, Estimate]:
    """Settle a stable fit (`ksmea.fits.fitting.settled`).

    The search is limited to stable values if the result names unstable ones."""
    found, estimated = settled(fit, level, workers)
    if _names_stable(found.problem, estimated):
        return found, estimated
    stable = stable_fit(found, fit.point.theta)
    bounded = _bounded(fit)
    return settled(Fit(bounded, bounded.at(stable.point.theta)), level, workers)


def _bounded(fit: Fit) -> Likelihood:
    """The likelihood of a fit, with unstable values refused."""
    return likelihood_of(fit.case, stable_only=True)


def _names_stable(problem: Problem, estimated: Estimate) -> bool:
    """Whether the rotor is stable at the estimate and with each unknown at either end of its interval."""
    sets = [estimated.x]
    for index, (parameter, interval) in enumerate(zip(problem.parameters, estimated.intervals)):
        for end in (max(interval.low, parameter.lower), min(interval.high, parameter.upper)):
            sets.append(np.where(np.arange(len(estimated.x)) == index, end, estimated.x))
    return all(problem.is_stable(x) for x in sets)
