"""Fits of the baseline model, and of models extended by effects.

The likelihood's maximum from many starts.

The likelihood has many maxima, and a missing effect moves the right one. Therefore the unknowns of an effect are scanned over
their limits, and fits start from the best of these points as well as from the best fit of the baseline model.

An effect that moves nothing at a harmonic of the rotation cannot explain data there: a force that is alike in opposite directions
makes no 2X. Whatever its size, these channels hold only noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices, Mask
from ksmea.fits.elimination import eliminated
from ksmea.fits.search import Effort, Search
from ksmea.fits.starts import scan_values, scanned, screened, screened_both_ways
from ksmea.inference.intervals import Estimate, estimate
from ksmea.inference.maximisation import (
    best_maxima,
    distinct,
    is_in_valley,
    maximise,
    nearest_maximum,
    promised,
    with_best_noise,
)
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.numerics.parallel import ALONE, Workers
from ksmea.numerics.screening import Screened, sobol
from ksmea.problem.case import Case
from ksmea.problem.problem import Problem

START_DISTANCE = 0.1  # starts of the baseline model are not nearer to each other, in the unit cube

# A search for all likely maxima: points screened, fits, iterations after which only the best go on, and how many these are;
# maxima whose deviance is higher by REACH do not matter: a chance of 1 % that they are the truth's.
SCREENED, STARTS, FIRST_ITERATIONS, SURVIVORS = 4096, 30, 8, 10
REACH = 25.0
OF_SHAPE = 4  # further starts, by the shape of the response: small amplitudes may not be the model's
EFFECT_START_DISTANCE = 0.02  # nor starts of an extended one

TRIAL_ITERATIONS = 100  # at most: fits that explain the data end by 60, and the best of all go on to their end

# Expected fall of the deviance at which fits of trials end; of data that are off by many times their known noise, in parts of
# the mean square of what is left.
END = 1e-4


@dataclass(frozen=True)
class Fit:
    """A problem at the maximum of its likelihood."""

    likelihood: Likelihood
    point: Point

    @property
    def case(self) -> Case:
        return self.likelihood.case

    @property
    def problem(self) -> Problem:
        return self.case.problem

    @property
    def measurement(self) -> Measurement:
        return self.case.measurement

    @property
    def deviance(self) -> float:
        return self.point.deviance

    @property
    def marginal_deviance(self) -> float:
        """The deviance with numbers known to a tolerance integrated out, by Laplace's approximation.

        D + ln det(Λ sd²), Λ their information with priors. By it models are compared, in which such numbers count as no
        unknowns.
        """
        inputs = self.inputs
        if not len(inputs):
            return self.deviance
        sd = [
            item.prior.sd / (item.upper - item.lower)
            for item in self.problem.parameters
            if item.is_input and item.prior
        ]
        return self.deviance + float(np.linalg.slogdet((scaled := self.point.whitened[:, inputs] * sd).T @ scaled)[1])

    @property
    def u(self) -> Array:
        """The unknowns in the unit cube (d,)."""
        return self.point.theta[: self.likelihood.d]

    @property
    def x(self) -> Array:
        """The unknowns (d,) SI."""
        return self.problem.parameters.to_si(self.u)

    @property
    def inputs(self) -> Indices:
        """Indices of the unknowns that are numbers known to a tolerance."""
        parameters = self.problem.parameters
        return np.setdiff1d(np.arange(len(parameters)), parameters.own)

    @property
    def noise(self) -> Noise:
        return self.likelihood.noise(self.point.theta)

    @property
    def known(self) -> tuple[object, ...]:
        """Objects of this fit that further fits may contain.

        Processes that share the fits need not send them back.
        """
        return self, self.problem, self.likelihood, self.measurement

    def response(self) -> ComplexArray:
        """(n_speed, n_channel), m."""
        return np.asarray(self.problem.response(self.x[None])[0])


@dataclass(frozen=True)
class BaselineFits:
    """The best fit of the baseline model, the other maxima that were found, and the screened points."""

    best: Fit
    others: tuple[Fit, ...]
    screened: Screened

    def under(self, better: Fit) -> BaselineFits:
        """With a better best fit above the others."""
        return BaselineFits(better, (self.best, *self.others), self.screened)

    def refitted(self, measurement: Measurement) -> BaselineFits:
        """These fits with the noise of another measurement of the same values."""
        best, *others = (refitted(fit, measurement) for fit in (self.best, *self.others))
        return BaselineFits(best, tuple(others), self.screened)


def fit_baseline(case: Case, search: Search, likelihood: Likelihood | None = None) -> BaselineFits:
    """The baseline model fitted from the best points of a screening of its whole box.

    Its likelihood may be given to count its evaluations.
    """
    effort = search.effort
    n = 2 ** (effort.screening - 1).bit_length()
    points = sobol(n, len(case.problem.parameters), search.rng)
    found, of_shape = screened_both_ways(case, points)
    likelihood = likelihood or likelihood_of(case)
    apart = [*found.apart(effort.starts, START_DISTANCE).points, *of_shape.apart(OF_SHAPE, START_DISTANCE).points]
    starts = [likelihood.start(u) for u in apart]
    maxima = [with_best_noise(likelihood, point) for point in maxima_from(likelihood, starts, effort)]
    maxima.sort(key=lambda point: point.deviance)
    fits = [Fit(likelihood, point) for point in maxima]
    return BaselineFits(fits[0], tuple(fits[1:]), found)


def likely_maxima(likelihood: Likelihood, known: Point, rng: np.random.Generator | None = None) -> list[Point]:
    """Maxima of a likelihood in the whole box near the highest, highest first, and a known one.

    Fits start from the best points of a screening in which unknowns grow by factors (`Parameters.from_decades`).
    """
    parameters = likelihood.model.problem.parameters
    points = parameters.from_decades(sobol(SCREENED, len(parameters), rng))
    starts: list[Array] = []
    both = screened_both_ways(likelihood.case, points)
    for found, count in zip(both, (STARTS, OF_SHAPE)):
        apart = Screened(parameters.to_decades(found.points), found.misfits).apart(count, START_DISTANCE)
        starts += [likelihood.start(u) for u in parameters.from_decades(apart.points)]
    maxima = best_maxima(likelihood, starts, first_iterations=FIRST_ITERATIONS, survivors=SURVIVORS)
    maxima = distinct(likelihood, [known, *maxima])
    likely = [point for point in maxima if point.deviance < maxima[0].deviance + REACH]
    return distinct(likelihood, [point if point is known else _polished(likelihood, point) for point in likely])


def finished(fit: Fit, below: float = np.inf) -> Fit:
    """Fit that was left before its end, continued to convergence, if that can be `below` a deviance."""
    return Fit(fit.likelihood, maximise(fit.likelihood, fit.point.theta, tolerance=_end(fit), ceiling=below))


def _end(fit: Fit) -> float:
    return END * max(1.0, fit.deviance / fit.likelihood.n_residual)


def polished(fit: Fit) -> Fit:
    """This fit, converged, with the best noise."""
    return Fit(fit.likelihood, _polished(fit.likelihood, fit.point))


def _polished(likelihood: Likelihood, point: Point) -> Point:
    return with_best_noise(likelihood, maximise(likelihood, point.theta))


def settled(fit: Fit, level: float, workers: Workers = ALONE) -> tuple[Fit, Estimate]:
    """Polished fit with intervals of confidence `level`, which workers share.

    Both belong to the highest maximum that profiles around it meet.
    """
    fit = polished(fit)
    profiled = np.setdiff1d(np.arange(fit.likelihood.d), fit.inputs)
    estimated = estimate(fit.likelihood, fit.point, level=level, profiled=profiled, workers=workers)
    return Fit(fit.likelihood, estimated.point), estimated


def fit_nearby(problem: Problem, baseline: Fit, max_iterations: int = TRIAL_ITERATIONS, below: float = np.inf) -> Fit:
    """Fit of a problem with effects from the fit of the baseline model.

    Its last unknowns belong to effects (0: no effect), and all are fitted together. Here and in the functions below a
    fit is given up if it would not come `below` a deviance.
    """
    return fit_on(nearby(problem, baseline), baseline, max_iterations, below)


def nearby(problem: Problem, baseline: Fit) -> Fit:
    """Start of `fit_nearby`."""
    likelihood = likelihood_of(baseline.case.by(problem))
    start = np.clip(start_nearby(problem, baseline), likelihood.lower, likelihood.upper)
    return Fit(likelihood, likelihood.at(start))


def promised_from(start: Fit) -> float:
    """Deviance drop predicted for the first step from a start."""
    return promised(start.likelihood, start.point)


def fit_on(start: Fit, baseline: Fit, max_iterations: int = TRIAL_ITERATIONS, below: float = np.inf) -> Fit:
    """The fit from a start near the baseline model's."""
    return Fit(start.likelihood, _tried(start.likelihood, start.point, below, max_iterations, _end(baseline)))


