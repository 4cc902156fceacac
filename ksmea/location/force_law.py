"""Laws of a located force or moment.

A few coefficients (`ksmea.nonlinear.laws`) instead of two complex numbers per speed.

Coefficients and the model's unknowns are fitted together. A force that is free at each speed fits best, so the excess of a law
is a test of it, with the difference in numbers as degrees of freedom; laws, also at different sites, compare by BIC. Fits start
from the law nearest to the recovered force. Laws that are not linear in the motion cost more; they are fitted only if they
come as near to the recovered force as the linear ones.

A located law can also become part of the model. A location compares laws with a free force, with its own weights; in the model
the law is an effect like any other, and noise and unknowns follow from the likelihood. It is fitted from the unknowns of the
free force, and from the unknowns of the baseline model: an unknown that acts at the located site shows in the data only
once the force follows a law.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray
from ksmea.fits.fitting import Fit, fit_from_values, start_nearby
from ksmea.fits.stable_fits import stable_fit
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.misfit import log_term
from ksmea.location.law_start import LawStart, law_starts
from ksmea.location.location import refitted
from ksmea.location.recovered_force import own_noise
from ksmea.location.unknown_force import SiteFit, SumOfSquares, Unmodelled, all_values
from ksmea.measurement.channel import DIRECTIONS, Channel
from ksmea.measurement.noise import Noise
from ksmea.nonlinear.laws import LAWS, MOMENT_LAWS, Law, LawOfSpeed, NonlinearLaw
from ksmea.nonlinear.smooth_law import smooth
from ksmea.nonlinear.steady_motion import SiteMotion
from ksmea.numerics.differences import central_differences
from ksmea.problem.alignment import through
from ksmea.problem.load import FORCE, LOADS, MOMENT
from ksmea.problem.problem import Problem

STEP = 1e-5  # of differences: of the unit cube, and of the scale of each coefficient
SMALLEST = 1e-3  # of the largest coefficient in its unit: the scale of one that is next to nothing
TOLERANCE = 1e-3  # of χ²
REWEIGHTINGS = 2  # after which weights from the response of a law stay as they are
FIRST_ITERATIONS = 15  # of a fit, before it is seen whether it is worth while
HOPELESS = 5.0  # times the noise that a law leaves beyond the free force: it is fitted no further
PROMISING = 10.0  # ΔBIC to the best linear law at a site within which a nonlinear one is fitted there
N_FIRST = 8  # sites of a force, and of a moment, at which laws are tried first
N_NONLINEAR = 3  # of these at which each nonlinear one is
N_KNOTS = (4, 6, 8, 12)  # of a smooth force
N_SMOOTH = 2  # sites at which one is fitted
LAWS_OF = {FORCE: tuple(LAWS.values()), MOMENT: tuple(MOMENT_LAWS.values())}


@dataclass(frozen=True)
class LawFit:
    """A law fitted at a site together with the unknowns.

    `p` of leaving no more than the free force, `bic` for comparison with other laws and sites, coefficients
    (n_coefficient,) SI with their covariance.
    """

    law: Law
    site: SiteFit
    p: float
    bic: float
    values: Array
    covariance: Array
    force: ComplexArray  # as the law has it (n_speed, 2) N, or N m

    @property
    def sd(self) -> Array:
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def amplitude(self, speed: Array) -> tuple[Array, Array]:
        """|f| in x and y, (n_speed, 2) N or N m, of a law of speed, and its standard deviation."""
        if not isinstance(self.law, LawOfSpeed):
            raise TypeError("expected a law of speed: what others do depends on a motion")
        terms = self.law.terms(speed)
        force = np.einsum("c,csk->sk", self.values, terms)
        along = (np.conj(force) / np.abs(force) * terms).real
        return np.abs(force), np.sqrt(np.einsum("csk,cd,dsk->sk", along, self.covariance, along))


@dataclass(frozen=True)
class LawTrial:
    """A law that is to be fitted at a site, and from where."""

    site: SiteFit
    law: Law
    starts: Sequence[LawStart]

    @property
    def bic(self) -> float:
        return min(start.bic for start in self.starts)


class LawLikelihood(SumOfSquares):
    """χ² of a model with a law at a site, for `ksmea.inference.maximisation`.

    Unknowns are in the unit cube, followed by coefficients in units of `scale`. Of several steady-state responses of
    the site, the one next to `near` (n_speed, 2), m, is taken.
    """

    def __init__(self, site: SiteFit, law: Law, scale: Array, near: ComplexArray | None = None) -> None:
        base = site.likelihood
        problem, position = base.problem, site.unmodelled.position
        self.d = base.d
        self.law, self.scale, self.near = law, scale, near
        self.lower = np.concatenate([base.lower, law.least])
        self.upper = np.concatenate([base.upper, np.full(len(scale), np.inf)])
        self.period = np.concatenate([base.period, np.full(len(scale), np.inf)])
        self.longest_step = np.full(len(self.lower), np.inf)
        self._base, self._unmodelled = base, site.unmodelled
        at_site = [Channel(position, axis) for axis in DIRECTIONS] if law.follows_motion else []
        self._seen = through(problem, [*problem.channels, *at_site]) if at_site else problem

    def with_noise_of(self, site: SiteFit) -> LawLikelihood:
        """This likelihood with the weights of another fit of the site; the rotor is not reduced again."""
        other = copy(self)
        other._base = site.likelihood
        return other

    def at(self, theta: Array) -> Point:
        """Point at θ; of several steady motions, neighbours of θ take the one nearest to the motion at θ."""
        differences = central_differences(theta, STEP, self.lower, self.upper)
        mean, _, motion = self._steady(theta[None], self.near)
        around, _, _ = self._steady(differences.points, motion[0])
        [residual] = self.whitened(mean)
        jacobian = differences.derivative(self.whitened(around))
        return Point(theta, float(residual @ residual), 2 * jacobian.T @ residual, jacobian)

    def _residual(self, theta: Array) -> Array:
        """Residuals at points (n, p), as real numbers of unit variance (n, m)."""
        return self.whitened(self._steady(theta, self.near)[0])

    def whitened(self, mean: ComplexArray) -> Array:
        """Residuals of responses (n, n_speed, n_channel), as real numbers of unit variance (n, m)."""
        left = (mean - self._base.measured) / self._base.sd
        return self._base.measurement.kind.real_parts(left.reshape(len(mean), -1), axis=1)

    def mean_and_force(self, theta: Array) -> tuple[ComplexArray, ComplexArray]:
        """Response (n, n_speed, n_channel), m, and what acts, (n, n_speed, 2) N, at points (n, p)."""
        return self._steady(theta, self.near)[:2]

    def _steady(self, theta: Array, near: ComplexArray | None) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Response, force and motion of the site, (n, n_speed, 2) m, next to one (n_speed, 2).

        The motion is empty, (n, n_speed, 0), for a law that does not follow it.
        """
        u, place = np.unique(
            theta[:, : self.d], axis=0, return_inverse=True
        )  # many points differ in coefficients alone
        x = self._base.problem.parameters.to_si(u)
        response, columns = (each[place] for each in self._unmodelled.response_and_columns(self._seen, x))
        n_channel = len(self._base.problem.channels)
        coefficients = theta[:, self.d :] * self.scale
        motion, per_force = response[:, :, n_channel:], columns[:, :, n_channel:]
        start = None if near is None else np.broadcast_to(near, motion.shape)[:, :, None]
        force = self.law.steady(coefficients, SiteMotion(self._seen.speed, motion, per_force, start))
        acting = response + (columns @ force[..., None])[..., 0]
        return acting[:, :, :n_channel], force, acting[:, :, n_channel:]


