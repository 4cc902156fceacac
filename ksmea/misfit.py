"""The misfit between predicted and measured responses, as residuals whose sum of squares it is.

Forms, with y measured, p predicted, and s their standard deviation (noise, and the surrogate's error where stated):

- `plain`       Σ |p − y|² / mean |y|²: eq. (25) of the paper with the 2-norm; resonance peaks rule it;
- `weighted`    Σ |p − y|² / s(y)²: the noise taken from the data;
- `log`         Σ |ln(p / y)|² |y|² / s(y)²: the same for small errors, and symmetric for large ones, so that a
                prediction far above the data is as bad as one far below; the one to search surrogates with;
- `likelihood`  Σ |p − y|² / s(p)² + ln s(p)²: the noise taken from the prediction, −2 ln L up to a constant.

Complex data have two real residuals per datum, each with half the variance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import unknown
from ksmea.measurement import Measurement
from ksmea.transforms import LARGEST_LOG

FORMS = ("plain", "weighted", "log", "likelihood")

# A least-squares residual must be real, and ln s² can have either sign. Each logarithm is written as the square of
# √(ln s² + LOG_OFFSET) instead; the offset moves no minimum and is taken off again by `offset`.
LOG_OFFSET = 100.0


@dataclass(frozen=True)
class Misfit:
    """Misfit to one measurement.

    `assumed_relative` stands in for the noise where there is none or its level is not known: equal weights in relative
    terms.
    `model_sd` (n_speed, n_channel), m, is the error of a surrogate that predicts, added to the noise.
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
            return self._flat(_log(predicted / self._nonzero) * self._log_weight)
        if self.form == "weighted":
            return self._flat((predicted - y) / self._data_sd)
        sd = self._sd(predicted)
        deviations = self._flat((predicted - y) / sd)
        if not self._has_log_term:
            return deviations
        return np.concatenate([deviations, np.sqrt(self._log_term(sd)).reshape(len(predicted), -1)], axis=1)

    def jacobian(self, predicted: Array | ComplexArray, sensitivity: ComplexArray) -> Array:
        """Derivatives (m, d) of the residuals at one prediction (n_speed, n_channel), from the sensitivity of the
        complex response there (n_speed, n_channel, d); `predicted` is the complex response also for amplitude data."""
        amplitude = np.abs(predicted)
        d_amplitude = (np.conj(predicted)[..., None] * sensitivity).real / amplitude[..., None]
        data, d_data = (amplitude, d_amplitude) if self.measurement.is_amplitude else (predicted, sensitivity)
        y = self.measurement.values
        if self.form == "plain":
            return self._flat_jacobian(d_data / self._plain_scale)
        if self.form == "log":
            return self._flat_jacobian(d_data / data[..., None] * self._log_weight[..., None])
        if self.form == "weighted":
            return self._flat_jacobian(d_data / self._data_sd[..., None])
        sd = self._sd(amplitude)
        d_log_sd = (self._relative**2 * amplitude / sd**2)[..., None] * d_amplitude
        d_deviation = self._flat_jacobian(d_data / sd[..., None] - ((data - y) / sd)[..., None] * d_log_sd)
        if not self._has_log_term:
            return d_deviation
        d_log = self.measurement.dimensions * d_log_sd / np.sqrt(self._log_term(sd))[..., None]
        return np.concatenate([d_deviation, d_log.reshape(-1, sensitivity.shape[-1])])

    def screening(self, predicted: Array | ComplexArray) -> Array:
        """Mean |ln(p / y)| (k,): wide basins where the misfit has narrow valleys, for choosing starts."""
        return np.mean(np.abs(_log(predicted / self._nonzero)), axis=(1, 2))

    def value(self, predicted: Array | ComplexArray) -> Array:
        """Misfit (k,) of predicted data (k, n_speed, n_channel), without the offset of the logarithms."""
        return np.sum(self.residuals(predicted) ** 2, axis=1) - self.offset

    @property
    def offset(self) -> float:
        """What the sum of squared residuals has too much."""
        return LOG_OFFSET * self.measurement.values.size if self._has_log_term else 0.0

    def observed(self, response: ComplexArray) -> Array | ComplexArray:
        """What the measurement would show of a complex response."""
        return self.measurement.seen(response)

    @property
    def _relative(self) -> float:
        return self.measurement.noise.relative if self.measurement.has_noise else self.assumed_relative

    @property
    def _floor(self) -> float:
        return self.measurement.noise.floor if self.measurement.has_noise else 0.0

    @property
    def _has_log_term(self) -> bool:
        return self.form == "likelihood" and self.measurement.has_noise

    @property
    def _plain_scale(self) -> float:
        return float(np.sqrt(np.mean(np.abs(self.measurement.values) ** 2)))

    @property
    def _nonzero(self) -> Array | ComplexArray:
        """The data with zeros replaced by a number whose ratio to any prediction has a logarithm; their weight is zero."""
        y = self.measurement.values
        return np.where(y == 0, np.exp(-LARGEST_LOG), y)

    @property
    def _log_weight(self) -> Array:
        return np.abs(self.measurement.values) / self._data_sd

    @property
    def _data_sd(self) -> Array:
        """s(y); infinite, which is no weight, where y = 0 and the noise has no floor: relative noise says nothing there."""
        sd = self._sd(self.measurement.values)
        return np.where(sd == 0, np.inf, sd)

    def _sd(self, amplitude: Array | ComplexArray) -> Array:
        variance = (self._relative * np.abs(amplitude)) ** 2 + self._floor**2
        return np.sqrt(variance if self.model_sd is None else variance + self.model_sd**2)

    def _log_term(self, sd: Array) -> Array:
        """dimensions · ln(s² / s(y)²) + offset, never negative; a zero s(y) leaves s² in proportion to the data's mean."""
        reference = self._sd(self.measurement.values)
        ratio = sd / np.where(reference == 0, self._plain_scale, reference)
        return np.maximum(2 * self.measurement.dimensions * np.log(ratio) + LOG_OFFSET, 1e-6)

    def _flat(self, scaled: Array | ComplexArray) -> Array:
        """Scaled deviations (k, n_speed, n_channel) → real residuals (k, m)."""
        flat = scaled.reshape(len(scaled), -1)
        if self.measurement.is_amplitude:
            return flat
        return np.sqrt(2) * np.concatenate([flat.real, flat.imag], axis=1)

    def _flat_jacobian(self, scaled: Array | ComplexArray) -> Array:
        flat = scaled.reshape(-1, scaled.shape[-1])
        if self.measurement.is_amplitude:
            return flat
        return np.sqrt(2) * np.concatenate([flat.real, flat.imag])


def _log(ratio: Array | ComplexArray) -> Array | ComplexArray:
    """Logarithm of a ratio of amplitudes (real) or of responses (complex, phase wrapped to ±π)."""
    return np.log(np.maximum(ratio, np.finfo(float).tiny)) if np.isrealobj(ratio) else np.log(ratio)
