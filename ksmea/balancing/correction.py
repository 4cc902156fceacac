"""Correction weights by least squares over speeds and channels, and the residual response.

Goodman, J. Eng. Ind. 86 (1964) 273–279, eq. (7): w = −(CᴴC)⁻¹ Cᴴ y0. Intervals are from draws of y0 and C.

Planes whose weights do nearly the same have a large condition number: with columns of C scaled to unit length,
errors of the readings may come back that many times larger, relatively, in the weights (Belsley, Kuh & Welsch,
*Regression Diagnostics*, 1980, ch. 3, who call 30 and more harmful). The readings determine well the directions of w
with larger singular values.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.balancing.estimation import tail
from ksmea.balancing.fit import Fit

HARMFUL = 30.0  # condition number from which planes are called nearly dependent
N_DRAW = 1000  # of the coefficients; the ends of 95 % intervals are then known to a twentieth of their width


@dataclass(frozen=True)
class Correction:
    """Weights (n_plane,) kg m, the residual response (n_entry,) m, and draws of the residual amplitudes.

    Draws are empty, and the variance of the weights None, if the covariance is not known. `p` is the p-value of the
    bare response under the hypothesis of unbalance in the planes alone."""

    weights: ComplexArray
    variance: Array | None  # (n_plane,) of the complex error, (kg m)²
    left: ComplexArray
    left_draws: Array  # (n_draw, n_entry) m
    p: float | None
    condition: float = 1.0  # of influence coefficients, each plane's scaled to unit length
    common: ComplexArray | None = (
        None  # (n_plane,) kg m, without what the readings hardly show; None where they show all
    )

    @property
    def is_determined(self) -> bool:
        return self.condition < HARMFUL


def correction(fit: Fit, rng: np.random.Generator) -> Correction:
    """The weights that, added to the bare rotor at the nominal speeds, leave least vibration.

    Drift is not counted, it has mean 0.
    """
    coefficients = fit.influence.coefficients
    linear = least_squares(coefficients)
    weights = fit.influence.marked(linear)
    left = coefficients[0] + linear @ coefficients[1:]
    condition = condition_number(coefficients)
    common = None if condition < HARMFUL else fit.influence.marked(well_shown(coefficients))
    if fit.dof == 0:
        return Correction(weights, None, left, np.empty((0, len(left))), None, condition, common)
    n = coefficients.size
    covariance = fit.coefficient_covariance[:n, :n]
    scale = np.sqrt(np.diag(covariance).real) + np.finfo(float).tiny
    factor = np.linalg.cholesky(covariance / np.outer(scale, scale) + 1e-12 * np.eye(n))
    normal = rng.standard_normal((N_DRAW, n, 2)) @ np.array([1, 1j]) / np.sqrt(2)
    draws = coefficients + ((normal @ factor.T) * scale).reshape(N_DRAW, *coefficients.shape)
    drawn = least_squares(draws)
    left_draws = np.abs(draws[:, 0] + np.einsum("p,dpe->de", linear, draws[:, 1:]))
    return Correction(
        weights,
        np.mean(np.abs(drawn - linear) ** 2, axis=0),
        left,
        left_draws,
        _p_of_unbalance(fit, linear),
        condition,
        common,
    )


def condition_number(coefficients: ComplexArray) -> float:
    """Condition number of influence coefficients, rows from the second on.

    The coefficients of each plane are scaled to unit length.

    >>> round(condition_number(np.array([[9, 9], [1, 0], [0.96, 0.28]], dtype=complex)), 6)  # cos 16.26° = 0.96: √(1.96 / 0.04)
    7.0
    """
    scaled = coefficients[1:] / np.linalg.norm(coefficients[1:], axis=1, keepdims=True)
    return float(np.linalg.cond(scaled))


def well_shown(coefficients: ComplexArray) -> ComplexArray:
    """The weights of least squares (n_plane,) without the directions whose condition is `HARMFUL`."""
    length = np.linalg.norm(coefficients[1:], axis=1)
    scaled = coefficients[1:].T / length
    return np.asarray(np.linalg.lstsq(scaled, -coefficients[0], rcond=1 / HARMFUL)[0] / length)


def least_squares(coefficients: ComplexArray) -> ComplexArray:
    """Weights (…, n_plane) that leave least of the bare response.

    Coefficients are (…, 1 + n_plane, n_entry).

    >>> least_squares(np.array([[2.0, 4.0j], [1.0, 0.0], [0.0, 2.0j]], dtype=complex))
    array([-2.+0.j, -2.+0.j])
    """
    of_planes = np.swapaxes(coefficients[..., 1:, :], -2, -1)
    inverse = np.linalg.pinv(of_planes, rcond=np.finfo(float).eps * max(of_planes.shape[-2:]))
    return np.asarray((inverse @ -coefficients[..., 0, :, None])[..., 0])


def _p_of_unbalance(fit: Fit, linear: ComplexArray) -> float | None:
    """p-value of the bare response under the hypothesis of weights in the planes alone.

    None if there are no more entries than planes."""
    n_plane, n_entry = fit.influence.planes.shape
    if n_entry <= n_plane:
        return None
    n = fit.influence.coefficients.size
    regressors = np.kron(np.r_[1.0, linear], np.eye(n_entry))
    covariance = regressors @ fit.coefficient_covariance[:n, :n] @ regressors.conj().T
    relation = regressors @ fit.coefficient_relation[:n, :n] @ regressors.T
    both = np.block(
        [[covariance + relation, 1j * (covariance - relation)], [-1j * (covariance + relation), covariance - relation]]
    )
    of_parts = both.real / 2  # of real parts, then of imaginary parts
    by = fit.influence.planes.T
    columns = np.block([[by.real, -by.imag], [by.imag, by.real]])
    bare = np.r_[fit.influence.bare.real, fit.influence.bare.imag]
    weighted = np.linalg.solve(of_parts, columns)
    left = bare - columns @ np.linalg.solve(columns.T @ weighted, weighted.T @ bare)
    chi2 = float(left @ np.linalg.solve(of_parts, left))
    return tail(chi2 / 2, n_entry - n_plane, fit.dof)