def start_nearby(problem: Problem, baseline: Fit) -> Array:
    """θ (p,) of the baseline model's fit, without any effect."""
    d = baseline.likelihood.d
    return np.concatenate([baseline.u, without_effects(problem, d), baseline.point.theta[d:]])


def fit_from_scan(
    fit: Fit, baseline: BaselineFits, effort: Effort, ceiling: float = np.inf, further: Array | None = None
) -> Fit:
    """The better of a fit and further ones of its problem.

    They start from the best points of screenings at values of the effects all over their limits, and at `further` ones (m, e)
    SI, that come nearer to the data than the fit, and from other maxima of the baseline model. They are left after the first
    iterations if all have a deviance above `ceiling`.
    """
    likelihood, d, parameters = fit.likelihood, baseline.best.likelihood.d, fit.problem.parameters
    zero = without_effects(fit.problem, d)
    values = scan_values(zero, effort.scan_values)
    if further is not None:
        values = np.vstack([values, (further - parameters.lower[d:]) / parameters.width[d:]])
    starts = [np.concatenate([other.u, zero]) for other in baseline.others]
    points = baseline.screened.thinned(effort.scan)
    found = scanned(fit.case, points, values, effort.scan_clouds)
    [misfit] = screened(fit.case, fit.u[None]).misfits
    starts += list(found.below(misfit).apart(effort.effect_starts, EFFECT_START_DISTANCE).points)
    if not starts:
        return fit
    maxima = maxima_from(likelihood, [likelihood.start(u) for u in starts], effort, ceiling, fit.deviance)
    return min(fit, Fit(likelihood, maxima[0]), key=lambda each: each.deviance)