def fitted_laws(sites: Sequence[SiteFit], noise: Noise, progress: Callable[[], None] = lambda: None) -> list[LawFit]:
    """Fits of every law of its kind at sites of an unknown force or moment, lowest BIC first.

    Sites are in order of their residuals; `noise` is the noise of the location. The first sites of each quantity are
    tried, then neighbours of the best fit until none is better: if many sites are accepted, the residuals at the site
    of a law may be no smaller than at others. `progress` is called at each fit.
    """
    first = [
        site
        for quantity in LOADS
        for site in [each for each in sites if each.unmodelled.quantity == quantity][:N_FIRST]
    ]
    trials = {site.unmodelled: _all_trials(site) for site in first}
    fits = _all_fitted(_first_trials(trials.values()), noise, progress)
    seen: set[Unmodelled] = set()
    while fits and fits[0].site.unmodelled not in seen:
        best = fits[0]
        seen.add(best.site.unmodelled)
        beside = _beside(best.site.unmodelled, sites)
        trials |= {site.unmodelled: _all_trials(site) for site in beside if site.unmodelled not in trials}
        found = {(fit.site.unmodelled, fit.law.key) for fit in fits}
        further = [
            trial
            for site in beside
            for trial in _promising(trials[site.unmodelled], all_nonlinear=isinstance(best.law, NonlinearLaw))
            if (site.unmodelled, trial.law.key) not in found
        ]
        fits = sorted([*fits, *_all_fitted(further, noise, progress)], key=lambda fit: fit.bic)
    return fits


