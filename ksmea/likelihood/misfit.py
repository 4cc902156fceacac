"""The misfit between predicted and measured responses, as residuals whose sum of squares it is.

Forms, with y measured, p predicted, and s their standard deviation (noise, and the surrogate's error where stated):

- `plain`       Σ |p − y|² / mean |y|²: eq. (25) of the paper with the 2-norm; resonance peaks rule it;
- `weighted`    Σ |p − y|² / s(y)²: the noise taken from the data;
- `log`         Σ |ln(p / y)|² |y|² / s(y)²: the same for small errors, and symmetric for large ones, so that a
                prediction far above the data is as bad as one far below; the one to search surrogates with;
- `likelihood`  Σ |p − y|² / s(p)² + ln s(p)²: the noise taken from the prediction, the Gaussian deviance.

Complex data have two real residuals per datum, each with half the variance.

The deviance is −2 ln L of data whose standard deviation depends on what is predicted. With residual r, variance s² and n real
numbers of a datum (s² is their total variance),

    −2 ln L = Σ n ln s² + n |r|² / s² + constant,

of which the first term is taken relative to a reference s₀² that does not depend on the prediction, so that it has no
unit. It must not be left out: without it the estimate is biased towards large responses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import unknown
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import LARGEST_LOG, Observable, amplitude_sensitivity
from ksmea.numerics.screening import log_ratio, mean_log_misfit

FORMS = ("plain", "weighted", "log", "likelihood")

# A least-squares residual must be real, and ln s² can have either sign. Each logarithm is written as the square of
# √(ln s² + LOG_OFFSET) instead; the offset moves no minimum and is taken off again by `offset`.
LOG_OFFSET = 100.0


@dataclass(frozen=True)
class Misfit:
    """Misfit to one measurement.

    `assumed_relative` is used in place of the noise level if data are free of noise or the level is not known: equal
    weights in relative terms. `model_sd` (n_speed, n_channel), m, is the error of a surrogate that predicts, added
    to the noise.
    """

    measurement: Measurement
    form: str
    assumed_relative: float = 0.01
    model_sd: Array | None = None

    def __post_init__(self) -> None:
        if self.form not in FORMS:
            raise unknown("misfit", self.form, FORMS)

    def residuals(self, predicted: Array | ComplexArray) -> Array:
        """Predicted data (k, n_speed, n_channel) → residuals (k, m)."""
        y = self.measurement.values
        if self.form == "plain":
            return self._flat((predicted - y) / self._plain_scale)
        if self.form == "log":
            return self._flat(log_ratio(predicted, self._nonzero) * self._log_weight)
        if self.form == "weighted":
            return self._flat((predicted - y) / self._data_sd)
        variance = self._variance(predicted)
        deviations = self._flat((predicted - y) / np.sqrt(variance))
        if not self._has_log_term:
            return deviations
        return np.concatenate([deviations, self._root_of_log_term(variance).reshape(len(predicted), -1)], axis=1)

    def jacobian(self, response: ComplexArray, sensitivity: ComplexArray) -> Array:
        """Derivatives (m, d) of the residuals at one complex response (n_speed, n_channel).

        They are from its sensitivity (n_speed, n_channel, d).
        """
        y, observable = self.measurement.values, self.measurement.kind
        data, d_data = observable.seen(response), observable.seen_sensitivity(response, sensitivity)
        if self.form == "plain":
            return self._flat_jacobian(d_data / self._plain_scale)
        if self.form == "log":
            return self._flat_jacobian(d_data / data[..., None] * self._log_weight[..., None])
        if self.form == "weighted":
            return self._flat_jacobian(d_data / self._data_sd[..., None])
        amplitude = np.abs(response)
        variance = self._variance(amplitude)
        sd = np.sqrt(variance)
        d_log_sd = (self._noise.relative**2 * amplitude / variance)[..., None] * amplitude_sensitivity(
            response, sensitivity
        )
        d_deviation = self._flat_jacobian(d_data / sd[..., None] - ((data - y) / sd)[..., None] * d_log_sd)
        if not self._has_log_term:
            return d_deviation
        d_root = observable.dimensions * d_log_sd / self._root_of_log_term(variance)[..., None]
        return np.concatenate([d_deviation, d_root.reshape(-1, sensitivity.shape[-1])])

    def residual_sd(self, predicted: Array | ComplexArray, sd: Array) -> Array:
        """Standard deviation (k, m) of the residuals of predicted data, to first order.

        `sd` (k, n_speed, n_channel), m, is the standard deviation of the predicted data. The form `likelihood` is
        excluded (ValueError), since its noise depends on the prediction."""
        scale: Array | float
        match self.form:
            case "plain":
                scale = self._plain_scale
            case "log":
                scale = np.abs(predicted) / self._log_weight
            case "weighted":
                scale = self._data_sd
            case _:
                raise ValueError("misfit: expected plain, weighted or log, got likelihood; take one of these")
        return np.tile((sd / scale).reshape(len(predicted), -1), self.measurement.kind.dimensions)

    def screening(self, predicted: Array | ComplexArray) -> Array:
        """Mean |ln(p / y)| (k,): wide basins where the misfit has narrow valleys, for choosing starts."""
        return mean_log_misfit(log_ratio(predicted, self._nonzero))

    def value(self, predicted: Array | ComplexArray) -> Array:
        """Misfit (k,) of predicted data (k, n_speed, n_channel), without the offset of the logarithms."""
        return np.asarray(np.sum(self.residuals(predicted) ** 2, axis=1) - self.offset)

    @property
    def offset(self) -> float:
        """Constant to subtract from the sum of squared residuals."""
        return LOG_OFFSET * self.measurement.values.size if self._has_log_term else 0.0

    def observed(self, response: ComplexArray) -> Array | ComplexArray:
        """Observable part of a complex response."""
        return self.measurement.seen(response)

    @property
    def _noise(self) -> Noise:
        """The measurement's noise, or what stands in for it."""
        noise = self.measurement.noise
        return Noise(self.assumed_relative, 0.0) if noise is None or noise.is_absent else noise

    @property
    def _has_log_term(self) -> bool:
        return self.form == "likelihood" and self.measurement.has_noise

    @property
    def _plain_scale(self) -> float:
        return float(np.sqrt(np.mean(np.abs(self.measurement.values) ** 2)))

    @property
    def _nonzero(self) -> Array | ComplexArray:
        """The data with zeros replaced by a number whose ratio to any prediction has a logarithm.

        Their weight is zero.
        """
        y = self.measurement.values
        return np.where(y == 0, np.exp(-LARGEST_LOG), y)

    @property
    def _log_weight(self) -> Array:
        return np.asarray(np.abs(self.measurement.values) / self._data_sd)

    @property
    def _data_sd(self) -> Array:
        """s(y); infinite, which is not a weight, where y = 0 and the noise has no floor.

        Relative noise says nothing there.
        """
        sd = np.sqrt(self._variance(self.measurement.values))
        return np.where(sd == 0, np.inf, sd)

    def _variance(self, data: Array | ComplexArray) -> Array:
        variance = self._noise.variance(np.abs(data))
        return variance if self.model_sd is None else variance + self.model_sd**2

    def _root_of_log_term(self, variance: Array) -> Array:
        """√(n ln(s² / s(y)²) + offset): the square that the logarithm of the deviance is made, never negative."""
        values = self.measurement.values
        reference = reference_variance(self._variance(values), values)
        return np.asarray(np.sqrt(np.maximum(log_term(variance, reference, self.measurement.kind) + LOG_OFFSET, 1e-6)))

    def _flat(self, scaled: Array | ComplexArray) -> Array:
        """Scaled deviations (k, n_speed, n_channel) → real residuals (k, m)."""
        return self.measurement.kind.real_parts(scaled.reshape(len(scaled), -1), axis=1)

    def _flat_jacobian(self, scaled: Array | ComplexArray) -> Array:
        return self.measurement.kind.real_parts(scaled.reshape(-1, scaled.shape[-1]))


def deviance(
    squared: Array,
    variance: Array,
    reference: Array | float,
    observable: Observable,
    axis: int | tuple[int, ...] | None = None,
) -> Array:
    """D = Σ n ln(s² / s₀²) + n |r|² / s², summed over `axis` (all of them if not given).

    `squared` is |r|², `variance` s² and `reference` s₀², all in m² and in shapes that go together.

    >>> float(deviance(np.array([4.0]), np.array([2.0]), 2.0, Observable.AMPLITUDE))
    2.0
    """
    return np.asarray(
        np.sum(log_term(variance, reference, observable) + observable.dimensions * squared / variance, axis=axis)
    )


def log_term(variance: Array, reference: Array | float, observable: Observable) -> Array:
    """n ln(s² / s₀²), datum by datum: what of the deviance has no residual."""
    return np.asarray(observable.dimensions * np.log(variance / reference))


def reference_variance(variance: Array, values: Array | ComplexArray) -> Array:
    """s₀², m², from the variances that measured values suggest.

    A zero, which has no logarithm, is replaced by the mean square of all values.
    """
    return np.where(variance == 0, np.mean(np.abs(values) ** 2), variance)