def fit_by_elimination(fit: Fit, baseline: BaselineFits, effort: Effort, ceiling: float = np.inf) -> Fit:
    """Better of a fit and further ones of its problem, whose last effect adds to the readings.

    They start from the best of all screened points with that effect's unknowns eliminated.
    """
    zero = without_effects(fit.problem, baseline.best.likelihood.d)
    found = eliminated(fit.case, baseline.screened.points, zero)
    starts = found.apart(effort.effect_starts, EFFECT_START_DISTANCE).points
    maxima = maxima_from(fit.likelihood, [fit.likelihood.start(u) for u in starts], effort, ceiling, fit.deviance)
    return min(fit, Fit(fit.likelihood, maxima[0]), key=lambda each: each.deviance)


def fit_from_points(case: Case, points: Array, effort: Effort, ceiling: float, below: float) -> Fit:
    """Fit of a case from points (n, d) of the unit cube."""
    likelihood = likelihood_of(case)
    starts = [likelihood.start(u) for u in points]
    return Fit(likelihood, maxima_from(likelihood, starts, effort, ceiling, below)[0])


def fit_from(
    fit: Fit,
    starts: Sequence[Fit],
    baseline: BaselineFits,
    effort: Effort,
    ceiling: float = np.inf,
    below: float = np.inf,
) -> Fit:
    """Best of a fit and further ones, started from the baseline unknowns of other fits without effects.

    Starts that are taken to lie in the valley of the fit are skipped. Searches that cannot come `below` a deviance
    stop early, all of them after the first iterations if these lead nowhere below `ceiling`."""
    likelihood, d = fit.likelihood, baseline.best.likelihood.d
    zero = without_effects(fit.problem, d)
    noise = fit.point.theta[len(fit.u) :]
    others = [np.concatenate([start.u[:d], zero]) for start in starts]
    others = [u for u in others if not is_in_valley(likelihood, fit.point, np.concatenate([u, noise]))]
    if not others:
        return fit
    points = [likelihood.start(u) for u in others]
    found = Fit(likelihood, maxima_from(likelihood, points, effort, ceiling, min(below, fit.deviance))[0])
    return min(fit, found, key=lambda each: each.deviance)


