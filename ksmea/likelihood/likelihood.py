"""The likelihood of a measurement, with its noise known or also estimated.

With mean μ(u), r = μ − y and s(μ)² = (relative · |μ|)² + floor², its deviance −2 ln L is defined in `ksmea.likelihood.misfit`, with
s₀ = s(y) as the misfit `likelihood` has it, or |y| where the noise is unknown.

The ln s² term stays: without it the estimate is biased towards large responses, and with s taken from the data towards
small ones. If the noise is unknown, ln relative and ln floor are two further unknowns, or two for each run of a campaign
whose runs have noise of their own. `ksmea.inference.maximisation` finds the maximum.

Unknowns with a Gaussian prior (`ksmea.problem.parameters.Prior`) add Σ (x − value)² / sd² to the deviance: the joint penalised
likelihood of the data and of what is known before. A prior counts as a datum, so that J has a row for each.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.optimize import minimize

from ksmea.arrays import Array, ComplexArray
from ksmea.likelihood.fisher import (
    Point,
    noise_variance_slopes,
    whitened_difference,
    whitened_sensitivity,
    with_prior_rows,
)
from ksmea.likelihood.misfit import deviance, log_term, reference_variance
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import amplitude_sensitivity
from ksmea.problem.case import Case
from ksmea.problem.counted import Model

# Noise that is estimated lies between nothing and as much as the data themselves: as parts of the values, and as parts
# of their median (lowest floor) and maximum (highest floor).
RELATIVE_RANGE = (1e-4, 1.0)
FLOOR_RANGE = (1e-5, 1.0)
# ln relative and ln floor change by no more than this at once: a floor that does not show has no information of how far it
# may grow, and would go to its upper limit at any damping.
LONGEST_NOISE_STEP = 1.0
N_GRID = 25  # levels of each part of the noise that a start is chosen from
LEAST_GAIN = 0.05  # of a step of fits where the response jumps: they would creep along an edge of the likelihood
N_START = 3  # starts of the noise: with the best floor, with none, with one as large as the small residuals

BEND = 0.1  # of a step, at which its curvature is measured


class Likelihood:
    """The likelihood of a measurement as a function of θ.

    Its model counts the evaluations and holds the budget.

    With `stable_only` the deviance is infinite where the rotor is unstable at a measured speed.
    """

    def __init__(self, model: Model, measurement: Measurement, *, stable_only: bool = False) -> None:
        self.case = Case(model.problem, measurement)
        self.model = model
        self.measurement = measurement
        self._stable_only = stable_only
        self.d = len(model.problem.parameters)
        self._known_noise = measurement.noise
        if self._known_noise is not None and self._known_noise.is_absent:
            raise ValueError("likelihood: expected noise that is known or unknown, got none")

    @property
    def noise_is_estimated(self) -> bool:
        """Whether its level is unknown, and two of the unknowns."""
        return self._known_noise is None

    @cached_property
    def lower(self) -> Array:  # (p,)
        return np.concatenate([np.zeros(self.d), self._noise_limits[0]])

    @cached_property
    def upper(self) -> Array:  # (p,)
        return np.concatenate([np.ones(self.d), self._noise_limits[1]])

    @cached_property
    def period(self) -> Array:  # (p,)
        return np.concatenate([self.model.problem.parameters.period, np.full(len(self.lower) - self.d, np.inf)])

    @cached_property
    def longest_step(self) -> Array:  # (p,)
        return np.where(np.arange(len(self.lower)) < self.d, np.inf, LONGEST_NOISE_STEP)

    @cached_property
    def least_gain(self) -> float:
        """By how much steps of a fit lower the deviance at least, or they end."""
        return LEAST_GAIN if self.model.problem.parameters.makes_jumps else 0.0

    @property
    def linearises_at_once(self) -> bool:
        """Whether to linearise at a point before it is known to be better.

        If no budget limits evaluations, and a Jacobian costs little more than one.
        """
        return not self._stable_only and self.model.left is None and self.model.problem.linearises_cheaply()

    @property
    def n_residual(self) -> int:
        """Real numbers in the data."""
        return self.measurement.values.size * self.measurement.dimensions

    @property
    def n_free(self) -> int:
        """Unknowns that the data alone determine: those without a prior."""
        return self.d - len(self.model.problem.parameters.with_prior)

    def with_priors(self, point: Point) -> Point:
        """A point of the data's likelihood with the priors as further data."""
        parameters = self.model.problem.parameters
        if not len(columns := parameters.with_prior):
            return point
        residual, sd = parameters.off_priors(point.theta), parameters.priors[1]
        gradient = point.gradient.copy()
        gradient[columns] += 2 * residual / sd
        whitened = with_prior_rows(point.whitened, parameters)
        return Point(point.theta, point.deviance + float(residual @ residual), gradient, whitened)

    def noise(self, theta: Array) -> Noise:
        """The noise level at θ."""
        return self.noise_of(theta, self.measurement)

    def noise_of(self, theta: Array, measurement: Measurement) -> Noise:
        """The noise at θ (p,) of another measurement by the same runs."""
        if self._known_noise is not None:
            return self._known_noise
        levels = [(float(relative), float(floor)) for relative, floor in np.exp(theta[self.d :]).reshape(-1, 2)]
        return Noise(*levels[0]) if len(levels) == 1 else Noise.of_runs(levels, measurement.layout.noise_rows)

    def start(self, u: Array) -> Array:
        """θ at a point (d,) of the unit cube, the noise as the residuals there have it."""
        if not self.noise_is_estimated:
            return np.array(u, dtype=float)
        return np.concatenate([u, self.noise_starts(u)[0]])

    def noise_starts(self, u: Array) -> list[Array]:
        """ln relative and ln floor (2,), of each run that has its own, to start from at u (d,).

        The values that fit the residuals there best, best without a floor, and best with a floor as large as the small
        ones among the residuals. A maximum can lie near each.
        """
        return self._noise_starts(*self._for_noise(u))

    def _noise_starts(self, magnitude: Array, squared: Array) -> list[Array]:
        """Starts of the noise from reference magnitudes and squared residuals (n_speed, n_channel).

        The relative part refers to these magnitudes.
        """
        of_rows = [
            self._starts_of(magnitude[rows].ravel(), squared[rows].ravel(), self._reference_variance[rows].ravel())
            for rows in self.measurement.layout.noise_rows
        ]
        return [np.concatenate(parts) for parts in zip(*of_rows, strict=True)]

    def _for_noise(self, u: Array) -> tuple[Array, Array]:
        """Magnitudes that the relative part of the noise refers to, and squared residuals, at u (d,).

        Each is (n_speed, n_channel).
        """
        mean = self.measurement.seen(self.model.response(u[None])[0])
        return np.abs(mean), np.abs(mean - self.measurement.values) ** 2

    def _starts_of(self, magnitude: Array, squared: Array, reference: Array) -> list[Array]:
        """Noise starts of data (n,) that share a level; without any, the middle of the limits."""
        lower, upper = noise_limits(self.measurement.values)
        if not magnitude.size:
            return [(lower + upper) / 2] * N_START
        small = 0.5 * np.log(np.quantile(squared, 0.1) + np.exp(lower[1]) ** 2)
        floor = np.append(np.linspace(lower[1], upper[1], N_GRID), min(small, upper[1]))
        relative = np.linspace(lower[0], upper[0], N_GRID)
        variance = (np.exp(relative)[:, None, None] * magnitude) ** 2 + np.exp(floor)[:, None] ** 2
        by_noise = deviance(squared, variance, reference, self.measurement.kind, axis=-1)
        best = np.unravel_index(np.argmin(by_noise), by_noise.shape)[1]
        return [np.array([relative[np.argmin(by_noise[:, column])], floor[column]]) for column in (best, 0, -1)]

    def other_noise(self, theta: Array) -> list[Array]:
        """θ with other levels of the noise to start from: none if they are known."""
        if not self.noise_is_estimated:
            return []
        starts = [np.concatenate([theta[: self.d], noise]) for noise in self.noise_starts(theta[: self.d])]
        floors = slice(self.d + 1, None, 2)
        return [start for start in starts if np.any(np.abs(start[floors] - theta[floors]) > LONGEST_NOISE_STEP)]

    def at(self, theta: Array) -> Point:
        """Deviance, gradient and information at θ: one Jacobian of the model."""
        response, slope = self.model.linearise(theta[: self.d])  # (n_speed, n_channel) and (…, d)
        noise, observable = self.noise(theta), self.measurement.kind
        residual, magnitude = self._residual(response), np.abs(response)
        variance = noise.variance(magnitude)
        d_mean = observable.seen_sensitivity(response, slope)
        d_variance = (2 * noise.relative**2 * magnitude)[..., None] * amplitude_sensitivity(response, slope)
        if self.noise_is_estimated:
            of_noise = noise_variance_slopes(magnitude, noise)
            d_variance = np.concatenate([d_variance, of_noise], axis=-1)
            d_mean = np.concatenate([d_mean, np.zeros_like(of_noise)], axis=-1)
        excess = (1 - np.abs(residual) ** 2 / variance) / variance  # what a change of the variance costs
        gradient = observable.dimensions * (
            excess[..., None] * d_variance + 2 * (np.conj(residual)[..., None] * d_mean).real / variance[..., None]
        )
        whitened = whitened_sensitivity(response, slope, noise, observable, noise_known=not self.noise_is_estimated)
        return self.with_priors(Point(theta, self._deviance(residual, variance), gradient.sum(axis=(0, 1)), whitened))

    def deviance(self, theta: Array) -> float:
        """Deviance at θ, infinite if the model has no finite or no acceptable response.

        It takes one evaluation of the model.
        """
        if self._stable_only and not self.is_stable(theta):
            return np.inf
        try:
            response = self.model.response(theta[None, : self.d])[0]
        except np.linalg.LinAlgError:
            return np.inf
        off = self.model.problem.parameters.off_priors(theta)
        return self._deviance(self._residual(response), self._variance(theta, response)) + float(off @ off)

    def deviance_of(self, response: ComplexArray) -> float:
        """Deviance of a response (n_speed, n_channel), m.

        If the noise level is unknown, it is the one that suits the response best.
        """
        residual, magnitude = self._residual(response), np.abs(response)
        if self._known_noise is not None:
            return self._deviance(residual, self._known_noise.variance(magnitude))
        starts = self._noise_starts(magnitude, np.abs(residual) ** 2)[0].reshape(-1, 2)
        limits = list(zip(*noise_limits(self.measurement.values), strict=True))

        def by_noise(levels: Array, rows: slice) -> float:
            variance = Noise(*np.exp(levels).tolist()).variance(magnitude[rows])
            reference = self._reference_variance[rows]
            return float(deviance(np.abs(residual[rows]) ** 2, variance, reference, self.measurement.kind))

        rows = self.measurement.layout.noise_rows
        parts = [
            minimize(by_noise, start, (of_level,), "Nelder-Mead", bounds=limits).fun
            for start, of_level in zip(starts, rows, strict=True)
        ]
        return float(np.sum(parts))

    def is_stable(self, theta: Array) -> bool:
        """Whether the rotor is stable at θ."""
        problem = self.model.problem
        return problem.is_stable(problem.parameters.to_si(theta[: self.d]))

    def log_density(self, theta: Array) -> float:
        """Log density ln L at θ, but for a constant that depends on the number of data alone.

        It can be compared between measurements with different noise, which the deviance cannot.
        """
        reference = log_term(self._reference_variance, 1.0, self.measurement.kind)
        return -0.5 * (self.deviance(theta) + float(np.sum(reference)))

    def curvature(self, point: Point, step: Array) -> Array:
        """Second derivative of the mean along a step (p,) in units of the noise, (m,).

        It has the form of the rows of `whitened` and takes two evaluations of the model.
        """
        ends = np.stack([point.theta, point.theta + BEND * step])[:, : self.d]
        start, end = self.model.response(ends)
        change = self.whitened_difference(end, start, point.theta)
        curvature = np.zeros(len(point.whitened))
        curvature[: len(change)] = 2 / BEND * (change / BEND - point.whitened[: len(change)] @ step)
        return curvature

    def whitened_difference(self, response: ComplexArray, other: ComplexArray, theta: Array) -> Array:
        """Difference of two responses (n_speed, n_channel) in units of the noise.

        It has the form of the rows of `whitened` for the means.
        """
        return whitened_difference(response, other, self.noise(theta), self.measurement.kind)

    def left(self, theta: Array, response: ComplexArray) -> Array | ComplexArray:
        """Residuals of the data from a response (n_speed, n_channel), in units of the noise."""
        return -self._residual(response) / self.noise(theta).sd(np.abs(response))

    def without_alike(self, theta: Array, left: Array | ComplexArray) -> Array | ComplexArray:
        """Residuals (n, n_speed, n_channel) in units of the noise, less the additionally fitted part.

        Here they are unchanged.
        """
        return left

    def alike(self, theta: Array, response: ComplexArray) -> ComplexArray:
        """The part fitted in addition to the unknowns at a response (n_speed, n_channel), m: here zero."""
        return np.zeros_like(response)

    def _variance(self, theta: Array, response: Array | ComplexArray) -> Array:
        """s² (n_speed, n_channel), m²."""
        return self.noise(theta).variance(np.abs(response))

    def _residual(self, response: ComplexArray) -> Array | ComplexArray:
        return self.measurement.seen(response) - self.measurement.values

    def _deviance(self, residual: Array | ComplexArray, variance: Array) -> float:
        return float(deviance(np.abs(residual) ** 2, variance, self._reference_variance, self.measurement.kind))

    @cached_property
    def _reference_variance(self) -> Array:
        """s₀² (n_speed, n_channel), m²."""
        amplitude = np.abs(self.measurement.values)
        variance = amplitude**2 if self._known_noise is None else self._known_noise.variance(amplitude)
        return reference_variance(variance, self.measurement.values)

    @cached_property
    def _noise_limits(self) -> tuple[Array, Array]:
        if not self.noise_is_estimated:
            return np.empty(0), np.empty(0)
        n_level = len(self.measurement.layout.noise_rows)
        lower, upper = noise_limits(self.measurement.values)
        return np.tile(lower, n_level), np.tile(upper, n_level)


def noise_limits(values: Array | ComplexArray) -> tuple[Array, Array]:
    """Lower and upper limits (2,) of ln relative and ln floor, from values (n_speed, n_channel)."""
    amplitude = np.abs(values)
    floors = FLOOR_RANGE[0] * np.median(amplitude), FLOOR_RANGE[1] * np.max(amplitude)
    return np.log([RELATIVE_RANGE[0], floors[0]]), np.log([RELATIVE_RANGE[1], floors[1]])
