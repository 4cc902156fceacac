"""The likelihood of a measurement, its noise known or estimated along, and its maximum nearest to a start.

With mean μ(u), r = μ − y and s(μ)² = (relative · |μ|)² + floor², the deviance −2 ln L is, up to a constant,

    D = Σ n ln(s² / s₀²) + n |r|² / s²,   n = 1 for amplitudes and 2 for complex data (s² is their total variance),

with s₀ = s(y) as the misfit `likelihood` has it, or |y| where the noise is unknown.

The ln s² term stays: without it the estimate is biased towards large responses, and with s taken from the data towards
small ones. Where the noise is unknown, ln relative and ln floor are two further unknowns.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import lsq_linear

from ksmea.alignment import require_aligned
from ksmea.arrays import Array, ComplexArray
from ksmea.errors import BudgetSpent
from ksmea.identifiability import whitened_difference, whitened_noise_sensitivity, whitened_sensitivity
from ksmea.measurement import Measurement, Noise
from ksmea.model import Model

# Noise that is estimated lies between nothing and as much as the data themselves: as parts of the values, and as parts
# of their median (lowest floor) and maximum (highest floor).
RELATIVE_RANGE = (1e-4, 1.0)
FLOOR_RANGE = (1e-5, 1.0)
N_GRID = 25  # levels of each part of the noise that a start is chosen from

MOST_ITERATIONS = 300  # of a climb: unknowns that nearly compensate each other make long curved valleys

BEND = 0.1  # of a step, at which its curvature is measured
MOST_BENT = 0.75  # of a step's length (Transtrum & Sethna)

# Damping of a step, relative to the information: at first, and where no step leads down any more.
FIRST_DAMPING, LAST_DAMPING = 1e-6, 1e8


@dataclass(frozen=True)
class Point:
    """The likelihood at θ (p,): unknowns in the unit cube (d,), then ln relative and ln floor where they are sought."""

    theta: Array
    deviance: float
    gradient: Array  # (p,) of the deviance
    whitened: Array  # (m, p); whitenedᵀ whitened is the Fisher information

    @property
    def information(self) -> Array:
        return self.whitened.T @ self.whitened


class Likelihood:
    """The likelihood of a measurement as a function of θ. Its model counts the evaluations and holds the budget."""

    def __init__(self, model: Model, measurement: Measurement) -> None:
        require_aligned(model.problem, measurement)
        self.model = model
        self.measurement = measurement
        self.d = len(model.problem.parameters)
        self.noise_is_sought = measurement.noise is None
        if not self.noise_is_sought and measurement.noise.is_absent:
            raise ValueError("likelihood: expected noise that is known or unknown, got none")

    @cached_property
    def lower(self) -> Array:  # (p,)
        return np.concatenate([np.zeros(self.d), self._noise_bounds[0]])

    @cached_property
    def upper(self) -> Array:  # (p,)
        return np.concatenate([np.ones(self.d), self._noise_bounds[1]])

    @property
    def n_residual(self) -> int:
        """Real numbers in the data."""
        return self.measurement.values.size * self.measurement.dimensions

    def noise(self, theta: Array) -> Noise:
        """The noise level at θ."""
        if not self.noise_is_sought:
            return self.measurement.noise
        relative, floor = np.exp(theta[self.d :])
        return Noise(float(relative), float(floor))

    def start(self, u: Array) -> Array:
        """θ at a point (d,) of the unit cube, the noise as the residuals there have it."""
        if not self.noise_is_sought:
            return np.array(u, dtype=float)
        return np.concatenate([u, self.noise_starts(u)[0]])

    def noise_starts(self, u: Array) -> list[Array]:
        """ln relative and ln floor (2,) to start from at u (d,): those that fit the residuals there best, best without a
        floor, and best with a floor as large as the small ones among the residuals. A maximum can lie near each."""
        mean = self.measurement.seen(self.model.response(u[None])[0])
        squared = np.abs(mean - self.measurement.values).ravel() ** 2
        lower, upper = self._noise_bounds
        small = 0.5 * np.log(np.quantile(squared, 0.1) + np.exp(lower[1]) ** 2)
        floor = np.append(np.linspace(lower[1], upper[1], N_GRID), min(small, upper[1]))
        relative = np.linspace(lower[0], upper[0], N_GRID)
        variance = (np.exp(relative)[:, None, None] * np.abs(mean).ravel()) ** 2 + np.exp(floor)[:, None] ** 2
        deviance = np.sum(np.log(variance) + squared / variance, axis=-1)
        best = np.unravel_index(np.argmin(deviance), deviance.shape)[1]
        return [np.array([relative[np.argmin(deviance[:, column])], floor[column]]) for column in (best, 0, -1)]

    def at(self, theta: Array) -> Point:
        """Deviance, gradient and information at θ: one Jacobian of the model."""
        response, sensitivity = self.model.linearise(theta[: self.d])
        noise = self.noise(theta)
        residual, variance = self._terms(response, noise)
        magnitude = np.abs(response)
        slope = sensitivity.reshape(*response.shape, self.d)
        d_magnitude = (np.conj(response)[..., None] * slope).real / magnitude[..., None]
        d_mean = d_magnitude if self.measurement.is_amplitude else slope
        d_variance = 2 * noise.relative**2 * magnitude[..., None] * d_magnitude
        whitened = whitened_sensitivity(response, sensitivity, noise, amplitude=self.measurement.is_amplitude)
        if self.noise_is_sought:
            parts = [2 * (noise.relative * magnitude) ** 2, np.full_like(magnitude, 2 * noise.floor**2)]
            d_variance = np.concatenate([d_variance, np.stack(parts, axis=-1)], axis=-1)
            d_mean = np.concatenate([d_mean, np.zeros((*magnitude.shape, 2))], axis=-1)
            of_noise = whitened_noise_sensitivity(magnitude, noise, amplitude=self.measurement.is_amplitude)
            whitened = np.concatenate([whitened, of_noise], axis=1)
        n = self.measurement.dimensions
        excess = (1 - np.abs(residual) ** 2 / variance) / variance  # what a change of the variance costs
        gradient = n * (
            excess[..., None] * d_variance + 2 * (np.conj(residual)[..., None] * d_mean).real / variance[..., None]
        )
        return Point(theta, self._deviance(residual, variance), gradient.sum(axis=(0, 1)), whitened)

    def deviance(self, theta: Array) -> float:
        """The deviance at θ, infinite where the model has no finite response: one evaluation of the model."""
        try:
            response = self.model.response(theta[None, : self.d])[0]
        except np.linalg.LinAlgError:
            return np.inf
        return self._deviance(*self._terms(response, self.noise(theta)))

    def curvature(self, point: Point, step: Array) -> Array:
        """Second derivative along a step (p,) of the mean in units of the noise, (m,) as rows of `whitened` have it: two
        evaluations of the model."""
        ends = np.stack([point.theta, point.theta + BEND * step])[:, : self.d]
        start, end = self.model.response(ends)
        amplitude = self.measurement.is_amplitude
        change = whitened_difference(end, start, self.noise(point.theta), amplitude=amplitude)
        curvature = np.zeros(len(point.whitened))
        curvature[: len(change)] = 2 / BEND * (change / BEND - point.whitened[: len(change)] @ step)
        return curvature

    def _terms(self, response: ComplexArray, noise: Noise) -> tuple[Array, Array]:
        """Residuals and variances (n_speed, n_channel)."""
        return self.measurement.seen(response) - self.measurement.values, noise.sd(np.abs(response)) ** 2

    def _deviance(self, residual: Array, variance: Array) -> float:
        ratio = variance / self._reference_variance
        return float(self.measurement.dimensions * np.sum(np.log(ratio) + np.abs(residual) ** 2 / variance))

    @cached_property
    def _reference_variance(self) -> Array:
        amplitude = np.abs(self.measurement.values)
        variance = amplitude**2 if self.noise_is_sought else self.measurement.noise.sd(amplitude) ** 2
        return np.where(variance == 0, np.mean(amplitude**2), variance)

    @cached_property
    def _noise_bounds(self) -> tuple[Array, Array]:
        if not self.noise_is_sought:
            return np.empty(0), np.empty(0)
        amplitude = np.abs(self.measurement.values)
        floors = FLOOR_RANGE[0] * np.median(amplitude), FLOOR_RANGE[1] * np.max(amplitude)
        return np.log([RELATIVE_RANGE[0], floors[0]]), np.log([RELATIVE_RANGE[1], floors[1]])


def maximise(
    likelihood: Likelihood,
    theta: Array,
    *,
    held: int | None = None,
    max_iterations: int = MOST_ITERATIONS,
    tolerance: float = 1e-7,
) -> Point:
    """The maximum of the likelihood that Fisher scoring leads to from θ (p,), within the bounds.

    `held` is the index of an unknown that keeps its value (for profiles). Steps solve the scoring equations in the box
    as bounded least squares, damped as by Levenberg and Marquardt, and once a step has failed they bend with the mean
    (geodesic acceleration); they end where the deviance falls by less than `tolerance`. A spent budget of the model ends
    it too.

    M. R. Osborne, Fisher's method of scoring, Int. Stat. Rev. 60 (1992) 99–117, doi 10.2307/1403504; M. K. Transtrum and
    J. P. Sethna, Improvements to the Levenberg–Marquardt algorithm for nonlinear least-squares minimization, 2012,
    arXiv 1201.5885.
    """
    free = np.arange(len(theta)) != held
    point = likelihood.at(np.clip(theta, likelihood.lower, likelihood.upper))
    damping = FIRST_DAMPING
    try:
        for _ in range(max_iterations):
            step, expected = _step(likelihood, point, free, damping, point.gradient)
            if expected < tolerance:
                break
            if damping > FIRST_DAMPING:
                step = step + _bend(likelihood, point, free, damping, step)
            theta = np.clip(point.theta + step, likelihood.lower, likelihood.upper)
            if likelihood.deviance(theta) < point.deviance:
                point = likelihood.at(theta)
                damping = max(damping / 10, FIRST_DAMPING)
            else:  # also where the trial is not finite
                damping = max(damping * 10, 1e-3)
                if damping > LAST_DAMPING:
                    break
    except BudgetSpent:
        pass
    return point


def with_best_noise(likelihood: Likelihood, best: Point) -> Point:
    """A maximum, or a higher one that lies near it but for the noise: floor or none, the data often allow both."""
    if likelihood.noise_is_sought:
        with suppress(BudgetSpent):
            for noise in likelihood.noise_starts(best.theta[: likelihood.d]):
                again = maximise(likelihood, np.concatenate([best.theta[: likelihood.d], noise]))
                best = again if again.deviance < best.deviance else best
    return best


def _bend(likelihood: Likelihood, point: Point, free: Array, damping: float, step: Array) -> Array:
    """How a step (p,) must bend to stay in a curved valley; nothing where that is nearly the step itself, or unknown."""
    try:
        curvature = likelihood.curvature(point, step)
    except np.linalg.LinAlgError:  # no finite response there
        return np.zeros_like(step)
    bend, _ = _step(likelihood, point, free, damping, 2 * point.whitened.T @ curvature)
    scale = np.sqrt(np.sum(point.whitened**2, axis=0))
    is_small = np.linalg.norm(scale * bend) <= MOST_BENT * np.linalg.norm(scale * step)
    return bend / 2 if is_small else np.zeros_like(step)


def _step(likelihood: Likelihood, point: Point, free: Array, damping: float, gradient: Array) -> tuple[Array, float]:
    """The step (p,) that lowers the quadratic model of the deviance most within the bounds, and by how much."""
    whitened, gradient = point.whitened[:, free], gradient[free]
    scale = np.sqrt(np.sum(whitened**2, axis=0))
    scale = np.maximum(scale, 1e-12 * scale.max(initial=np.finfo(float).tiny))
    lower = (likelihood.lower - point.theta)[free] * scale
    upper = (likelihood.upper - point.theta)[free] * scale
    triangle = np.linalg.qr(np.vstack([whitened / scale, np.sqrt(damping) * np.eye(len(scale))]), mode="r")
    target = -np.linalg.solve(triangle.T, gradient / scale / 2)
    scaled = np.linalg.solve(triangle, target)
    if np.any(scaled < lower) or np.any(scaled > upper):
        scaled = lsq_linear(triangle, target, (np.minimum(lower, -1e-300), np.maximum(upper, 1e-300)), method="bvls").x
        scaled = np.clip(scaled, lower, upper)
    expected = float(np.sum(target**2) - np.sum((triangle @ scaled - target) ** 2))
    step = np.zeros(len(point.theta))
    step[free] = scaled / scale
    return step, expected
