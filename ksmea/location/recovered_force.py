"""Recovered force over speed with uncertainty, motion of its site, work; intervals of the unknowns.

Its uncertainty has two parts: the noise of the data at each speed, and the unknowns of the model, which move it at all
speeds together. Both are drawn from their normal distributions, linearised about the fit; quantities of the force and the motion
of its site (whirl, work, dynamic stiffness) have the quantiles of these draws.

Sign convention: a real force is Re(f e^{iΩt}), so that over a turn it does the work π Im(q* f) on a motion q: above zero it
feeds the motion, below it takes from it (a damper's f = −iΩc q does −πΩc|q|²). Forward and backward parts are (f_x + i f_y)/2
and (f_x − i f_y)/2. A spring k pushes back with f = −k q: the dynamic stiffness of the force is −f/q.

Intervals of the model's own unknowns come from the profile of the deviance, with the force free at each speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray
from ksmea.inference.intervals import Interval, checked_intervals, in_si, information_interval
from ksmea.location.location import HOPELESS
from ksmea.location.unknown_force import SiteFit
from ksmea.measurement.channel import DIRECTIONS, Channel
from ksmea.numerics.differences import cube_differences
from ksmea.problem.alignment import through
from ksmea.problem.load import FORCE
from ksmea.records.location import UNSEEN

N_DRAW = 1000
WHIRL = np.array([[1, 1j], [1, -1j]]) / 2  # forward and backward from x and y
N_POWER = 3  # of speed, in a stiffness that a force is compared with: as of a spring, a damper and a mass
WHIRLS = ("forward", "backward")


@dataclass(frozen=True)
class RecoveredForce:
    """The force (1 + n_draw, n_speed, k), N or N m, or the reading, m: the estimate first, then the draws.

    `columns` has direction and unit of each of the k. `motion` (1 + n_draw, n_speed, 2) is the motion of its site in x
    and y, m, if it is a force; `speed` (n_speed,) rad/s.
    """

    force: ComplexArray
    columns: tuple[tuple[str, str], ...]
    motion: ComplexArray | None
    speed: Array

    @property
    def names(self) -> tuple[tuple[str, str], ...]:
        """Part and unit of each of `parts`."""
        whirls = tuple((whirl, self.columns[0][1]) for whirl in WHIRLS) if self._is_lateral else ()
        return (*self.columns, *whirls)

    @property
    def _is_lateral(self) -> bool:
        """Whether it is an x and a y of one thing."""
        return tuple(direction for direction, _ in self.columns) == DIRECTIONS

    @property
    def parts(self) -> ComplexArray:
        """x, y, forward and backward, (1 + n_draw, n_speed, 4); without whirl where that is not an x and a y."""
        return with_whirl(self.force) if self._is_lateral else self.force

    @property
    def work(self) -> Array | None:
        """J per turn that it does on the motion of its site, (1 + n_draw, n_speed)."""
        if self.motion is None:
            return None
        return np.asarray(np.pi * np.sum((np.conj(self.motion) * self.force).imag, axis=2))

    @property
    def dynamic_stiffness(self) -> ComplexArray | None:
        """−f/q in x, y, forward and backward, (1 + n_draw, n_speed, 4) N/m.

        It is the equivalent of the force if it follows the motion of its site in that direction alone.
        """
        return None if self.motion is None else np.asarray(-self.parts / with_whirl(self.motion))

    @property
    def coherence(self) -> Array | None:
        """Coherence of the force with a dynamic stiffness times the motion, in four directions, (4,).

        They are x, y, forward and backward. 1 if it is so at all speeds, 0 if it does not follow at all. The stiffness
        may be any complex parabola over speed, as a spring, a damper and a mass make one; each speed weighs as the
        force is known there, and what is noise in it counts on neither side.
        """
        if self.motion is None:
            return None
        motion, spread = with_whirl(self.motion)[0], np.std(self.parts[1:], axis=0)
        return np.array([_followed(self.speed, *each) for each in zip(self.parts[0].T, motion.T, spread.T)])


def recovered_force(fit: SiteFit, rng: np.random.Generator, n_draw: int = N_DRAW) -> RecoveredForce:
    """Unknown quantity at a site, as fitted, and draws of it.

    If the noise is not known, it is as large as the site's residuals.
    """
    point, sd = fit.point, fit.likelihood.sd[..., None]
    adjoint = np.conj(np.swapaxes(point.basis, 1, 2))
    solve = np.linalg.inv(adjoint @ (point.columns / sd)) @ adjoint  # Ã⁺ (n_speed, k, n_channel)
    moved = np.concatenate([np.zeros((1, fit.likelihood.d)), unknowns_drawn(fit, rng, n_draw)])
    real, imaginary = own_noise(fit) * rng.standard_normal((2, n_draw, *point.mean.shape)) / np.sqrt(2)
    noise = np.concatenate([np.zeros((1, *point.mean.shape)), real + 1j * imaginary])
    free = np.einsum("skc,nsc->nsk", solve, noise - np.einsum("scd,nd->nsc", point.change / sd, moved))
    problem = fit.likelihood.problem
    return RecoveredForce(
        point.free + free, fit.unmodelled.named_columns(problem), _motion(fit, moved, free), problem.speed
    )


def unknowns_drawn(fit: SiteFit, rng: np.random.Generator, n_draw: int) -> Array:
    """Draws (n_draw, d) of the errors of the unknowns in the unit cube.

    They go beyond a limit that an unknown lies on: held there it would lend the force its certainty. Unknowns that the
    data do not determine stay.
    """
    whitened, moves = fit.point.whitened, fit.point.shown
    drawn = np.zeros((n_draw, fit.likelihood.d))
    triangle = np.linalg.qr(whitened[:, moves], mode="r")
    noise = own_noise(fit) * rng.standard_normal((len(triangle), n_draw))
    drawn[:, moves] = np.linalg.lstsq(triangle, noise, rcond=1e-10)[0].T
    return drawn


def own_noise(fit: SiteFit) -> float:
    """Noise level of a site's own residuals, relative to the noise of the fits; 1 if the noise is known."""
    return 1.0 if fit.likelihood.measurement.noise is not None else float(np.sqrt(fit.point.excess))


