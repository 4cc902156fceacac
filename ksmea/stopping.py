"""The paper's two stopping rules, over the data (n_speed, n_channel) at the surrogate's optimum."""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, ComplexArray


def squared_multiple_correlation(
    predicted: Array | ComplexArray, modelled: Array | ComplexArray, measured: Array | ComplexArray
) -> float:
    """SMC = 1 − Σ |ŷ − y_FE|² / Σ |y_FE − y_measured|², eq. (23).

    It compares the surrogate's error with the residual, so it is no measure of fit. Without noise both sums go to
    zero together; where the true model meets the data exactly the ratio says nothing, and −inf leaves the decision
    to SDF.

    >>> squared_multiple_correlation(np.array([1.1]), np.array([1.0]), np.array([2.0]))
    0.99
    """
    residual = float(np.sum(np.abs(modelled - measured) ** 2))
    if residual == 0:
        return -np.inf
    return 1 - float(np.sum(np.abs(predicted - modelled) ** 2)) / residual


def simple_difference(predicted: Array | ComplexArray, modelled: Array | ComplexArray) -> float:
    """SDF = Σ |ŷ − y_FE|, eq. (24), m."""
    return float(np.sum(np.abs(predicted - modelled)))
