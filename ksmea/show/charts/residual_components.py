"""The two components of a complex residual, as texts, pages and figures name them: along the fitted response, and a quarter of
a turn ahead of it."""
# Shorter than 40 lines: texts, pages and figures share it.

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, ComplexArray

COMPONENTS = ("in phase", "in quadrature")  # with the fitted response


def components(residual: Array | ComplexArray, fitted: Array | ComplexArray) -> tuple[Array, Array]:
    """Components, each of unit variance, of residuals (measured − fitted) in units of the noise, whose variance is 1 in all.

    >>> along, across = components(np.array([1.0j]), np.array([2.0j]))  # longer by the noise's σ, √2 of a component's
    >>> along.round(3).tolist(), across.round(3).tolist()
    ([1.414], [0.0])
    """
    turned = np.sqrt(2) * residual * np.exp(-1j * np.angle(fitted))
    return turned.real, turned.imag