def fit_from_values(case: Case, x: Array) -> Fit:
    """A problem fitted from given values (d,) SI of its unknowns, as near as they lie to its limits."""
    likelihood = likelihood_of(case)
    return Fit(likelihood, nearest_maximum(likelihood, np.clip(case.problem.parameters.to_cube(x), 0.0, 1.0)))


def refitted(fit: Fit, measurement: Measurement) -> Fit:
    """A fit with the noise of another measurement of the same values, from where it is."""
    likelihood = likelihood_of(fit.case.of_measurement(measurement))
    return Fit(likelihood, maximise(likelihood, likelihood.start(fit.u)))


def without_effects(problem: Problem, d: int) -> Array:
    """Where in the unit cube the unknowns behind the first d are 0."""
    return problem.parameters.to_cube(np.zeros(len(problem.parameters)))[d:]


def _tried(
    likelihood: Likelihood,
    start: Array | Point,
    below: float,
    max_iterations: int = TRIAL_ITERATIONS,
    tolerance: float = END,
) -> Point:
    return maximise(likelihood, start, max_iterations=max_iterations, tolerance=tolerance, ceiling=below)


def maxima_from(
    likelihood: Likelihood,
    starts: Sequence[Array],
    effort: Effort,
    ceiling: float = np.inf,
    below: float = np.inf,
) -> list[Point]:
    """Different maxima of a likelihood from starts θ, highest first.

    Left where all have a deviance above `ceiling` after the first iterations.
    """
    return best_maxima(
        likelihood,
        starts,
        first_iterations=effort.first_iterations,
        survivors=effort.survivors,
        ceiling=ceiling,
        last_iterations=TRIAL_ITERATIONS,
        below=below,
        reach=REACH,
    )


N_SIZE = 4  # of the values that a scan of an effect with one unknown has: it is asked at these where it moves anything


def least_deviance(fit: Fit, best: Fit, n_own: int) -> float:
    """Approximate lowest deviance of a fit's problem, whose first `n_own` unknowns exclude its effect.

    It is the deviance if the problem predicted as the best fit does wherever the effect changes anything, and nothing
    elsewhere, with the noise that suits this. It comes lower if the residuals of the best fit are more than noise. −∞
    if the effect moves all channels, and for differences between runs.
    """
    if best.measurement.is_by_differences:
        return -np.inf
    silent = _silent(fit, n_own)
    if not np.any(silent):
        return -np.inf
    return best.likelihood.deviance_of(np.where(silent, 0.0, best.response()))


def _silent(fit: Fit, n_own: int) -> Mask:
    """Channels (n_channel,) at harmonics other than 1X without response, as fitted and at several sizes."""
    beside = np.array([not channel.is_1x for channel in fit.measurement.channels])
    if not np.any(beside):
        return beside
    sizes = scan_values(without_effects(fit.problem, n_own), N_SIZE)
    moves, n_asked = np.zeros_like(beside), 0
    for size in (fit.u[n_own:], *sizes):
        with suppress(np.linalg.LinAlgError):  # no steady motion of that size
            x = fit.problem.parameters.to_si(np.concatenate([fit.u[:n_own], size]))
            moves |= np.any(fit.problem.response(x[None])[0] != 0, axis=0)
            n_asked += 1
    return np.asarray(beside & ~moves & (n_asked > 1))
