"""Start of the fit of a law: the coefficients that come nearest to the recovered force."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ksmea.arrays import Array, ComplexArray, as_real
from ksmea.location.recovered_force import RecoveredForce, recovered_force
from ksmea.location.unknown_force import SiteFit
from ksmea.nonlinear.laws import Law
from ksmea.numerics.screening import sobol

N_OTHER = 8  # values of each unknown that the data do not show, a power of two
N_WEIGHT = 50  # draws that weights are made of
N_UNSEEN = 32  # values of what the data do not show beside a free force that a law is compared at, a power of two
N_TOGETHER = 3  # of these, those from where it is found together with the law
UNSEEN = 1e-6  # of the largest singular value: directions of the unknowns that do not show


@dataclass(frozen=True)
class LawStart:
    """Start of the fit of a law at a site: unknowns in the unit cube, coefficients SI.

    `bic` is the BIC of the law as a model of the recovered force."""

    theta: Array
    coefficients: Array
    motion: ComplexArray  # of the site as recovered (n_speed, 2), m
    bic: float


def law_starts(site: SiteFit, laws: Iterable[Law]) -> list[list[LawStart]]:
    """Starts of each law at a site.

    They are of the fit there, and of the fit with other values of unknowns that it does not show.
    """
    recovered = [(each, _recovered(each)) for each in (site, *_others(site))]
    return [[_start(law, *each) for each in recovered] for law in laws]


def nearest_start(site: SiteFit, law: Law) -> LawStart:
    """Coefficients of a law nearest to the force at a site, with the unknowns that a free force hides.

    The data do not determine these unknowns if the force is free: an unbalance at the site itself changes the force,
    but not the motion."""
    site = _amid_unseen(site)
    likelihood, recovered, unseen = site.likelihood, _recovered(site), _unseen(site)
    k = unseen.shape[1]
    parts = sobol(N_UNSEEN, k) - 0.5 if k else np.zeros((1, 0))
    size, motion = np.array([each for _, _, each in law.coefficients]), _motion(recovered)
    spread = np.std(recovered.force[1:], axis=0)

    def at(part: Array) -> Array:
        return inside(site.point.theta + unseen @ part, likelihood.period)

    def left_over(values: Array) -> Array:
        acting = law.at_motion((values[: len(size)] * size)[None], likelihood.problem.speed, motion[None])
        left = (acting - likelihood.at(at(values[len(size) :])).free) / spread
        return np.asarray(_real_parts(left)[0])

    found = []
    for part in parts:
        coefficients, left = _nearest(law, likelihood.problem.speed, likelihood.at(at(part)).free, spread, motion)
        values = np.concatenate([coefficients / size, part])
        if np.all(np.isfinite(left_over(values))):
            found.append((left, values))
    if not found:
        raise np.linalg.LinAlgError("no finite force was found at the site")
    best = sorted(found, key=lambda each: each[0])[:N_TOGETHER]
    lower = np.concatenate([law.least, np.full(k, -np.inf)])
    fits = [least_squares(left_over, values, bounds=(lower, np.inf), x_scale="jac") for _, values in best]
    fit = min(fits, key=lambda each: float(each.cost))
    bic = 4 * fit.cost + len(size) * np.log(len(fit.fun))  # the cost is half of the sum of squares
    return LawStart(at(fit.x[len(size) :]), fit.x[: len(size)] * size, motion, float(bic))


def _amid_unseen(site: SiteFit) -> SiteFit:
    """The fit with unknowns that do not show in the middle of their limits.

    An unbalance without its size has no angle.
    """
    theta = np.where(site.point.shown, site.point.theta, 0.5)
    return SiteFit(site.likelihood, site.likelihood.at(theta))


def _unseen(site: SiteFit) -> Array:
    """Directions (d, k) in the unit cube along which the data do not change if the force is free."""
    _, sizes, directions = np.linalg.svd(site.point.whitened, full_matrices=False)
    return np.asarray(directions[sizes < UNSEEN * sizes.max()].T)


def inside(theta: Array, period: Array) -> Array:
    """Points (…, d) within the limits of the unit cube.

    Unknowns with a period as they come back there, about its middle.
    """
    turn = np.where(np.isfinite(period), period, 1.0)
    turned = 0.5 + (theta - 0.5 + turn / 2) % turn - turn / 2
    return np.clip(np.where(np.isfinite(period), turned, theta), 0.0, 1.0)


def _motion(recovered: RecoveredForce) -> ComplexArray:
    return np.zeros_like(recovered.force[0]) if recovered.motion is None else recovered.motion[0]


def _others(site: SiteFit) -> list[SiteFit]:
    """The fit with other values of unknowns that data show with a law at most, not with a free force."""
    hidden = ~site.point.shown
    if not np.any(hidden):
        return []
    found = []
    for values in sobol(N_OTHER, int(hidden.sum())) + 0.5 / N_OTHER:
        theta = site.point.theta.copy()
        theta[hidden] = values
        found.append(SiteFit(site.likelihood, site.likelihood.at(theta)))
    return found


def _recovered(site: SiteFit) -> RecoveredForce:
    return recovered_force(site, np.random.default_rng(0), n_draw=N_WEIGHT)


def _start(law: Law, site: SiteFit, recovered: RecoveredForce) -> LawStart:
    """Coefficients nearest to the force as it was recovered, each speed weighted by its precision."""
    motion, speed = _motion(recovered), site.likelihood.problem.speed
    coefficients, left = _nearest(law, speed, recovered.force[0], np.std(recovered.force[1:], axis=0), motion)
    n_real = 2 * recovered.force[0].size
    bic = 2 * left + len(coefficients) * np.log(n_real)  # the spread is that of real and imaginary part together
    return LawStart(site.point.theta, coefficients, motion, float(bic))


def _nearest(law: Law, speed: Array, target: ComplexArray, spread: Array, motion: ComplexArray) -> tuple[Array, float]:
    """Coefficients nearest to a force (n_speed, 2), and the remaining sum of squares.

    It is in units of the spread of the force.
    """

    def whitened(coefficients: Array) -> Array:
        """Forces of coefficients (n, n_coefficient), in units of their spread, as real numbers (n, m)."""
        force = law.at_motion(coefficients, speed, np.broadcast_to(motion, (len(coefficients), *motion.shape)))
        return _real_parts(force / spread)

    [goal] = _real_parts(target[None] / spread)
    tried = law.starts(speed, np.linalg.norm(motion, axis=-1))
    if tried is None:
        coefficients = np.linalg.lstsq(whitened(np.eye(len(law.coefficients))).T, goal)[0]
    else:
        coefficients = _from_best(law, whitened, goal, tried)
    left = whitened(coefficients[None])[0] - goal
    return coefficients, float(left @ left)


def _from_best(law: Law, force: Callable[[Array], Array], goal: Array, tried: Array) -> Array:
    """Coefficients of a law that is linear in the first alone, its size.

    Each of the tried sets gets the best size for it; the best set is refined in all coefficients."""
    forces = force(tried)
    tried[:, 0] = forces @ goal / np.maximum(np.sum(forces**2, axis=1), np.finfo(float).tiny)
    tried = np.maximum(tried, law.least)
    left = np.sum((tried[:, :1] * forces - goal) ** 2, axis=1)
    best = tried[np.nanargmin(left)]
    size = np.array([each for _, _, each in law.coefficients])

    def left_over(values: Array) -> Array:
        return np.asarray(force((values * size)[None])[0] - goal)

    return np.asarray(size * least_squares(left_over, best / size, bounds=(law.least, np.inf)).x)


def _real_parts(force: ComplexArray) -> Array:
    """Complex forces (n, n_speed, 2) as real numbers (n, m)."""
    return as_real(force.reshape(len(force), -1))
