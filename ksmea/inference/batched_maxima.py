"""Maximisation of many likelihoods as one batch, by damped Fisher scoring.

`ksmea.inference.maximisation` has the method.

It is for fits that start near their maxima and whose deviance is wanted to about a hundredth. Deviance, gradient
and information are defined in `ksmea.likelihood.likelihood` and `ksmea.likelihood.fisher`; derivatives of the response
are one-sided differences.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.likelihood.likelihood import Likelihood
from ksmea.likelihood.misfit import deviance
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import amplitude_sensitivity

STEP = 1e-6  # of differences in the unit cube: rounding takes some 1e-9 of a derivative, the curve some 1e-4


class BatchedLikelihood:
    """Likelihoods of `values` (n_set, n_speed, n_channel), m.

    Model, noise and limits are of `likelihood`.

    Every method takes θ (k, p) and the data `sets` (k,) that its rows are compared with.
    """

    def __init__(self, likelihood: Likelihood, values: Array | ComplexArray) -> None:
        self.lower, self.upper, self.longest_step = likelihood.lower, likelihood.upper, likelihood.longest_step
        self._likelihood = likelihood
        self._observable = likelihood.measurement.kind
        self._values = values
        self.n_set = len(values)
        rows = likelihood.measurement.layout.noise_rows
        self._level = np.zeros((values.shape[1], len(rows)))  # 1 where a speed has this level of the noise
        for level, run in enumerate(rows):
            self._level[run, level] = 1.0

    def deviance(self, theta: Array, sets: Indices) -> Array:
        """−2 ln L (k,) up to a constant of each data set."""
        response = self._likelihood.model.response(theta[:, : self._likelihood.d])
        squared = np.abs(self._observable.seen(response) - self._values[sets]) ** 2
        return deviance(squared, self._noise(theta).variance(np.abs(response)), 1.0, self._observable, axis=(1, 2))

    def scoring(self, theta: Array, sets: Indices) -> tuple[Array, Array]:
        """The gradient of the deviance (k, p) and the Fisher information (k, p, p)."""
        noise, (response, slope) = self._noise(theta), self._linearised(theta)
        magnitude = np.abs(response)
        variance = noise.variance(magnitude)
        residual = (self._observable.seen(response) - self._values[sets]) / np.sqrt(variance)
        of_mean = self._observable.seen_sensitivity(response, slope) / np.sqrt(variance)[..., None]
        of_variance = (2 * noise.relative**2 * magnitude)[..., None] * amplitude_sensitivity(response, slope)
        if self._likelihood.noise_is_estimated:
            of_noise = self._noise_slopes(magnitude, noise)
            of_variance = np.concatenate([of_variance, of_noise], axis=-1)
            of_mean = np.concatenate([of_mean, np.zeros_like(of_noise)], axis=-1)
        of_variance /= variance[..., None]
        shape = (len(theta), -1, theta.shape[1])
        of_mean, of_variance = of_mean.reshape(shape), of_variance.reshape(shape)
        excess = (1 - np.abs(residual) ** 2).reshape(len(theta), 1, -1)  # what a change of the variance costs
        adjoint = np.conj(of_mean).transpose(0, 2, 1)
        gradient = (excess @ of_variance)[:, 0] + 2 * (adjoint @ residual.reshape(len(theta), -1, 1))[..., 0].real
        information = (adjoint @ of_mean).real + of_variance.transpose(0, 2, 1) @ of_variance / 2
        return self._observable.dimensions * gradient, self._observable.dimensions * information

    def _linearised(self, theta: Array) -> tuple[ComplexArray, ComplexArray]:
        """Responses (k, n_speed, n_channel) and their derivatives (…, d) in the unit cube, inside it."""
        u = theta[:, : self._likelihood.d]
        steps = np.where(u < 0.5, STEP, -STEP)
        points = u[:, None] + np.concatenate(
            [np.zeros((len(u), 1, u.shape[1])), steps[..., None] * np.eye(u.shape[1])], 1
        )
        responses = self._likelihood.model.response(points.reshape(-1, u.shape[1]))
        responses = responses.reshape(*points.shape[:2], *responses.shape[1:])
        slopes = (responses[:, 1:] - responses[:, :1]) / steps[..., None, None]
        return responses[:, 0], np.moveaxis(slopes, 1, -1)

    def _noise(self, theta: Array) -> Noise:
        """Its level at each θ, (k, n_speed, 1) where it is estimated."""
        if not self._likelihood.noise_is_estimated:
            return self._likelihood.noise(theta[0])
        levels = np.exp(theta[:, self._likelihood.d :]).reshape(len(theta), self._level.shape[1], 2)
        relative, floor = np.moveaxis(self._level @ levels, -1, 0)[..., None]
        return Noise(relative, floor)

    def _noise_slopes(self, magnitude: Array, noise: Noise) -> Array:
        """∂s²/∂(ln relative, ln floor) of each level (k, n_speed, n_channel, 2 n_level), m²."""
        parts = np.stack(
            [(noise.relative * magnitude) ** 2, np.square(noise.floor) + np.zeros_like(magnitude)], axis=-1
        )
        by_level = 2 * self._level[:, None, :, None] * parts[..., None, :]
        return np.asarray(by_level.reshape(*magnitude.shape, -1))


MAX_ITERATIONS = 60
LEAST_GAIN = 0.01  # of the deviance: a fit ends where a step is expected to give less, or gives less
FIRST_DAMPING, FIRST_RETRY, LAST_DAMPING = 1e-6, 1e-3, 1e4  # of a step, relative to the information
LEAST_SCALE = 1e-9  # of the largest: what the data tell nothing of


@dataclass(frozen=True)
class Fits:
    """Ends of fits: θ (k, p), data set (k,), deviance (k,) and Fisher information near it (k, p, p)."""

    theta: Array
    sets: Indices
    deviance: Array
    information: Array

    def part(self, rows: Indices) -> Fits:
        """Some of them."""
        return Fits(self.theta[rows], self.sets[rows], self.deviance[rows], self.information[rows])

    def distinct(self, tolerance: float) -> Fits:
        """Fits of each data set with deviances more than `tolerance` apart.

        Only the best fit of each data set if `tolerance` is infinite."""
        rows = np.lexsort([self.deviance, self.sets])
        sets, deviance = self.sets[rows], self.deviance[rows]
        is_new = np.append(
            np.ones(min(len(rows), 1), dtype=bool), (np.diff(sets) > 0) | (np.diff(deviance) > tolerance)
        )
        return self.part(rows[is_new])

    def tangents(self, unknown: Indices) -> Array:
        """How θ moves with one unknown (k,) of each, all others fitted, (k, p)."""
        matrix, scale = _scaled(self.information)
        matrix = matrix + FIRST_DAMPING * np.eye(matrix.shape[1])
        own = np.arange(matrix.shape[1]) == unknown[:, None]
        others = np.where(own[:, :, None] | own[:, None], np.eye(matrix.shape[1]), matrix)
        follow = np.linalg.solve(others, np.where(own, -1.0, matrix[own])[..., None])[..., 0]
        return np.asarray(-follow * scale[own][:, None] / scale)


def batched_maxima(likelihood: BatchedLikelihood, theta: Array, sets: Indices, fixed: Indices | None = None) -> Fits:
    """The maxima within the limits that fits to data `sets` (k,) from θ (k, p) lead to.

    `fixed` (k,) is the index of an unknown that keeps its value in each fit; None: none does.
    """
    theta = np.clip(theta, likelihood.lower, likelihood.upper)
    deviance = likelihood.deviance(theta, sets)
    free = np.full(theta.shape, True)
    if fixed is not None:
        free[np.arange(len(theta)), fixed] = False
    gradient, information = np.empty(theta.shape), np.empty((*theta.shape, theta.shape[1]))
    damping = np.full(len(theta), FIRST_DAMPING)
    left = moved = np.arange(len(theta))
    for _ in range(MAX_ITERATIONS):
        if len(moved):
            gradient[moved], information[moved] = likelihood.scoring(theta[moved], sets[moved])
        step, expected = _steps(likelihood, theta[left], free[left], gradient[left], information[left], damping[left])
        left, step = left[expected > LEAST_GAIN], step[expected > LEAST_GAIN]
        if not len(left):
            break
        trial = np.clip(theta[left] + step, likelihood.lower, likelihood.upper)
        reached = likelihood.deviance(trial, sets[left])
        gain = deviance[left] - reached
        better = gain > 0
        theta[left[better]], deviance[left[better]] = trial[better], reached[better]
        damping[left] = np.where(
            better, np.maximum(damping[left] / 10, FIRST_DAMPING), np.maximum(damping[left] * 10, FIRST_RETRY)
        )
        goes_on = np.where(better, gain > LEAST_GAIN, damping[left] <= LAST_DAMPING)
        left, moved = left[goes_on], left[goes_on & better]
    return Fits(theta, sets, deviance, information)


def _steps(
    likelihood: BatchedLikelihood,
    theta: Array,
    free: NDArray[np.bool_],
    gradient: Array,
    information: Array,
    damping: Array,
) -> tuple[Array, Array]:
    """Steps (k, p) that lower the quadratic model of each deviance within the limits, and by how much.

    If a step meets a limit, that unknown stays there, and the others go on."""
    matrix, scale = _scaled(information)
    matrix = matrix + damping[:, None, None] * np.eye(matrix.shape[1])
    lower = np.maximum(likelihood.lower - theta, -likelihood.longest_step) * scale
    upper = np.minimum(likelihood.upper - theta, likelihood.longest_step) * scale
    half = gradient / scale / 2
    step = np.zeros(theta.shape)  # in units of 1 / scale
    for _ in range(theta.shape[1]):
        among = np.where(free[:, :, None] & free[:, None], matrix, np.eye(theta.shape[1]))
        rest = -half - (matrix @ np.where(free, 0.0, step)[..., None])[..., 0]
        ahead = np.linalg.solve(among, np.where(free, rest, step)[..., None])[..., 0] - step
        limit = np.where(ahead > 0, upper, lower)
        room = np.divide(limit - step, ahead, out=np.full(step.shape, np.inf), where=free & (ahead != 0))
        part = np.minimum(room.min(axis=1, keepdims=True), 1.0)
        meets = (room <= part) & (part < 1)
        step = np.where(meets, limit, step + part * ahead)
        free = free & ~meets
        if not np.any(meets):
            break
    expected = -2 * np.sum(half * step, axis=1) - np.einsum("kp,kpq,kq->k", step, matrix, step)
    return step / scale, expected


def _scaled(information: Array) -> tuple[Array, Array]:
    """Information (k, p, p) with a diagonal of 1, and what it was divided by (k, p) on both sides."""
    scale = np.sqrt(np.diagonal(information, axis1=1, axis2=2))
    scale = np.maximum(scale, LEAST_SCALE * scale.max(axis=1, keepdims=True))
    return information / (scale[:, :, None] * scale[:, None]), scale
