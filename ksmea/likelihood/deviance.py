"""The Gaussian deviance, −2 ln L, of data whose standard deviation depends on what is predicted.

With residual r, variance s² and n real numbers of a datum (s² is their total variance),

    −2 ln L = Σ n ln s² + n |r|² / s² + constant,

of which the first term is taken relative to a reference s₀² that does not depend on the prediction, so that it has no
unit. It must not be left out: without it the estimate is biased towards large responses.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.observable import Observable


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
    """s₀², m², from the variances that measured values suggest: where that is zero, which has no logarithm, the mean
    square of all values stands in for it."""
    return np.where(variance == 0, np.mean(np.abs(values) ** 2), variance)
