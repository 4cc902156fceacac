"""Fisher information of data with Gaussian noise, as whitened sensitivities J (`LikelihoodPoint`).

JᵀJ is the information.

For a datum with mean μ(x) and variance s²(|μ|) = (relative · |μ|)² + floor² the information about parameters i, j is

- amplitude, real Gaussian:        ∂ᵢμ ∂ⱼμ / s² + ∂ᵢs² ∂ⱼs² / (2 s⁴);
- complex, circular Gaussian:  2 Re(∂ᵢμ* ∂ⱼμ) / s² + ∂ᵢs² ∂ⱼs² / s⁴,

summed over the data (S. M. Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, 1993, eqs. 3.31 and
15.52). The second term is the information in the noise level itself.

Rows of J come in two parts: those for the means, one per real number in the data and in units of their noise, then
those for the variances, one per datum. Priors follow as further data.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable, amplitude_sensitivity
from ksmea.problem.parameters import Parameters

# Directions of relative change that the data tell less of than this part of the most telling one: rounding of the
# sensitivities near sharp resonances is of that order.
UNKNOWABLE = 1e-10


def whitened_sensitivity(
    response: ComplexArray, sensitivity: ComplexArray, noise: Noise, observable: Observable, *, noise_known: bool = True
) -> Array:
    """J (m, d) of data with this response (n_speed, n_channel) and sensitivity (n_speed, n_channel, d).

    If the noise level is not known, two columns follow, of ln relative and ln floor: (m, d + 2); two for each run if
    runs have noise of their own.
    """
    magnitude = np.abs(response)
    sd = noise.sd(magnitude)  # a floor may differ from datum to datum
    of_mean = observable.seen_sensitivity(response, sensitivity) / sd[..., None]
    of_amplitude = amplitude_sensitivity(response, sensitivity)
    of_variance = (2 * noise.relative**2 * magnitude)[..., None] * of_amplitude / sd[..., None] ** 2
    rows = _rows(of_mean, of_variance, observable)
    if noise_known:
        return rows
    return np.concatenate([rows, whitened_noise_sensitivity(magnitude, noise, observable)], axis=1)


def whitened_noise_sensitivity(magnitude: Array, noise: Noise, observable: Observable) -> Array:
    """The columns (m, 2 n_level) that ln relative and ln floor of each level have in J.

    They show in the variances alone. `magnitude` (n_speed, n_channel), m.
    """
    parts = noise_variance_slopes(magnitude, noise) / noise.sd(magnitude)[..., None] ** 2
    return _rows(np.zeros_like(parts), parts, observable)


def noise_variance_slopes(magnitude: Array, noise: Noise) -> Array:
    """∂s²/∂(ln relative, ln floor) of each level of the noise (n_speed, n_channel, 2 n_level), m²."""
    columns = []
    for rows in noise.rows or (slice(None),):
        for part in ((noise.relative * magnitude) ** 2, np.broadcast_to(np.square(noise.floor), magnitude.shape)):
            column = np.zeros_like(magnitude)
            column[rows] = 2 * part[rows]
            columns.append(column)
    return np.stack(columns, axis=-1)


def prior_rows(parameters: Parameters, width: int) -> Array:
    """Rows (n_prior, width) of priors in J.

    They are of unknowns in the unit cube and any columns that follow them.
    """
    columns = parameters.with_prior
    rows = np.zeros((len(columns), width))
    rows[np.arange(len(columns)), columns] = 1 / parameters.priors[1]
    return rows


def with_prior_rows(whitened: Array, parameters: Parameters) -> Array:
    """J (m, k) of unknowns in the unit cube with the rows of their priors."""
    return np.vstack([whitened, prior_rows(parameters, whitened.shape[1])]) if len(parameters.with_prior) else whitened


def whitened_difference(response: ComplexArray, other: ComplexArray, noise: Noise, observable: Observable) -> Array:
    """Difference of two responses (n_speed, n_channel) in units of the noise at the other one.

    It has the form of the rows of J for the means.
    """
    difference = observable.seen(response) - observable.seen(other)
    return observable.real_parts((difference / noise.sd(np.abs(other))).ravel())


def projected(whitened: Array, nuisance: Array) -> Array:
    """Project sensitivities (m, d) onto the orthogonal complement of the nuisance sensitivities (m, k)."""
    if not nuisance.size:
        return whitened
    directions = span(nuisance)
    return whitened - directions @ (directions.T @ whitened)


def of_unknowns(whitened: Array, n_unknown: int) -> Array:
    """Sensitivities (m, n_unknown) of the first unknowns in J (m, k), projected off the noise ones.

    These are the later columns.
    """
    return projected(whitened[:, :n_unknown], whitened[:, n_unknown:])


def span(columns: Array, tolerance: float = UNKNOWABLE) -> Array:
    """Orthonormal basis (m, r) of the span of columns (m, k).

    Directions whose singular value is below `tolerance` times the largest are left out.
    """
    directions, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(directions[:, singular > tolerance * max(singular[0], np.finfo(float).tiny)])


def _rows(of_mean: Array | ComplexArray, of_variance: Array, observable: Observable) -> Array:
    """J (m, d) from derivatives (n_speed, n_channel, d) of the means over s and of the variances over s²."""
    d = of_mean.shape[-1]
    means = observable.real_parts(of_mean.reshape(-1, d))
    return np.concatenate([means, np.sqrt(observable.dimensions / 2) * of_variance.reshape(-1, d)])


@dataclass(frozen=True)
class Point:
    """Likelihood at θ (p,): unknowns in the unit cube (d,), then ln relative and ln floor if estimated."""

    theta: Array
    deviance: float
    gradient: Array  # (p,) of the deviance
    whitened: Array  # (m, p); whitenedᵀ whitened is the Fisher information

    @property
    def information(self) -> Array:
        return self.whitened.T @ self.whitened

    @cached_property
    def triangle(self) -> Array:
        """R (p, p), upper triangular, with Rᵀ R the Fisher information, to the accuracy of `whitened`.

        It has fewer rows if `whitened` has.
        """
        return np.asarray(np.linalg.qr(self.whitened, mode="r"))
