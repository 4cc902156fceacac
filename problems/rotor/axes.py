"""Matrices over the two lateral axes, one for each of many sets and speeds: (2, 2, …), the axes first."""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, ComplexArray


def product(one: ComplexArray | Array, other: ComplexArray | Array) -> ComplexArray:
    """Matrix products (2, 2, …)."""
    return np.asarray(one[:, 0, None] * other[None, 0] + one[:, 1, None] * other[None, 1])


def inverse(matrices: ComplexArray | Array) -> ComplexArray:
    """Inverse matrices (2, 2, …)."""
    (a, b), (c, d) = matrices
    return np.array([[d, -b], [-c, a]]) / (a * d - b * c)
