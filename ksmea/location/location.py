"""Location of something that the model lacks.

Sites at which an unknown force, moment or reading explains the data.

1. At each site the model with something unknown there (`unknown_force`) is fitted from several starts, then twice from
   the best unknowns that were found at any site: the fault moves the unknowns of the plain model by far more than the unknowns
   of the model with the true site.
2. The noise, if it is not known, is taken from the site that needs least of it (`restricted_noise`), for all sites: otherwise a
   wrong site would be excused by noise of its own making. Each site's weights come from its fitted response: weights from the data
   favour values that are measured too small.
3. Each site is tested on its own (`site_quality`). Sites are not nested in each other, so that differences of their
   deviances have no χ² distribution.

The plain model and unknown readings are fitted and tested alike.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from ksmea.arrays import Array, as_real
from ksmea.errors import SettingError
from ksmea.fits.fitting import START_DISTANCE
from ksmea.fits.starts import screened
from ksmea.inference.maximisation import best_maxima, is_in_valley
from ksmea.location.restricted_noise import restricted_noise
from ksmea.location.sites import SiteQuality, fitted_pairs, site_qualities
from ksmea.location.unknown_force import READING, ProjectedLikelihood, SiteFit, Unmodelled
from ksmea.measurement.channel import DIRECTIONS
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.numerics.parallel import ALONE, Workers
from ksmea.numerics.screening import sobol
from ksmea.problem.alignment import through
from ksmea.problem.case import Case
from ksmea.problem.held import holding_inputs
from ksmea.problem.load import LOADS
from ksmea.problem.problem import Problem
from ksmea.records.location import LATERAL, MAX_PLACES, is_at_most_sites, is_nearest

FIRST_FLOOR = 0.1  # of the median of all values: the noise's floor in the first weights, relative to its relative part
SHARED = 3  # best sites whose unknowns all sites are fitted from
SHARINGS = 2
REWEIGHTINGS = 3  # after which weights from the fitted response stay as they are
HOPELESS = 50.0  # mean square of what a site leaves, in units of the noise, at which its fit is given up
FIRST_ITERATIONS, SURVIVORS = 10, 2  # of each fit: after the first iterations only the best starts go on
N_SCREENED = 2048  # points of the box, a power of two
SCREENED_STARTS = 12


@dataclass(frozen=True)
class Location:
    """Sites with their fits and tests; `plain` is the model with nothing unknown.

    `noise` is common to all fits.
    """

    sites: tuple[SiteFit, ...]
    qualities: tuple[SiteQuality, ...]
    plain: SiteFit
    plain_quality: SiteQuality
    noise: Noise
    level: float

    @property
    def accepted(self) -> list[int]:
        """Indices of the sites that are not rejected, the one that leaves least first."""
        kept = [index for index, quality in enumerate(self.qualities) if quality.p >= self.level]
        return sorted(kept, key=lambda index: self.sites[index].point.excess)

    @property
    def ranked(self) -> list[int]:
        """Indices of all sites: first the accepted ones, then the others by rising residuals."""
        others = set(range(len(self.sites))) - set(self.accepted)
        return [*self.accepted, *sorted(others, key=lambda index: self.sites[index].point.excess)]

    @property
    def is_sharp(self) -> bool:
        """Whether something at one place explains the data, and at few places alone."""
        sites = [self.sites[index].unmodelled for index in self.accepted]
        tried = {fit.unmodelled.position for fit in self.sites if fit.unmodelled.loads}
        places = {site.position for site in sites if site.loads}
        readings = {site.position for site in sites if not site.loads}
        is_single = bool(sites) and all(site.second is None for site in sites)
        return is_single and len(places) < MAX_PLACES * len(tried) and len(readings) < 2

    @property
    def is_anywhere(self) -> bool:
        """Whether something unknown explains the data at most sites, so that no law determines its site."""
        return is_at_most_sites(len(self.accepted), len(self.sites))

    def accepts(self, position: float) -> bool:
        """Whether anything is accepted than which nothing that was tried is nearer to a position (m)."""
        tried = [fit.unmodelled.position for fit in self.sites]
        return is_nearest(position, tried, [tried[index] for index in self.accepted])

    @property
    def is_plain_enough(self) -> bool:
        return self.plain_quality.p >= self.level


def locate(
    case: Case,
    rng: np.random.Generator,
    *,
    positions: Sequence[float] = (),
    quantities: Sequence[str] = (*LOADS, READING),
    level: float = 0.01,
    n_start: int = 4,
    workers: Workers = ALONE,
) -> Location:
    """Sites tried at each position or reading plane for each quantity, each tested at `level`.

    Positions are in m; default: the problem's sites. If nothing is accepted anywhere, force and moment together are
    tried, and forces at two positions if there are enough channels. Workers share the sites.

    Raises `SettingError` if there are too few data to test the fit once the unknown quantity is eliminated.
    """
    problem = case.problem
    require_enough(problem, case.measurement.kind)
    along = problem.sites if not len(positions) else np.asarray(positions, dtype=float)

    def fitted(tried: Sequence[Unmodelled]) -> list[SiteFit]:
        held = _as_stated(case)
        fits = _fits(held, tried, rng, n_start, workers)
        return fits if held is case else _each_site(partial(_with_inputs, case=case), fits, workers)

    fits = fitted([Unmodelled(), *candidates(problem, quantities, along)])
    found = _tested(fits, level, rng, workers)
    if found.accepted or not set(LOADS) <= set(quantities):
        return found
    more = fitted(candidates(problem, (LATERAL,), along))
    if len(along) > 1 and leaves_enough(problem, 2 * len(DIRECTIONS)):
        more += fitted_pairs(np.sort(along), fitted)
    return _tested([*fits, *more], level, rng, workers) if more else found


def require_enough(problem: Problem, kind: str) -> None:
    """Raise `SettingError` if data are too few to distinguish an unknown force from other causes.

    They are of a kind, at a problem's speeds and channels. The message states what would be enough.
    """
    if not problem.takes_loads:
        problem.load_response(np.empty((0, len(problem.parameters))), ())
    if got := missing_to_locate(problem, kind):
        raise SettingError(
            "location: expected complex data of at least 3 channels, of which an unknown force takes 2 at each speed, got"
            f" {got}"
        )


def missing_to_locate(problem: Problem, kind: str) -> str:
    """Deficit of data that keeps them from distinguishing an unknown force from other causes.

    They are of a kind, at a problem's speeds and channels. Empty if the data are enough.
    """
    if not problem.takes_loads:
        return "a problem that takes no loads"
    n_channel = len(problem.channels)
    if kind == Observable.AMPLITUDE:
        more = ", at another plane or in both directions" if n_channel < 3 else ""
        return f"amplitudes of {n_channel}; measure phases too, so that the force can be eliminated{more}"
    if n_channel < 3:
        return f"{n_channel}; add a probe at another plane, or both directions there"
    if not leaves_enough(problem, len(DIRECTIONS)):
        left = 2 * (n_channel - len(DIRECTIONS)) * len(problem.speed)
        return f"{left} real data in addition to the force for {len(problem.parameters)} unknowns; measure more speeds"
    return ""


def leaves_enough(problem: Problem, n_free: int) -> bool:
    """Whether enough real numbers remain once `n_free` complex ones are eliminated at each speed.

    Enough is more than twice as many as there are unknowns, of complex data.
    """
    return 2 * (len(problem.channels) - n_free) * len(problem.speed) > 2 * len(problem.parameters)


def candidates(problem: Problem, quantities: Sequence[str], positions: Array) -> list[Unmodelled]:
    """Unknown quantities to try: loads at positions, readings at planes.

    Enough channels must remain to test them.
    """
    planes = dict.fromkeys(channel.position for channel in problem.channels)
    found = [
        Unmodelled(quantity, float(position))
        for quantity in quantities
        for position in (planes if quantity == READING else positions.tolist())
    ]
    return [unmodelled for unmodelled in found if len(unmodelled.named_columns(problem)) < len(problem.channels)]


def _tested(fits: Sequence[SiteFit], level: float, rng: np.random.Generator, workers: Workers) -> Location:
    """Fits, the plain one first, with the noise of the one that needs least of it."""
    for _ in range(REWEIGHTINGS):
        reference = min(fits, key=lambda fit: fit.point.excess)
        noise = _noise(reference)
        fits = _each_site(partial(_reweighted, noise=noise, reference=reference), fits, workers)
    fits = _each_site(_settled, fits, workers)
    qualities = site_qualities([fit.point for fit in fits], fits[0].likelihood.measurement, level, rng, workers)
    return Location(tuple(fits[1:]), tuple(qualities[1:]), fits[0], qualities[0], noise, level)


def _each_site(function: Callable[[SiteFit], SiteFit], fits: Sequence[SiteFit], workers: Workers) -> list[SiteFit]:
    """The fits that a function makes of fits; processes share them."""
    known = [
        thing for fit in fits for thing in (fit, fit.likelihood, fit.likelihood.problem, fit.likelihood.measurement)
    ]
    return workers.unseen.each(function, fits, known)


def _fits(
    case: Case, tried: Sequence[Unmodelled], rng: np.random.Generator, n_start: int, workers: Workers
) -> list[SiteFit]:
    """Fits of each quantity with weights from the data.

    They start all over the box and from the best that others found.
    """
    magnitude = np.abs(case.measurement.values)
    sd = np.hypot(magnitude, FIRST_FLOOR * np.median(magnitude))
    likelihoods = [ProjectedLikelihood(case, unmodelled, sd) for unmodelled in tried]
    starts = [_starts(case, unmodelled, rng, n_start) for unmodelled in tried]

    def fitted(index: int) -> SiteFit:
        return _best(likelihoods[index], starts[index])

    fits = workers.each(fitted, range(len(tried)), [case, case.problem, case.measurement, *likelihoods])
    for _ in range(SHARINGS):
        shared = [fit.point.theta for fit in sorted(fits, key=lambda fit: fit.point.excess)[:SHARED]]
        fits = _each_site(partial(_searched_from, starts=shared), fits, workers)
        workers.progress()
    return fits


def fitted_site(case: Case, unmodelled: Unmodelled, n_start: int) -> SiteFit:
    """One site by itself, with the noise that it needs."""
    [fit] = _fits(case, [unmodelled], np.random.default_rng(0), n_start, ALONE)
    return _reweighted(fit, _noise(fit), fit)


def _searched_from(fit: SiteFit, starts: Sequence[Array], ceiling: float = np.inf) -> SiteFit:
    """The better of a fit and one from those starts that are not taken to lie in its valley."""
    others = [theta for theta in starts if not is_in_valley(fit.likelihood, fit.point, theta)]
    fits = [fit, *([_best(fit.likelihood, others, ceiling)] if others else [])]
    return min(fits, key=lambda found: found.point.deviance)


def _starts(case: Case, unmodelled: Unmodelled, rng: np.random.Generator, n_start: int) -> Array:
    """Points (n, d) of the unit cube.

    With a free load any points will do: it absorbs the resonances, and with them the narrow basins. Without one, as
    with a free reading, there are as many basins as in the plain model, so that points are screened for.
    """
    problem, measurement = case.problem, case.measurement
    if unmodelled.loads:
        return sobol(n_start, len(problem.parameters), rng)
    kept = [index for index, channel in enumerate(problem.channels) if not unmodelled.reads(channel)]
    channels = tuple(problem.channels[index] for index in kept)
    part = dataclasses.replace(measurement, channels=channels, values=measurement.values[:, kept], noise=None)
    found = screened(Case(through(problem, channels), part), sobol(N_SCREENED, len(problem.parameters), rng))
    return found.apart(SCREENED_STARTS, START_DISTANCE).points


def _as_stated(case: Case) -> Case:
    """The case with numbers known to a tolerance held as they are stated; itself if all are exact."""
    problem = case.problem
    held = holding_inputs(problem, np.array([item.stated for item in problem.parameters]))
    return case if held is problem else case.by(held)


def _with_inputs(fit: SiteFit, case: Case) -> SiteFit:
    """Fit with numbers as stated, continued as a joint fit with these numbers known to their tolerances."""
    parameters = case.problem.parameters
    theta = parameters.to_cube(np.array([item.stated for item in parameters]))
    theta[parameters.own] = fit.point.theta
    likelihood = ProjectedLikelihood(case, fit.unmodelled, fit.likelihood.sd)
    return _best(likelihood, [theta], HOPELESS * fit.point.n_left)


def _best(likelihood: ProjectedLikelihood, starts: Sequence[Array] | Array, ceiling: float = np.inf) -> SiteFit:
    """The best of the maxima that starts lead to.

    If all leave more than `ceiling`, it is the best point on the way.
    """
    best, *_ = best_maxima(
        likelihood, list(starts), first_iterations=FIRST_ITERATIONS, survivors=SURVIVORS, ceiling=ceiling
    )
    return SiteFit(likelihood, likelihood.at(best.theta))


def _reweighted(fit: SiteFit, noise: Noise, reference: SiteFit) -> SiteFit:
    """The fit with the noise that its own response has, from where it is and from where the reference is."""
    return refitted(fit, noise.sd(np.abs(fit.point.mean)), reference.point.theta)


def refitted(fit: SiteFit, sd: Array, *starts: Array) -> SiteFit:
    """The fit with noise (n_speed, n_channel), m, of its data, from where it is and from other starts.

    Sites that are rejected anyway need no maximum.
    """
    ceiling = HOPELESS * fit.point.n_left
    return _searched_from(_best(fit.likelihood.with_sd(sd), [fit.point.theta], ceiling), starts, ceiling)


def _settled(fit: SiteFit) -> SiteFit:
    """Fit with unknowns that the data do not determine set to leave least to the free quantity.

    An unbalance at the very site is such an unknown: χ² does not depend on it.
    """
    likelihood, point = fit.likelihood, fit.point
    hidden = ~point.shown
    if not np.any(hidden):
        return fit
    adjoint = np.conj(np.swapaxes(point.basis, 1, 2))
    to_unit = adjoint @ (point.columns / likelihood.sd[..., None])  # what is free, in units of the noise at its columns
    theta = point.theta.copy()

    def left_to_it(values: Array) -> Array:
        theta[hidden] = values
        free = (to_unit @ likelihood.at(theta).free[..., None]).ravel()
        return as_real(free)

    theta[hidden] = least_squares(left_to_it, theta[hidden], bounds=(0.0, 1.0)).x
    return SiteFit(likelihood, likelihood.at(theta))


def _noise(fit: SiteFit) -> Noise:
    """The noise as it is known, or else as estimated from the residuals of a fit."""
    measurement = fit.likelihood.measurement
    if measurement.noise is not None:
        return measurement.noise
    point = fit.point
    measured, groups = fit.likelihood.measured, measurement.layout.noise_rows
    levels: list[tuple[float, float]] = []
    for rows in groups:
        residual, n_searched = (
            measured[rows] - point.response[rows],
            point.n_searched * (rows.stop - rows.start) / len(measured),
        )
        found = restricted_noise(residual, point.columns[rows], point.mean[rows], measured[rows], n_searched)
        levels += found.levels
    return Noise(*levels[0]) if len(groups) == 1 else Noise.of_runs(levels, groups)
