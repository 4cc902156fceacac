"""What data can tell about the unknowns before they are measured: Fisher information and Cramér–Rao bounds.

For a datum with mean μ(x) and variance s²(|μ|) = (relative · |μ|)² + floor² the information about parameters i, j is

- amplitude, real Gaussian:        ∂ᵢμ ∂ⱼμ / s² + ∂ᵢs² ∂ⱼs² / (2 s⁴);
- complex, circular Gaussian:  2 Re(∂ᵢμ* ∂ⱼμ) / s² + ∂ᵢs² ∂ⱼs² / s⁴,

summed over the data (S. M. Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, 1993, eqs. 3.31 and
15.52). The second term is what the size of the noise itself tells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.contracts import Problem
from ksmea.measurement import Noise
from ksmea.model import Model

# Directions of relative change that the data tell less of than this part of the most telling one: rounding of the
# sensitivities near sharp resonances is of that order.
UNKNOWABLE = 1e-10


@dataclass(frozen=True)
class Identifiability:
    """What data tell about the unknowns at x (d,), SI, as their whitened sensitivity J (m, d): JᵀJ is the Fisher
    information. Directions are judged in changes relative to `scale` (d,): the values, or what stands in for a zero."""

    x: Array
    whitened: Array
    scale: Array | None = None

    @property
    def information(self) -> Array:
        """Fisher information (d, d), 1/SI²."""
        return self.whitened.T @ self.whitened

    @property
    def bound(self) -> Array:
        """Cramér–Rao bound: the smallest standard deviation (d,) of an unbiased estimate, SI; infinite where most of it
        comes from directions that the data do not tell."""
        singular, directions = self._spectrum
        weighted = (directions / self._floored(singular)[:, None]) ** 2
        told = singular > UNKNOWABLE * singular[0]
        hidden = np.sum(weighted[~told], axis=0) > np.sum(weighted[told], axis=0)
        return np.where(hidden, np.inf, np.sqrt(np.sum(weighted, axis=0))) * self._scale

    @property
    def bound_pct(self) -> Array:
        """The bound in per cent of the values (d,)."""
        return 100 * self.bound / np.abs(self.x)

    @property
    def worst_direction(self) -> Array:
        """Unit vector (d,) of relative changes that the data tell least."""
        return self._spectrum[1][-1]

    @property
    def worst_bound(self) -> float:
        """The bound on a relative change in that direction."""
        smallest = self._spectrum[0][-1]
        return float(1 / smallest) if smallest > 0 else np.inf

    @property
    def correlation(self) -> Array:
        """Correlation of the estimates (d, d) at the bound: ±1 where two unknowns can hardly be told apart."""
        singular, directions = self._spectrum
        weighted = directions / self._floored(singular)[:, None]
        covariance = weighted.T @ weighted
        sd = np.sqrt(np.diag(covariance))
        return covariance / np.outer(sd, sd)

    @property
    def _scale(self) -> Array:
        scale = np.abs(self.x) if self.scale is None else self.scale
        return np.where(scale == 0, 1.0, scale)

    def _floored(self, singular: Array) -> Array:
        return np.maximum(singular, max(UNKNOWABLE * singular[0], np.finfo(float).tiny))

    @property
    def _spectrum(self) -> tuple[Array, Array]:
        """Singular values (d,), falling, and directions (d, d) by rows, of the sensitivity to relative changes."""
        scaled = self.whitened * self._scale
        missing = max(0, scaled.shape[1] - len(scaled))  # fewer data than unknowns tell nothing in some directions
        _, singular, directions = np.linalg.svd(np.pad(scaled, ((0, missing), (0, 0))), full_matrices=False)
        return singular, directions


def identifiability(
    problem: Problem, x: Array, noise: Noise, kind: str, *, noise_known: bool = True
) -> Identifiability:
    """What data of a kind ('amplitude' or 'complex') with this noise would tell about the unknowns at x (d,), SI.

    Where the noise's level is not known, what it takes to estimate its relative part and its floor is taken off.
    """
    parameters = problem.parameters
    response, slope = Model(problem).linearise(parameters.to_cube(x))
    sensitivity = slope / parameters.width
    amplitude = kind == "amplitude"
    whitened = whitened_sensitivity(response, sensitivity, noise, amplitude=amplitude)
    if not noise_known:
        whitened = projected(whitened, whitened_noise_sensitivity(np.abs(response), noise, amplitude=amplitude))
    return Identifiability(x, whitened, np.where(x == 0, parameters.width, np.abs(x)))


def whitened_sensitivity(response: ComplexArray, sensitivity: ComplexArray, noise: Noise, *, amplitude: bool) -> Array:
    """J (m, d) with JᵀJ the information of data with this response (n_speed, n_channel) and sensitivity
    (n_speed, n_channel, d): rows for the means in units of their noise, then rows for the variances."""
    mean = response.ravel()
    slope = sensitivity.reshape(len(mean), -1)  # (m, d)
    magnitude = np.abs(mean)
    magnitude_slope = (np.conj(mean)[:, None] * slope).real / magnitude[:, None]
    sd = noise.sd(magnitude.reshape(response.shape)).reshape(-1, 1)  # a floor may differ from datum to datum
    by_variance = 2 * noise.relative**2 * magnitude[:, None] * magnitude_slope / sd**2
    if amplitude:
        return np.concatenate([magnitude_slope / sd, by_variance / np.sqrt(2)])
    return np.concatenate([np.sqrt(2) * slope.real / sd, np.sqrt(2) * slope.imag / sd, by_variance])


def whitened_difference(response: ComplexArray, other: ComplexArray, noise: Noise, *, amplitude: bool) -> Array:
    """Difference of two responses (n_speed, n_channel) in units of the noise at the other one, as the rows for the means
    of `whitened_sensitivity` have it."""
    sd = noise.sd(np.abs(other)).ravel()
    if amplitude:
        return (np.abs(response) - np.abs(other)).ravel() / sd
    difference = np.sqrt(2) * (response - other).ravel() / sd
    return np.concatenate([difference.real, difference.imag])


def whitened_noise_sensitivity(magnitude: Array, noise: Noise, *, amplitude: bool) -> Array:
    """The columns (m, 2) that ln relative and ln floor have beside `whitened_sensitivity`: they show in the variances
    alone. `magnitude` (n_speed, n_channel), m."""
    shape, magnitude = magnitude.shape, magnitude.ravel()
    variance = noise.sd(magnitude.reshape(shape)).ravel() ** 2
    floor_variance = np.broadcast_to(noise.floor**2, shape).ravel()
    parts = np.stack([(noise.relative * magnitude) ** 2, floor_variance], axis=1)
    by_variance = 2 * parts / variance[:, None]
    if amplitude:
        return np.concatenate([np.zeros_like(by_variance), by_variance / np.sqrt(2)])
    return np.concatenate([np.zeros((2 * len(magnitude), 2)), by_variance])


def projected(whitened: Array, nuisance: Array) -> Array:
    """What is left of sensitivities (m, d) when others (m, k), of parameters that nobody asks for, are fitted along."""
    directions, singular, _ = np.linalg.svd(nuisance, full_matrices=False)
    directions = directions[:, singular > UNKNOWABLE * max(singular[0], np.finfo(float).tiny)]
    return whitened - directions @ (directions.T @ whitened)