def _all_trials(site: SiteFit) -> list[LawTrial]:
    return _trials(site, LAWS_OF[str(site.unmodelled.quantity)])


def _trials(site: SiteFit, laws: Sequence[Law]) -> list[LawTrial]:
    return [LawTrial(site, law, starts) for law, starts in zip(laws, law_starts(site, laws))]


def _first_trials(at_sites: Iterable[Sequence[LawTrial]]) -> list[LawTrial]:
    """The laws that are worth a fit at the first sites, each nonlinear one where it comes nearest."""
    n_tried: Counter[str] = Counter()
    worth = []
    for trial in sorted((trial for trials in at_sites for trial in _promising(trials)), key=lambda trial: trial.bic):
        n_tried[trial.law.key] += 1
        if n_tried[trial.law.key] <= N_NONLINEAR or not isinstance(trial.law, NonlinearLaw):
            worth.append(trial)
    return worth


def _promising(trials: Sequence[LawTrial], *, all_nonlinear: bool = False) -> list[LawTrial]:
    """The laws that are worth a fit at a site.

    Nonlinear ones that come near, or all where the best law is not linear.
    """
    lowest = min(trial.bic for trial in trials if not isinstance(trial.law, NonlinearLaw))
    return [
        trial
        for trial in trials
        if all_nonlinear or not isinstance(trial.law, NonlinearLaw) or trial.bic < lowest + PROMISING
    ]


def _beside(place: Unmodelled, sites: Sequence[SiteFit]) -> list[SiteFit]:
    """The site at a place and those next to it, of the same quantity."""
    of_quantity = [site for site in sites if site.unmodelled.quantity == place.quantity]
    along = sorted(of_quantity, key=lambda site: site.unmodelled.position)
    index = [site.unmodelled for site in along].index(place)
    return along[max(index - 1, 0) : index + 2]


def _all_fitted(trials: Iterable[LawTrial], noise: Noise, progress: Callable[[], None] = lambda: None) -> list[LawFit]:
    """Fits by rising BIC, without laws that have no steady motion."""
    fits = []
    for trial in trials:
        fits.append(_fitted(trial, noise))
        progress()
    return sorted((fit for fit in fits if fit is not None), key=lambda fit: fit.bic)


def smooth_fits(sites: Sequence[SiteFit], noise: Noise) -> list[LawFit]:
    """Smooth functions of speed at the first sites of an unknown force, lowest BIC first.

    Each has as many knots as give the lowest BIC, at most half as many as speeds.
    """
    found = []
    for site in [site for site in sites if site.unmodelled.quantity == FORCE][:N_SMOOTH]:
        speed = site.likelihood.problem.speed
        counts = [n for n in N_KNOTS if 2 * n <= len(speed)]
        laws = [smooth(np.quantile(speed, np.linspace(0, 1, n))) for n in counts]
        found += _all_fitted(_trials(site, laws), noise)[:1]
    return sorted(found, key=lambda fit: fit.bic)