def with_whirl(lateral: ComplexArray) -> ComplexArray:
    """x and y (…, 2), and behind them forward and backward."""
    return np.concatenate([lateral, lateral @ WHIRL.T], axis=-1)


def _followed(speed: Array, force: ComplexArray, motion: ComplexArray, spread: Array) -> float:
    """The part of a force (n_speed,) that a parabola over speed times the motion explains."""
    powers = (speed[:, None] / np.max(speed)) ** np.arange(N_POWER)
    columns = motion[:, None] * powers / spread[:, None]
    target = force / spread
    left = target - columns @ np.linalg.lstsq(columns, target)[0]
    beyond_noise = np.sum(np.abs(target) ** 2) - len(force)
    if beyond_noise < len(force):  # no more than the noise itself
        return 0.0
    unexplained = max(np.sum(np.abs(left) ** 2) - (len(force) - N_POWER), 0.0)
    return float(max(1 - unexplained / beyond_noise, 0.0))


def _motion(fit: SiteFit, moved: Array, free: ComplexArray) -> ComplexArray | None:
    """Motion of a force's site in x and y as fitted, with perturbed unknowns and force.

    The perturbations are (n, d) and (n, n_speed, k).
    """
    unmodelled, problem, theta = fit.unmodelled, fit.likelihood.problem, fit.point.theta
    if unmodelled.quantity != FORCE:
        return None
    seen = through(problem, [Channel(unmodelled.position, axis) for axis in DIRECTIONS])
    differences = cube_differences(theta)
    x = problem.parameters.to_si(np.concatenate([theta[None], differences.points]))
    columns = unmodelled.columns(seen, x)
    motion = seen.response(x) + np.einsum("nsck,sk->nsc", columns, fit.point.free)
    change = differences.derivative(motion[1:])
    return np.asarray(motion[0] + np.einsum("scd,nd->nsc", change, moved) + np.einsum("sck,nsk->nsc", columns[0], free))


def site_intervals(fit: SiteFit, level: float) -> list[Interval]:
    """An interval of confidence `level` for each unknown, SI.

    If the noise is not known, its level is taken from this site's own residuals, whatever other sites need: the
    quantile is of the F distribution. Unknowns that the data do not show there are `UNSEEN`. Intervals of a model that
    is far from the data are not checked.
    """
    if fit.likelihood.measurement.noise is None:
        likelihood = fit.likelihood.with_sd(own_noise(fit) * fit.likelihood.sd)
        rise = float(scipy.stats.f.ppf(level, 1, fit.point.n_left))
    else:
        likelihood = fit.likelihood
        rise = float(scipy.stats.chi2.ppf(level, 1))
    point, intervals = likelihood.at(fit.point.theta), None
    if fit.point.excess <= HOPELESS:
        own = likelihood.problem.parameters.own
        _, intervals = checked_intervals(likelihood, [point], np.full((1, likelihood.d), rise), profiled=own)
    if intervals is None:
        intervals = [information_interval(likelihood, point, index, rise) for index in range(likelihood.d)]
    seen = point.shown
    return [
        in_si(interval, item.lower, item.upper) if is_seen else Interval(-np.inf, np.inf, UNSEEN)
        for item, interval, is_seen in zip(likelihood.problem.parameters, intervals, seen)
    ]
