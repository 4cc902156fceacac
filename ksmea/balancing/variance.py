"""Variance components of a campaign: what changes slowly from run to run, and what each run has of its own.

Responses of runs i and j have the covariance (over entries, circular complex)

    exp(-|t_i - t_j| / τ) D + δ_ij (1 + κ Σ_p |w_ip|² / scale²) S

with D of a drift (an Ornstein–Uhlenbeck process), S of the spread between runs and κ of its growth with the weights, since
the error of a weight is a part of it. All are found by restricted maximum likelihood: Patterson & Thompson, Biometrika 58
(1971) 545–554. D and S are free Hermitian matrices, of which the Cholesky factors are varied.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from ksmea.arrays import Array, ComplexArray

LOG_SMALLEST, LOG_LARGEST = -9.0, 4.0  # of the diagonal of a Cholesky factor in units of the plain residuals
N_STEP = 400  # of the quasi-Newton search for D and S
F_TOLERANCE = 1e-7  # relative; −ln L is some thousands
N_SCALAR = 30  # evaluations of the search for τ and κ
LOG_STEP = 0.7  # its first step, of ln τ and ln κ


@dataclass(frozen=True)
class Components:
    """`drift` is None without one; `spread` (n_entry, n_entry) m² is that of a run without weights."""

    drift: ComplexArray | None
    spread: ComplexArray
    time_constant: float  # s
    growth: float

    def correlation(self, time: Array, other: Array) -> Array:
        """Of the drift between times, s."""
        return np.exp(-np.abs(time[:, None] - other) / self.time_constant)

    def factor(self, load: Array) -> Array:
        """Of the spread, at loads Σ_p |w_p|² / scale²."""
        return 1 + self.growth * load


@dataclass(frozen=True)
class RestrictedLikelihood:
    """−ln of the restricted likelihood of residuals (n_run, n_entry) under columns (n_run, n_entry, n_coefficient), at times
    and loads (n_run,); a constant is left out that depends on the columns alone."""

    residual: ComplexArray
    columns: ComplexArray
    time: Array | None
    load: Array

    @property
    def n_entry(self) -> int:
        return self.residual.shape[1]

    def fitted(self, start: Components, searched: bool = True, timed: bool = True) -> tuple[Components, float]:
        """The components of the highest likelihood found from a start, and their −ln L. Without a drift in the start there is
        none; `searched`: κ is varied, `timed`: τ is."""
        unit = np.sqrt(np.mean(np.abs(self.residual) ** 2, axis=0))
        has_drift = start.drift is not None
        names = [*(["time_constant"] if has_drift and timed else []), *(["growth"] if searched else [])]
        best = _packed(start, unit)

        def inner(scalars: Array) -> float:
            nonlocal best
            rotated = self._rotated(dataclasses.replace(start, **dict(zip(names, np.exp(scalars).tolist()))))
            found = minimize(
                lambda theta: rotated.value_and_gradient(theta, unit),
                best,
                jac=True,
                method="L-BFGS-B",
                bounds=_bounds(len(unit), 1 + has_drift),
                options={"maxiter": N_STEP, "maxfun": 2 * N_STEP, "ftol": F_TOLERANCE},
            )
            best = found.x
            return float(found.fun)

        first = np.log([getattr(start, name) for name in names])
        if names:
            simplex = np.vstack([first, first + LOG_STEP * np.eye(len(first))])
            outer = minimize(
                inner,
                first,
                method="Nelder-Mead",
                options={"initial_simplex": simplex, "maxfev": N_SCALAR, "xatol": 0.1, "fatol": 0.5},
            )
            first = outer.x
        value = inner(first)
        spread, *drift = (factor @ factor.conj().T for factor in _factors(best, unit))
        scalars = dict(zip(names, np.exp(first).tolist()))
        return dataclasses.replace(start, spread=spread, drift=drift[0] if drift else None, **scalars), value

    def _rotated(self, components: Components) -> _Rotated:
        """Runs turned into directions whose drifts are independent of each other."""
        weight = 1 / np.sqrt(components.factor(self.load))
        share, turn = np.zeros(len(self.load)), np.eye(len(self.load))
        if components.drift is not None and self.time is not None:
            share, turn = np.linalg.eigh(components.correlation(self.time, self.time) * np.outer(weight, weight))
        residual = turn.T @ (self.residual * weight[:, None])
        columns = np.tensordot(turn.T, self.columns * weight[:, None, None], axes=1)
        information = np.einsum("iep,ieq->pq", self.columns.conj(), self.columns)
        constant = -2 * self.n_entry * float(np.sum(np.log(weight))) - float(np.linalg.slogdet(information)[1])
        return _Rotated(residual, columns, np.maximum(share, 0), constant)


@dataclass(frozen=True)
class _Rotated:
    residual: ComplexArray
    columns: ComplexArray
    share: Array  # (n_run,) of the drift in each direction
    constant: float

    def value_and_gradient(self, theta: Array, unit: Array) -> tuple[float, Array]:
        """−ln L and its derivative by the packed factors."""
        factors = _factors(theta, unit)
        covariance = factors[0] @ factors[0].conj().T + np.zeros((len(self.share), 1, 1))
        if len(factors) > 1:
            covariance = covariance + self.share[:, None, None] * (factors[1] @ factors[1].conj().T)
        inverse = np.linalg.inv(covariance)
        weighted = inverse @ self.columns
        information = np.tensordot(self.columns.conj(), weighted, axes=([0, 1], [0, 1]))
        solved = np.linalg.solve(information, np.einsum("iep,ie->p", weighted.conj(), self.residual))
        left = self.residual - self.columns @ solved
        white = np.einsum("ief,if->ie", inverse, left)
        value = (
            -np.linalg.slogdet(inverse)[1].sum()
            + np.vdot(left, white).real
            + np.linalg.slogdet(information)[1]
            + self.constant
        )
        taken = weighted @ np.linalg.inv(information) @ weighted.conj().transpose(0, 2, 1)
        slope = inverse - white[:, :, None] * white[:, None, :].conj() - taken
        totals = [slope.sum(axis=0), np.tensordot(self.share, slope, axes=1)][: len(factors)]
        gradient = [_packed_gradient(2 * total @ factor, factor, unit) for total, factor in zip(totals, factors)]
        return float(value), np.concatenate(gradient)


def _packed(components: Components, unit: Array) -> Array:
    """The Cholesky factors of spread and drift in units of the residuals: real and imaginary parts below the diagonal, and
    logarithms of that."""
    matrices = [components.spread, *([] if components.drift is None else [components.drift])]
    packed = []
    for matrix in matrices:
        scaled = matrix / np.outer(unit, unit)
        factor = np.linalg.cholesky(scaled + 1e-9 * np.trace(scaled).real / len(unit) * np.eye(len(unit)))
        below = factor[np.tril_indices(len(unit), -1)]
        packed += [below.real, below.imag, np.clip(np.log(np.diag(factor).real), LOG_SMALLEST, LOG_LARGEST)]
    return np.concatenate(packed)


def _factors(theta: Array, unit: Array) -> list[ComplexArray]:
    n = len(unit)
    rows, columns = np.tril_indices(n, -1)
    found = []
    for part in theta.reshape(-1, n * n):
        factor = np.zeros((n, n), dtype=complex)
        factor[rows, columns] = part[: len(rows)] + 1j * part[len(rows) : 2 * len(rows)]
        factor[np.arange(n), np.arange(n)] = np.exp(part[2 * len(rows) :])
        found.append(unit[:, None] * factor)
    return found


def _packed_gradient(by_factor: ComplexArray, factor: ComplexArray, unit: Array) -> Array:
    scaled = by_factor * unit[:, None]
    below = scaled[np.tril_indices(len(unit), -1)]
    return np.concatenate([below.real, below.imag, np.diag(scaled).real * np.diag(factor).real / unit])


def _bounds(n_entry: int, n_matrix: int) -> list[tuple[float | None, float | None]]:
    free: list[tuple[float | None, float | None]] = [(None, None)] * (n_entry * (n_entry - 1))
    limited: list[tuple[float | None, float | None]] = [(LOG_SMALLEST, LOG_LARGEST)] * n_entry
    return [*free, *limited] * n_matrix
