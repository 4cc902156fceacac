"""Influence coefficients and covariance from runs with known weights, by generalised least squares.

The covariance of a run's entries is estimated by a `method` that depends on how many more runs there are than the
coefficients take: `free` estimates all of it, with a drift over time and a growth with the weights if the data require them;
`common` one factor on what `sigma_um`, repeats or nothing says of the entries; `stated` and `repeats` take that as it is;
`none` leaves intervals out.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from scipy.linalg import cho_factor, cho_solve

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.balancing.influence import Influence, plain_influence, tell_planes_apart
from ksmea.balancing.readings import Readings
from ksmea.balancing.variance import Components, RestrictedLikelihood
from ksmea.errors import SettingError

FREE, COMMON, STATED, REPEATS, NONE = "free", "common", "stated", "repeats", "none"
RUNS_PER_ENTRY = 2  # complex degrees of freedom per entry from which a free covariance is estimated
N_SIZES = 3  # different sizes of weights from which growth with them is asked for
N_ITERATION = 3  # Gauss–Newton steps, each with new variance components
SEARCH = 1  # the step, from 0, at which τ and κ are searched for too: they take most of the time
SLOPE_LEVEL = 0.01  # p below which a slope with speed or a growth with size is kept
UNMEASURED = 1e12  # variance of a missing entry, in units of the largest of the spread: its value plays no part
SMALLEST_DEVIATION = 1e-5  # of speeds: below it there is nothing to find a slope from
AUTO, YES, NO = "auto", "yes", "no"


@dataclass(frozen=True)
class Terms:
    """Terms of the model in addition to constant influence coefficients."""

    slope: bool = False
    growth: bool = False


@dataclass(frozen=True)
class Fit:
    """Fit of influence coefficients to runs.

    `used` are the runs that it was fitted to. `dof` are complex degrees of freedom of the covariance, inf if it is
    known. `deviance_of_drift` is by how much the drift lowers −2 ln L, None if there was no choice.
    """

    readings: Readings
    used: Indices
    influence: Influence
    terms: Terms
    components: Components
    method: str
    dof: float
    deviance_of_drift: float | None = None

    @property
    def is_free(self) -> bool:
        """Whether the covariance is estimated from the runs, all of it."""
        return self.method == FREE

    @property
    def load(self) -> Array:
        """Σ |w|² / scale² of every run; unknown weights count as none."""
        return np.asarray(np.sum(np.abs(np.nan_to_num(self.readings.weights) / self.influence.scale) ** 2, axis=1))

    def covariance(self, runs: Indices, others: Indices) -> ComplexArray:
        """Covariance of the responses of runs with the responses of others, both flat over runs and entries."""
        equal = runs[:, None] == others
        found = np.kron(equal * self.components.factor(self.load[runs])[:, None], self.components.spread)
        n_entry = len(self.components.spread)
        by_entry = found.reshape(len(runs), n_entry, len(others), n_entry)
        first, second = np.nonzero(equal)
        pair, entry = np.nonzero(self.readings.is_missing[runs[first]])
        unmeasured = UNMEASURED * np.max(self.components.spread.real)
        by_entry[first[pair], entry, second[pair], entry] += unmeasured
        time, drift = self.readings.time, self.components.drift
        if drift is not None and time is not None:
            found = found + np.kron(self.components.correlation(time[runs], time[others]), drift)
        return np.asarray(found)

    def columns(self, runs: Indices, weights: ComplexArray) -> ComplexArray:
        return self.influence.columns(weights, self.readings.deviation[runs], self.terms.slope, self.terms.growth)

    def residual(self, runs: Indices) -> ComplexArray:
        weights, deviation = self.readings.weights[runs], self.readings.deviation[runs]
        left = self.readings.response[runs] - self.influence.response(weights, deviation)
        return np.where(self.readings.is_missing[runs], 0, left)

    @cached_property
    def solution(self) -> Solution:
        return Solution(self, self.used)

    @property
    def coefficient_covariance(self) -> ComplexArray:
        """Covariance of bare response and influence coefficients, flat, then of slopes and growth."""
        return self.solution.coefficient_covariance

    @property
    def coefficient_relation(self) -> ComplexArray:
        """E[δ δᵀ] of their errors: 0, they are circular."""
        return np.zeros_like(self.coefficient_covariance)

    def without(self, runs: Indices) -> Fit:
        """The influence coefficients of the other runs, at the same variance components."""
        fit = dataclasses.replace(self, used=np.setdiff1d(self.used, runs))
        step = fit.solution.step
        return dataclasses.replace(fit, influence=self.influence.stepped(step, self.terms.slope, self.terms.growth))


class Solution:
    """Generalised least squares of a fit's residuals on its columns, of the runs used."""

    def __init__(self, fit: Fit, runs: Indices) -> None:
        self.fit, self.runs = fit, runs
        columns = fit.columns(runs, fit.readings.weights[runs])
        self.columns = columns.reshape(-1, columns.shape[2])
        self._factor = cho_factor(fit.covariance(runs, runs), lower=True)
        residual = fit.residual(runs).reshape(-1)
        self.columns_solved = weighted = cho_solve(self._factor, self.columns)
        self.coefficient_covariance = np.asarray(np.linalg.inv(self.columns.conj().T @ weighted), dtype=np.complex128)
        self.step = self.coefficient_covariance @ (weighted.conj().T @ residual)
        self.left = residual - self.columns @ self.step
        self.white = cho_solve(self._factor, self.left)

    def solve(self, right: ComplexArray) -> ComplexArray:
        return np.asarray(cho_solve(self._factor, right))


