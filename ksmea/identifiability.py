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

from ksmea.contracts import ComplexArray, Problem
from ksmea.measurement import Noise
from ksmea.parameters import Array

# Directions of relative change that the data tell less of than this part of the most telling one: rounding of the
# sensitivities near sharp resonances is of that order.
UNKNOWABLE = 1e-10


@dataclass(frozen=True)
class Identifiability:
    """What data tell about the unknowns at x (d,), SI, as their whitened sensitivity J: JᵀJ is the Fisher information."""

    x: Array
    whitened: Array  # (m, d)

    @property
    def information(self) -> Array:
        """Fisher information (d, d), 1/SI²."""
        return self.whitened.T @ self.whitened

    @property
    def bound(self) -> Array:
        """Cramér–Rao bound: the smallest standard deviation (d,) of an unbiased estimate, SI; infinite where the data
        say nothing in a direction that the parameter has a part in."""
        singular, directions = self._spectrum
        knowable = singular > UNKNOWABLE * singular[0]
        variance = np.sum((directions[knowable] / singular[knowable, None]) ** 2, axis=0)
        hidden = np.any(np.abs(directions[~knowable]) > 1e-3, axis=0)
        return np.where(hidden, np.inf, np.sqrt(variance)) * np.abs(self.x)

    @property
    def bound_pct(self) -> Array:
        """The bound in per cent of the values (d,)."""
        return 100 * self.bound / np.abs(self.x)

    @property
    def worst_direction(self) -> Array:
        """Unit vector (d,) of relative changes Δx/x that the data tell least."""
        return self._spectrum[1][-1]

    @property
    def correlation(self) -> Array:
        """Correlation of the estimates (d, d) at the bound: ±1 where two unknowns can hardly be told apart."""
        singular, directions = self._spectrum
        weighted = directions / np.maximum(singular, UNKNOWABLE * singular[0])[:, None]
        covariance = weighted.T @ weighted
        sd = np.sqrt(np.diag(covariance))
        return covariance / np.outer(sd, sd)

    @property
    def _spectrum(self) -> tuple[Array, Array]:
        """Singular values (d,), falling, and directions (d, d) by rows, of the sensitivity to relative changes."""
        _, singular, directions = np.linalg.svd(self.whitened * np.abs(self.x), full_matrices=False)
        return singular, directions


def identifiability(
    problem: Problem, x: Array, noise: Noise, kind: str, *, noise_known: bool = True
) -> Identifiability:
    """What data of a kind ('amplitude' or 'complex') with this noise would tell about the unknowns at x (d,), SI.

    Where the noise's level is not known, what it takes to estimate its relative part and its floor is taken off.
    """
    response, sensitivity = problem.response(x[None])[0], problem.sensitivity(x)
    amplitude = kind == "amplitude"
    whitened = whitened_sensitivity(response, sensitivity, noise, amplitude=amplitude)
    if not noise_known:
        whitened = projected(whitened, whitened_noise_sensitivity(np.abs(response), noise, amplitude=amplitude))
    return Identifiability(x, whitened)


def whitened_sensitivity(response: ComplexArray, sensitivity: ComplexArray, noise: Noise, *, amplitude: bool) -> Array:
    """J (m, d) with JᵀJ the information of data with this response (n_speed, n_channel) and sensitivity
    (n_speed, n_channel, d): rows for the means in units of their noise, then rows for the variances."""
    mean = response.ravel()
    slope = sensitivity.reshape(len(mean), -1)  # (m, d)
    magnitude = np.abs(mean)
    magnitude_slope = (np.conj(mean)[:, None] * slope).real / magnitude[:, None]
    sd = noise.sd(magnitude)[:, None]
    by_variance = 2 * noise.relative**2 * magnitude[:, None] * magnitude_slope / sd**2
    if amplitude:
        return np.concatenate([magnitude_slope / sd, by_variance / np.sqrt(2)])
    return np.concatenate([np.sqrt(2) * slope.real / sd, np.sqrt(2) * slope.imag / sd, by_variance])


def whitened_noise_sensitivity(magnitude: Array, noise: Noise, *, amplitude: bool) -> Array:
    """The columns (m, 2) that ln relative and ln floor have beside `whitened_sensitivity`: they show in the variances
    alone. `magnitude` (n_speed, n_channel), m."""
    magnitude = magnitude.ravel()
    variance = noise.sd(magnitude) ** 2
    parts = np.stack([(noise.relative * magnitude) ** 2, np.full(len(magnitude), noise.floor**2)], axis=1)
    by_variance = 2 * parts / variance[:, None]
    if amplitude:
        return np.concatenate([np.zeros_like(by_variance), by_variance / np.sqrt(2)])
    return np.concatenate([np.zeros((2 * len(magnitude), 2)), by_variance])


def projected(whitened: Array, nuisance: Array) -> Array:
    """What is left of sensitivities (m, d) when others (m, k), of parameters that nobody asks for, are fitted along."""
    directions, singular, _ = np.linalg.svd(nuisance, full_matrices=False)
    directions = directions[:, singular > UNKNOWABLE * max(singular[0], np.finfo(float).tiny)]
    return whitened - directions @ (directions.T @ whitened)