def _fitted(trial: LawTrial, noise: Noise) -> LawFit | None:
    """A law at a site, from where it comes nearest to the free force.

    None if no fit has a steady motion, or it is a simpler law.

    The weights come from its own response, for the free force that it is compared with too: a free force takes noise along,
    and with it weights that favour small values.
    """
    site, law, starts = trial.site, trial.law, trial.starts
    unit = np.array([size for _, _, size in law.coefficients])
    largest = np.max(np.abs([start.coefficients / unit for start in starts]), axis=0)
    scale = np.maximum(largest, SMALLEST * largest.max()) * unit
    near = starts[0].motion if isinstance(law, NonlinearLaw) else None
    likelihood = LawLikelihood(site, law, scale, near)
    tried = []
    for start in starts:
        with suppress(np.linalg.LinAlgError):
            theta = np.concatenate([start.theta, start.coefficients / scale])
            tried.append(maximise(likelihood, theta, tolerance=TOLERANCE, max_iterations=FIRST_ITERATIONS))
    if not tried:
        return None
    found = min(tried, key=lambda point: point.deviance)
    beyond, n_more = _beyond(site, likelihood, found.deviance)
    for _ in range(REWEIGHTINGS if beyond < HOPELESS * n_more else 0):
        response, _ = likelihood.mean_and_force(found.theta[None])
        reweighted = refitted(site, noise.sd(np.abs(response[0])))
        again = likelihood.with_noise_of(reweighted)
        try:
            found = maximise(again, found.theta, tolerance=TOLERANCE)
        except np.linalg.LinAlgError:  # no steady motion on the way: the fit with the weights before stands
            break
        site, likelihood = reweighted, again
    if not np.isfinite(found.information).all():  # a size ran off to where differences have no width
        return None
    fit = _law_fit(site, likelihood, found, noise)
    return fit if law.shows(fit.values, site.likelihood.problem.speed) else None


def _law_fit(site: SiteFit, likelihood: LawLikelihood, found: Point, noise: Noise) -> LawFit:
    measurement, sd = site.likelihood.measurement, site.likelihood.sd
    # weights differ from law to law: the whole deviance is compared
    sizes = log_term(sd**2, noise.variance(np.abs(measurement.values)), measurement.kind)
    covariance = own_noise(site) ** 2 * np.linalg.pinv(found.information)[likelihood.d :, likelihood.d :]
    return LawFit(
        likelihood.law,
        site,
        p=chance_beyond_free_force(site, likelihood, found.deviance),
        bic=float(found.deviance + np.sum(sizes) + len(likelihood.scale) * np.log(found.whitened.shape[0])),
        values=found.theta[likelihood.d :] * likelihood.scale,
        covariance=covariance * np.outer(likelihood.scale, likelihood.scale),
        force=likelihood.mean_and_force(found.theta[None])[1][0],
    )


def _beyond(site: SiteFit, likelihood: LawLikelihood, deviance: float) -> tuple[float, int]:
    """Excess of a law's deviance over the free force's, and the number of parameters it saves.

    It is in units of the noise estimated with the free force.
    """
    free = site.point
    n_more = 2 * free.free.size - len(likelihood.scale) - (likelihood.d - free.n_searched)
    return max(deviance - free.deviance, 0.0) / own_noise(site) ** 2, n_more


def chance_beyond_free_force(site: SiteFit, likelihood: LawLikelihood, deviance: float) -> float:
    """The chance that noise makes a law leave as much beyond the free force as with a deviance.

    It is by χ² if the noise level is known, else by an F-test.
    """
    beyond, n_more = _beyond(site, likelihood, deviance)
    if site.likelihood.measurement.noise is not None:
        return float(scipy.stats.chi2.sf(beyond, n_more))
    return float(scipy.stats.f.sf(beyond / n_more, n_more, site.point.n_left))


def located_fit(extended: Problem, law: LawFit, plain: SiteFit, before: Fit) -> Fit:
    """A problem whose last unknowns are the coefficients of a fitted law, fitted.

    `before` is the fit without them.

    Raises LinAlgError if no start has a steady motion under the law.
    """
    case = plain.likelihood.case.by(extended)
    found = []
    for fit in (law.site, plain):
        x = np.concatenate([all_values(fit), law.values])
        with suppress(np.linalg.LinAlgError):
            found.append(fit_from_values(case, x))
    if not found:
        raise np.linalg.LinAlgError("no steady motion was found where the law was fitted")
    return stable_fit(min(found, key=lambda fit: fit.deviance), start_nearby(extended, before))
