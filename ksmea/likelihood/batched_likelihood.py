"""The likelihoods of many data sets of one layout, each at a θ of its own: deviance, gradient and information as one batch.

The formulas are those of `ksmea.likelihood.likelihood` and `ksmea.likelihood.fisher`; derivatives of the response are differences to one side.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.likelihood.deviance import deviance
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import amplitude_sensitivity

STEP = 1e-6  # of differences in the unit cube: rounding takes some 1e-9 of a derivative, the curve some 1e-4


class BatchedLikelihood:
    """The likelihoods of `values` (n_set, n_speed, n_channel), m, with the model, noise and limits of `likelihood`.

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
