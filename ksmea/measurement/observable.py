"""The two observables, and what they show of a complex response: all of it, or its amplitude alone.

Everything that depends on the observable is here, so that misfit, likelihood and Fisher information have one
formula each.
"""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from ksmea.arrays import Array, ComplexArray

LARGEST_LOG = 230.0  # ln of 1e100: logarithms of amplitudes are cut there


class Observable(StrEnum):
    """Observable of a measurement.

    `Observable("complex")` is made from a setting, and is equal to its name.
    """

    AMPLITUDE = "amplitude"
    COMPLEX = "complex"

    @property
    def dimensions(self) -> int:
        """Real numbers of a datum."""
        return 1 if self is Observable.AMPLITUDE else 2

    def seen(self, response: ComplexArray) -> Array | ComplexArray:
        """Observable part of a complex response, without noise, in its shape.

        >>> Observable.AMPLITUDE.seen(np.array([3 + 4j]))
        array([5.])
        """
        return np.abs(response) if self is Observable.AMPLITUDE else response

    def seen_sensitivity(self, response: ComplexArray, sensitivity: ComplexArray) -> Array | ComplexArray:
        """Derivatives (…, d) of the observed quantity, from a response (…) and its derivatives (…, d)."""
        return amplitude_sensitivity(response, sensitivity) if self is Observable.AMPLITUDE else sensitivity

    def real_parts(self, deviation: Array | ComplexArray, axis: int = 0) -> Array:
        """Deviations in units of the noise as real numbers of unit variance.

        There are `dimensions` times as many along an axis: a complex deviation of unit variance has half of it in each
        part.

        >>> Observable.COMPLEX.real_parts(np.array([3 + 4j])) / np.sqrt(2)
        array([3., 4.])
        """
        if self is Observable.AMPLITUDE:
            return np.real(deviation)
        return np.asarray(np.sqrt(2) * np.concatenate([deviation.real, deviation.imag], axis=axis))


def amplitude_sensitivity(response: ComplexArray, sensitivity: ComplexArray) -> Array:
    """Derivatives (…, d) of |q| from the response q (…) and its derivatives (…, d).

    Re(q* ∂q) / |q|, 0 where q is.
    """
    amplitude = np.abs(response)[..., None]
    return np.asarray((np.conj(response)[..., None] * sensitivity).real / np.where(amplitude == 0, 1.0, amplitude))