@dataclass(frozen=True)
class Asked:
    """Terms to fit in addition to constant influence coefficients.

    Yes, no or auto, if the data require it.
    """

    drift: str = AUTO
    slope: str = AUTO
    growth: str = AUTO


def fitted(readings: Readings, used: Indices, asked: Asked) -> Fit:
    """The fit to runs with known weights.

    All of the covariance is estimated from runs with all speeds, or none of it.

    Raises `SettingError` if the runs do not distinguish the planes, or cannot show a requested drift.
    """
    weights, is_missing = readings.weights[used], readings.is_missing[used]
    _require_rank(readings, weights)
    n_entry, n_coefficient = is_missing.shape[1], 1 + weights.shape[1]
    complete = np.flatnonzero(readings.is_complete[used])
    dof = len(complete) - n_coefficient
    influence = plain_influence(
        readings.response[used], is_missing, weights, readings.speed_of_entry, len(readings.speed)
    )
    left = readings.response[used] - influence.response(weights, readings.deviation[used])
    left[is_missing] = 0
    if dof < RUNS_PER_ENTRY * n_entry:
        if asked.drift == YES:
            raise SettingError(
                f"study.drift: expected {RUNS_PER_ENTRY * n_entry + 1 + weights.shape[1]} runs with known weights or more and all"
                f" speeds to see a drift of {n_entry} entries, got {len(complete)}; leave it out"
            )
        return _few_runs(readings, used, influence, left, int(np.sum(~is_missing)) - n_entry * n_coefficient)
    spread = left[complete].T @ left[complete].conj() / dof
    plain = Fit(readings, used, influence, Terms(), Components(None, spread, 1.0, 0.0), FREE, float(dof))
    return _with_components(plain, asked)


def _require_rank(readings: Readings, weights: ComplexArray) -> None:
    n_plane = weights.shape[1]
    if not tell_planes_apart(weights):
        raise SettingError(
            f"balance: expected runs with known weights that tell {n_plane} planes and the bare rotor apart"
            f" ({1 + n_plane} or more that differ), got {len(weights)}; add a run with a weight in each plane alone"
        )


def _few_runs(readings: Readings, used: Indices, influence: Influence, left: ComplexArray, dof: int) -> Fit:
    """The covariance of uncorrelated entries, for runs that are too few to estimate all of it.

    `dof` complex numbers are left of all entries.
    """
    n_entry = left.shape[1]
    square = float(np.mean(np.abs(readings.response[~readings.is_missing]) ** 2))
    if readings.variance is not None:
        base, method, of_base = np.nanmean(readings.variance[used], axis=0), STATED, np.inf
    elif readings.repeat_variance is not None:
        base, method, of_base = readings.repeat_variance, REPEATS, float(readings.repeat_dof * n_entry)
    else:
        base, method, of_base = np.full(n_entry, square), NONE, 0.0
    base = np.maximum(base, 1e-12 * square)  # digits of a file
    if dof > 0:
        base = base * np.sum(np.abs(left) ** 2 / base) / dof
        method, of_base = COMMON, float(dof)
    components = Components(None, np.diag(base).astype(complex), 1.0, 0.0)
    return Fit(readings, used, influence, Terms(), components, method, of_base)


