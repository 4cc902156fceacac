"""Where the fit of a law starts: at the coefficients that come nearest to the force as it was recovered."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ksmea.arrays import Array, ComplexArray
from ksmea.diagnosis.recovered_force import RecoveredForce, recovered_force
from ksmea.diagnosis.unknown_force import SiteFit
from ksmea.force_laws import Law
from ksmea.screening import sobol

N_OTHER = 8  # values of each unknown that the data do not show, a power of two
N_WEIGHT = 50  # draws that weights are made of
N_THRESHOLD = 12  # amplitudes that a search for a threshold starts from


@dataclass(frozen=True)
class LawStart:
    """Where the fit of a law at a site starts: unknowns in the unit cube, coefficients SI; `bic` is that of the law as a model of
    the recovered force."""

    theta: Array
    coefficients: Array
    motion: ComplexArray  # of the site as recovered (n_speed, 2), m
    bic: float


def law_starts(site: SiteFit, laws: Iterable[Law]) -> list[list[LawStart]]:
    """Starts of each law at a site: of the fit there, and of the same with other values of what it does not show."""
    recovered = [(each, _recovered(each)) for each in (site, *_others(site))]
    return [[_start(law, *each) for each in recovered] for law in laws]


def _others(site: SiteFit) -> list[SiteFit]:
    """The fit with other values of unknowns that the data do not show beside a free force, but may beside a law."""
    hidden = ~np.any(site.point.whitened, axis=0)
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
    """The coefficients that come nearest to the force as it was recovered, each speed weighed as it is known."""
    speed, target = site.likelihood.problem.speed, recovered.force[0]
    spread = np.std(recovered.force[1:], axis=0)
    motion = np.zeros_like(target) if recovered.motion is None else recovered.motion[0]

    def whitened(coefficients: Array) -> Array:
        """Forces of coefficients (n, n_coefficient), in units of their spread, as real numbers (n, m)."""
        force = law.at_motion(coefficients, speed, np.broadcast_to(motion, (len(coefficients), *motion.shape)))
        return _real_parts(force / spread)

    [goal] = _real_parts(target[None] / spread)
    n_coefficient = len(law.coefficients)
    if law.threshold is None:
        columns = whitened(np.eye(n_coefficient))
        coefficients = np.linalg.lstsq(columns.T, goal)[0]
    else:
        coefficients = _with_threshold(law, whitened, goal, np.linalg.norm(motion, axis=-1))
    left = whitened(coefficients[None])[0] - goal
    bic = 2 * left @ left + n_coefficient * np.log(len(goal))  # the spread is that of real and imaginary part together
    return LawStart(site.point.theta, coefficients, motion, float(bic))


def _with_threshold(law: Law, force: Callable[[Array], Array], goal: Array, amplitude: Array) -> Array:
    """The coefficients of a law that acts above an amplitude only: its first one is its size, and what is neither that nor the
    threshold is zero at first. The best of several thresholds is refined with all of them."""
    tried = np.zeros((N_THRESHOLD, len(law.coefficients)))
    tried[:, 0] = 1.0
    tried[:, law.threshold] = np.quantile(amplitude, np.arange(N_THRESHOLD) / N_THRESHOLD)
    forces = force(tried)
    tried[:, 0] = forces @ goal / np.maximum(np.sum(forces**2, axis=1), np.finfo(float).tiny)
    left = np.sum((tried[:, :1] * forces - goal) ** 2, axis=1)
    best = tried[np.argmin(left)]
    size = np.array([each for _, _, each in law.coefficients])
    lower = np.where(np.arange(len(size)) == law.threshold, 0.0, -np.inf)

    def left_over(values: Array) -> Array:
        return np.asarray(force((values * size)[None])[0] - goal)

    return np.asarray(size * least_squares(left_over, best / size, bounds=(lower, np.inf)).x)


def _real_parts(force: ComplexArray) -> Array:
    """Complex forces (n, n_speed, 2) as real numbers (n, m)."""
    flat = force.reshape(len(force), -1)
    return np.concatenate([flat.real, flat.imag], axis=1)
