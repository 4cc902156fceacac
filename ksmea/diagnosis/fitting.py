"""Fits of a problem, plain or extended by effects, to a measurement: the likelihood's maximum from many starts.

The sharp peaks of a lightly damped rotor give the likelihood many maxima, and what a model lacks moves the right one. So
starts come from a screening: batches of points ranked by the mean |ln ratio| of amplitudes, a misfit with wide basins,
after the common factor of all unbalance and the common phase, which act on all data alike, have been set to what suits
the data best. An effect's own unknowns are scanned on a grid, each value with a screening of its own, and fits start from
the best of these as well as from where the plain model fits best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import qmc

from ksmea.contracts import PHASE_ORIGIN, ComplexArray, Problem
from ksmea.likelihood import Likelihood, Point, maximise
from ksmea.measurement import Measurement, Noise
from ksmea.model import Model
from ksmea.parameters import TURN, Array

MOST_VALUES = 2**21  # complex numbers of a batch of responses, which bounds the memory
CLOSE = 1e-2  # two maxima with deviances as near as this are one


@dataclass(frozen=True)
class Effort:
    """How hard fits are sought."""

    screening: int = 4000  # points of the plain model that are screened
    scan: int = 300  # of these, the best that are screened again at each value of an effect
    starts: int = 12  # fits of the plain model
    effect_starts: int = 5  # fits of an extended one from a scan of its effect
    first_iterations: int = 8  # after which only the best of them go on
    survivors: int = 2


@dataclass(frozen=True)
class Fit:
    """A problem at the maximum of its likelihood."""

    problem: Problem
    likelihood: Likelihood
    point: Point

    @property
    def deviance(self) -> float:
        return self.point.deviance

    @property
    def u(self) -> Array:
        """The unknowns in the unit cube (d,)."""
        return self.point.theta[: self.likelihood.d]

    @property
    def x(self) -> Array:
        """The unknowns (d,) SI."""
        return self.problem.parameters.to_si(self.u)

    @property
    def noise(self) -> Noise:
        return self.likelihood.noise(self.point.theta)

    def response(self) -> ComplexArray:
        """(n_speed, n_channel), m."""
        return self.problem.response(self.x[None])[0]


@dataclass(frozen=True)
class PlainFits:
    """The best fit of the plain model, the other maxima that were found, and the screened points, best first."""

    best: Fit
    others: tuple[Fit, ...]
    screened: Array  # (n, d)


def fit_plain(problem: Problem, measurement: Measurement, rng: np.random.Generator, effort: Effort) -> PlainFits:
    """The plain model fitted from the best points of a screening of its whole box."""
    d = len(problem.parameters)
    points = qmc.Sobol(d, rng=rng).random_base2((effort.screening - 1).bit_length())
    points, values = _screened(problem, measurement, points)
    points = points[np.argsort(values, kind="stable")]
    likelihood = Likelihood(Model(problem), measurement)
    starts = [likelihood.start(u) for u in _apart(points, effort.starts)]
    maxima = [with_best_noise(likelihood, point) for point in _best_maxima(likelihood, starts, effort)]
    maxima.sort(key=lambda point: point.deviance)
    fits = [Fit(problem, likelihood, point) for point in maxima]
    return PlainFits(fits[0], tuple(fits[1:]), points[: effort.scan])


def fit_nearby(problem: Problem, measurement: Measurement, plain: Fit) -> Fit:
    """A problem whose last unknowns are those of effects, 0 where there is no effect, fitted jointly with all others
    from where the plain model fits."""
    likelihood = Likelihood(Model(problem), measurement)
    d = plain.likelihood.d
    start = np.concatenate([plain.u, without_effects(problem, d), plain.point.theta[d:]])
    return Fit(problem, likelihood, maximise(likelihood, start, tolerance=1e-4))


def fit_from_scan(problem: Problem, measurement: Measurement, plain: PlainFits, effort: Effort) -> Fit:
    """The same from the best points of screenings at values of the effects all over their bounds, and from other maxima
    of the plain model."""
    likelihood = Likelihood(Model(problem), measurement)
    zero = without_effects(problem, plain.best.likelihood.d)
    starts = [np.concatenate([fit.u, zero]) for fit in plain.others]
    starts += list(_scanned(problem, measurement, plain.screened, zero, effort.effect_starts))
    maxima = _best_maxima(likelihood, [likelihood.start(u) for u in starts], effort)
    return Fit(problem, likelihood, maxima[0])


def fit_from(problem: Problem, measurement: Measurement, starts: Sequence[Fit], d: int) -> Fit:
    """The same from where other fits have the plain model's d unknowns, without any effect."""
    likelihood = Likelihood(Model(problem), measurement)
    zero = without_effects(problem, d)
    points = [
        maximise(likelihood, likelihood.start(np.concatenate([fit.u[:d], zero])), tolerance=1e-4) for fit in starts
    ]
    return Fit(problem, likelihood, min(points, key=lambda point: point.deviance))


def without_effects(problem: Problem, d: int) -> Array:
    """Where in the unit cube the unknowns behind the first d are 0."""
    return problem.parameters.to_cube(np.zeros(len(problem.parameters)))[d:]