def _with_components(plain: Fit, asked: Asked) -> Fit:
    """Drift by likelihood (BIC), then slopes and growth as far as they are larger than chance."""
    readings = plain.readings
    sizes = np.unique(np.round(np.abs(readings.weights[plain.used]) / plain.influence.scale, 6))
    can_grow = len(sizes) > N_SIZES  # one of them is 0
    moves = bool(np.max(np.std(readings.deviation[plain.used], axis=0)) > SMALLEST_DEVIATION)
    if asked.drift == YES and readings.time is None:
        raise SettingError(
            "study.drift: expected a column time_s in the files, got none; add it, or leave the drift out"
        )
    terms = Terms(moves and asked.slope != NO, can_grow and asked.growth != NO)
    without = _iterated(dataclasses.replace(plain, terms=terms), can_grow, N_ITERATION)
    fit, value = without
    gained = None
    if asked.drift != NO and readings.time is not None:
        fit, value = _iterated(_started_with_drift(without[0]), can_grow, N_ITERATION)
        n_entry, n_speed = readings.response.shape[1], len(readings.speed)
        gained = 2 * (without[1] - value)
        if asked.drift == AUTO and gained < (n_speed**2 + (n_entry // n_speed) ** 2) * np.log(
            2 * len(plain.used) * n_entry
        ):
            fit = without[0]
    kept = Terms(
        terms.slope and (asked.slope == YES or slope_p(fit) < SLOPE_LEVEL),
        terms.growth and (asked.growth == YES or growth_p(fit) < SLOPE_LEVEL),
    )
    if kept != terms:
        influence = dataclasses.replace(
            fit.influence,
            slope=fit.influence.slope if kept.slope else 0 * fit.influence.slope,
            growth=fit.influence.growth if kept.growth else 0j,
        )
        fit, _ = _iterated(dataclasses.replace(fit, influence=influence, terms=kept), can_grow, 1)
    return dataclasses.replace(fit, deviance_of_drift=gained)


def _started_with_drift(fit: Fit) -> Fit:
    """Half of the spread as a drift, over a tenth of the campaign."""
    time = fit.readings.time
    assert time is not None
    half = fit.components.spread / 2
    return dataclasses.replace(
        fit, components=Components(half, half, float(np.ptp(time[fit.used])) / 10, fit.components.growth)
    )


def _iterated(fit: Fit, can_grow: bool, n: int) -> tuple[Fit, float]:
    """Variance components and Gauss–Newton steps in turn; the last −ln L."""
    value = np.inf
    for number in range(n):
        runs = fit.used[fit.readings.is_complete[fit.used]]
        time = None if fit.readings.time is None else fit.readings.time[runs]
        likelihood = RestrictedLikelihood(
            fit.residual(runs),
            fit.columns(runs, fit.readings.weights[runs]),
            time,
            fit.load[runs],
            len(fit.readings.speed),
        )
        start = dataclasses.replace(fit.components, growth=max(fit.components.growth, 0.1) if can_grow else 0.0)
        components, value = likelihood.fitted(start, searched=number == SEARCH and can_grow, timed=number == SEARCH)
        fit = dataclasses.replace(fit, components=components)
        influence = fit.influence.stepped(fit.solution.step, fit.terms.slope, fit.terms.growth)
        fit = dataclasses.replace(fit, influence=influence)
    return fit, value


def slope_p(fit: Fit) -> float:
    """p of the slopes of all speeds together, were there none."""
    n = len(fit.readings.speed)
    last = fit.solution.coefficient_covariance.shape[0] - fit.terms.growth
    return _wald(fit.influence.slope, fit.solution.coefficient_covariance[last - n : last, last - n : last])


def growth_p(fit: Fit) -> float:
    """p of the growth with the size of weights, were there none."""
    return _wald(np.array([fit.influence.growth]), fit.solution.coefficient_covariance[-1:, -1:])


def _wald(values: ComplexArray, covariance: ComplexArray) -> float:
    statistic = 2 * np.vdot(values, np.linalg.solve(covariance, values)).real
    return float(scipy.stats.chi2.sf(statistic, 2 * len(values)))


def refitted(fit: Fit) -> Fit:
    """The fit's terms fitted to the runs used now, τ and κ unchanged."""
    return _iterated(fit, fit.components.growth > 0, 1)[0]
