"""Kinds of arrays that numbers and indices travel in, complex numbers as real ones, and peaks."""
# Shorter than 40 lines: types that every module uses.

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]


def as_real(values: ComplexArray | Array, axis: int = -1) -> Array:
    """Real parts, then imaginary parts along an axis, as least squares take complex data.

    >>> as_real(np.array([1 + 2j, 3 - 4j]))
    array([ 1.,  3.,  2., -4.])
    """
    return np.concatenate([values.real, values.imag], axis=axis)


def peak_indices(values: Array) -> Indices:
    """Indices of the local maxima of values (n,); the first of equal neighbours counts, an end never.

    >>> peak_indices(np.array([0.0, 2.0, 2.0, 1.0, 3.0])).tolist()
    [1]
    """
    return np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1
