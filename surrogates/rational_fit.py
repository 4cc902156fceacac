"""Rational functions of impedances by linear least squares, one per speed.

All channels share a denominator.

From N_c(z, w) − y_c Q(z) = 0 at each sample and channel c, with N_c = Σ_l w_l N_cl(z) linear in the loads w, all coefficients
are the right singular vector of the smallest singular value: Sanathanan & Koerner, IEEE Trans. Autom. Control 8 (1963) 56–58,
doi 10.1109/TAC.1963.1105517, without its reweighting, which exact samples do not need.

What is solved well depends on variables, terms and scales. Each impedance is mapped by t = (z − g) / (z + g), which keeps
the degree of a rational function and spreads a decade of impedances evenly (g is the geometric mean of its limits); terms
are products of Chebyshev polynomials of t; each equation is divided by |y|, each N_c by a typical |y_c|.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, prod

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from ksmea.arrays import ComplexArray

LEAST_RESPONSE = 1e-12  # of the typical one: smaller responses are not weighted up
MIN_FOLDS = 5  # groups in which samples are left out


@dataclass(frozen=True, eq=False)
class Terms:
    """Products of Chebyshev polynomials of impedances, up to a degree in each.

    `low` and `high` (n_impedance, n_speed) are impedances between which values may lie.
    """

    low: ComplexArray
    high: ComplexArray
    degrees: Sequence[int]

    @property
    def count(self) -> int:
        return prod(degree + 1 for degree in self.degrees)

    def at(self, impedance: ComplexArray) -> ComplexArray:
        """(n_impedance, n, n_speed) N/m → (n_speed, n, n_term)."""
        terms = np.ones((*impedance.shape[:0:-1], 1), dtype=complex)
        for z, low, high, degree in zip(impedance, self.low, self.high, self.degrees):
            powers = chebvander(_mapped(z, low, high).T, degree)
            terms = (terms[..., None] * powers[..., None, :]).reshape(*terms.shape[:2], -1)
        return terms


def _mapped(z: ComplexArray, low: ComplexArray, high: ComplexArray) -> ComplexArray:
    """z between two impedances of one phase to between −1 and 1; straight where they hold 0 between them."""
    if np.all((low / high).real > 0):
        middle = high * np.sqrt(low / high)
        return np.asarray((z - middle) / (z + middle) * (high + middle) / (high - middle))
    return np.asarray((2 * z - low - high) / (high - low))


def least_samples(n_term: int, n_channel: int, n_load: int) -> int:
    """Samples with as many equations as there are coefficients, of which one is free.

    The scale of them all.

    >>> least_samples(9, n_channel=2, n_load=1)  # two impedances that two equal bearings share
    13
    """
    return ceil((n_term * (n_channel * n_load + 1) - 1) / n_channel)


def fit_coefficients(terms: ComplexArray, loads: ComplexArray, response: ComplexArray) -> ComplexArray:
    """Coefficients (n_speed, n_term, n_channel n_load + 1) of rational functions, the denominator's last.

    Terms are (n_speed, n, n_term), loads (n, n_load) and responses (n, n_speed, n_channel) at n samples.
    """
    n_speed, n, n_term = terms.shape
    n_channel, n_load = response.shape[2], loads.shape[1]
    size = np.abs(response)
    typical = np.median(size, axis=0)  # (n_speed, n_channel)
    typical = np.where(typical > 0, typical, 1.0)
    weight = 1.0 / np.maximum(size, LEAST_RESPONSE * typical)  # (n, n_speed, n_channel)
    load_size = np.sqrt(np.mean(np.abs(loads) ** 2, axis=0))
    loaded = (loads / load_size)[None, :, None, :, None] * terms[:, :, None, None, :]  # (n_speed, n, 1, n_load, n_term)

    equations = np.zeros((n_speed, n, n_channel, n_channel * n_load + 1, n_term), dtype=complex)
    for channel in range(n_channel):
        own = slice(channel * n_load, (channel + 1) * n_load)
        scale = (weight * typical)[:, :, channel].T[..., None, None, None]
        equations[:, :, channel : channel + 1, own] = scale * loaded
    equations[:, :, :, -1] = -(weight * response).transpose(1, 0, 2)[..., None] * terms[:, :, None, :]
    matrix = equations.reshape(n_speed, n * n_channel, -1)
    _, _, right = np.linalg.svd(matrix, full_matrices=matrix.shape[1] < matrix.shape[2])
    solved = right[:, -1].conj().reshape(n_speed, -1, n_term)
    solved[:, :-1] *= (typical[..., None] / load_size).reshape(n_speed, -1, 1)
    return np.asarray(solved.transpose(0, 2, 1))


def evaluate(coefficients: ComplexArray, terms: ComplexArray, loads: ComplexArray) -> ComplexArray:
    """Responses (n, n_speed, n_channel) from coefficients, terms and loads.

    Terms are (n_speed, n, n_term), loads (n, n_load).
    """
    values = terms @ coefficients
    per_load = values[..., :-1] / values[..., -1:]
    per_load = per_load.reshape(*values.shape[:2], -1, loads.shape[1])
    return np.asarray(np.einsum("sncl,nl->nsc", per_load, loads))


def left_out_predictions(
    terms: ComplexArray, loads: ComplexArray, response: ComplexArray, least: int
) -> ComplexArray | None:
    """Prediction of each sample's response (n, n_speed, n_channel) by fits without it.

    Samples are left out in groups that leave `least` samples or more; None if there are no more than these.
    """
    n = len(loads)
    if n <= least:
        return None
    predicted = np.empty_like(response)
    for out in np.array_split(np.arange(n), min(n, max(MIN_FOLDS, ceil(n / (n - least))))):
        kept = np.setdiff1d(np.arange(n), out)
        coefficients = fit_coefficients(terms[:, kept], loads[kept], response[kept])
        predicted[out] = evaluate(coefficients, terms[:, out], loads[out])
    return predicted