def scan_values(problem: Problem, zero: Array) -> Array:
    """Values (n, e) of an effect's unknowns in the unit cube to start from: on each axis alone to both sides of 0, near
    and far, and where there are several also off the axes."""
    e = len(zero)
    room = np.stack([-zero, 1 - zero])  # to the lower and the upper bound
    reaches = np.array([0.04, 0.15, 0.35, 0.7])
    on_axes = [
        zero + reach * side[axis] * np.eye(e)[axis]
        for axis in range(e)
        for side in room
        if abs(side[axis]) > 1e-9
        for reach in reaches
    ]
    if e == 1:
        return np.array(on_axes)
    signs = np.array(np.meshgrid(*[[0, 1]] * e)).reshape(e, -1).T
    corners = np.array([[room[sign, axis] for axis, sign in enumerate(row)] for row in signs])
    off_axes = [zero + reach * corner for corner in np.unique(corners, axis=0) for reach in (0.1, 0.4)]
    return np.array(on_axes + off_axes)


def _scanned(problem: Problem, measurement: Measurement, screened: Array, zero: Array, count: int) -> Array:
    """The best points (≤ count, d + e) of screenings at each scanned value of the effects' unknowns, at most two each."""
    best: list[tuple[float, Array]] = []
    for value in scan_values(problem, zero):
        points, misfits = _screened(problem, measurement, np.hstack([screened, np.tile(value, (len(screened), 1))]))
        best += [(misfits[index], points[index]) for index in np.argsort(misfits, kind="stable")[:2]]
    best.sort(key=lambda pair: pair[0])
    return np.array([point for _, point in best[:count]])


def _screened(problem: Problem, measurement: Measurement, points: Array) -> tuple[Array, Array]:
    """Points (n, d), the common factor of all unbalance and the common phase set to what suits the data, and their mean
    |ln ratio| of amplitudes (n,)."""
    n_chunk = max(1, MOST_VALUES // measurement.values.size)
    parts = [
        _screened_chunk(problem, measurement, points[start : start + n_chunk])
        for start in range(0, len(points), n_chunk)
    ]
    return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])


def _screened_chunk(problem: Problem, measurement: Measurement, points: Array) -> tuple[Array, Array]:
    parameters = problem.parameters
    x = parameters.to_si(points)
    response = problem.response(x)
    measured = measurement.values
    seen = np.abs(measured) > 0
    with np.errstate(divide="ignore"):
        ratio = np.log(np.abs(measured[seen])) - np.log(np.abs(response[:, seen]))
    shift = np.zeros(len(points))
    masses = [index for index, parameter in enumerate(parameters) if parameter.is_unbalance]
    if masses:  # all by one factor, as far as the bounds of each admit
        factor = np.exp(np.median(ratio, axis=1))
        with np.errstate(divide="ignore"):
            factor = np.clip(
                factor,
                np.max(parameters.lower[masses] / x[:, masses], axis=1),
                np.min(parameters.upper[masses] / x[:, masses], axis=1),
            )
        x[:, masses] *= factor[:, None]
        shift = np.log(factor)
    if turning := _turning(problem, measurement):
        with np.errstate(invalid="ignore"):
            aligned = np.conj(response / np.abs(response)) * (measured / np.maximum(np.abs(measured), 1e-300))
        turn = np.angle(np.nan_to_num(aligned).sum(axis=(1, 2)))
        x[:, turning] = (x[:, turning] + turn[:, None] + TURN / 2) % TURN - TURN / 2
    return np.clip(parameters.to_cube(x), 0.0, 1.0), np.mean(np.abs(ratio - shift[:, None]), axis=1)


def _turning(problem: Problem, measurement: Measurement) -> list[int]:
    """The places of the angles that turn all data alike: the phase origin, or else the phases of all unbalance."""
    if measurement.is_amplitude:
        return []
    names = problem.parameters.names
    if PHASE_ORIGIN in names:
        return [names.index(PHASE_ORIGIN)]
    return [index for index, parameter in enumerate(problem.parameters) if parameter.is_full_turn]


def _apart(points: Array, count: int, distance: float = 0.1) -> list[Array]:
    """The first `count` points (n, d) that are not nearer than `distance` to one before."""
    chosen: list[Array] = []
    for point in points:
        if all(np.linalg.norm(point - other) >= distance for other in chosen):
            chosen.append(point)
            if len(chosen) == count:
                break
    return chosen


def _best_maxima(likelihood: Likelihood, starts: Sequence[Array], effort: Effort) -> list[Point]:
    """Maxima of the likelihood, highest first: all starts θ climb a little, the best of them all the way."""
    climbed = [maximise(likelihood, theta, max_iterations=effort.first_iterations, tolerance=1e-2) for theta in starts]
    climbed.sort(key=lambda point: point.deviance)
    maxima: list[Point] = []
    for point in climbed[: effort.survivors]:
        point = maximise(likelihood, point.theta, tolerance=1e-4)
        if all(abs(point.deviance - other.deviance) > CLOSE for other in maxima):
            maxima.append(point)
    return sorted(maxima, key=lambda point: point.deviance)


def with_best_noise(likelihood: Likelihood, point: Point) -> Point:
    """The point, or a higher one that differs from it in the noise."""
    if not likelihood.noise_is_sought:
        return point
    u = point.theta[: likelihood.d]
    again = [maximise(likelihood, np.concatenate([u, noise])) for noise in likelihood.noise_starts(u)]
    return min([point, *again], key=lambda other: other.deviance)
