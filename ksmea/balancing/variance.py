"""Variance components of a campaign.

Some components change slowly from run to run, others belong to each run.

Responses of runs i and j have the covariance (over entries, circular complex)

    exp(-|t_i - t_j| / τ) D + δ_ij (1 + κ Σ_p |w_ip|² / scale²) S

with D of a drift (an Ornstein–Uhlenbeck process), S of the spread between runs and κ of its growth with the weights, since
the error of a weight is a part of it. D and S are Kronecker products of a Hermitian matrix over speeds and one over channels, in
units of what plain influence coefficients leave of each entry; their Cholesky factors are varied. All is found by restricted
maximum likelihood: Patterson & Thompson, Biometrika 58 (1971) 545–554.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from scipy.optimize import fmin_l_bfgs_b, minimize

from ksmea.arrays import Array, ComplexArray

LOG_SMALLEST, LOG_LARGEST = -9.0, 4.0  # of the diagonal of a Cholesky factor in units of the plain residuals
N_STEP = 400  # of the quasi-Newton search for D and S
F_TOLERANCE = 1e-7  # relative; −ln L is some thousands
N_SCALAR = 30  # evaluations of the search for τ and κ
LOG_STEP = 0.7  # its first step, of ln τ and ln κ


@dataclass(frozen=True)
class Components:
    """Components of the variance: `drift`, if estimated, and `spread` (n_entry, n_entry) m².

    `spread` is the covariance of the response of a run without weights."""

    drift: ComplexArray | None
    spread: ComplexArray
    time_constant: float  # s
    growth: float

    def correlation(self, time: Array, other: Array) -> Array:
        """Correlation of the drift between times, s."""
        return np.exp(-np.abs(time[:, None] - other) / self.time_constant)

    def factor(self, load: Array) -> Array:
        """Factor on the spread at loads Σ_p |w_p|² / scale²."""
        return 1 + self.growth * load


@dataclass(frozen=True)
class RestrictedLikelihood:
    """−ln of the restricted likelihood of residuals (n_run, n_entry) under columns.

    Columns are (n_run, n_entry, n_coefficient), times and loads (n_run,). A constant that depends on the columns alone
    is left out.
    """

    residual: ComplexArray
    columns: ComplexArray
    time: Array | None
    load: Array
    n_speed: int

    @property
    def n_entry(self) -> int:
        return int(self.residual.shape[1])

    def fitted(self, start: Components, searched: bool = True, timed: bool = True) -> tuple[Components, float]:
        """Components of the highest likelihood found from a start, and their −ln L.

        A start without a drift gives none. `searched`: κ is varied; `timed`: τ is varied.
        """
        unit = np.sqrt(np.mean(np.abs(self.residual) ** 2, axis=0))
        has_drift = start.drift is not None
        names = [*(["time_constant"] if has_drift and timed else []), *(["growth"] if searched else [])]
        best = _packed(start, unit, self.n_speed)

        def inner(scalars: Array) -> float:
            nonlocal best
            rotated = self._rotated(dataclasses.replace(start, **dict(zip(names, np.exp(scalars).tolist()))))
            best, value, _ = fmin_l_bfgs_b(
                rotated.value_and_gradient,
                best,
                args=(unit, self.n_speed),
                bounds=_bounds(len(unit), self.n_speed, 1 + has_drift),
                factr=F_TOLERANCE / np.finfo(float).eps,
                maxiter=N_STEP,
                maxfun=2 * N_STEP,
            )
            return float(value)

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
        spread, *drift = (factor @ factor.conj().T for factor in _factors(best, unit, self.n_speed))
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

    def value_and_gradient(self, theta: Array, unit: Array, n_speed: int) -> tuple[float, Array]:
        """−ln L and its derivative by the packed factors."""
        pairs, factors = _pairs(theta, len(unit), n_speed), _factors(theta, unit, n_speed)
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
        gradient = [
            _packed_gradient(2 * total @ factor, pair, unit) for total, factor, pair in zip(totals, factors, pairs)
        ]
        return float(value), np.concatenate(gradient)


def _packed(components: Components, unit: Array, n_speed: int) -> Array:
    """The factors of spread and drift in units of the residuals."""
    matrices = [components.spread, *([] if components.drift is None else [components.drift])]
    return np.concatenate([_packed_one(matrix / np.outer(unit, unit), n_speed) for matrix in matrices])


def _packed_one(matrix: ComplexArray, n_speed: int) -> Array:
    """Cholesky factors of matrices over speeds and channels whose Kronecker product is nearest.

    The first entry of the former is 1.
    """
    n_channel = len(matrix) // n_speed
    blocks = matrix.reshape(n_speed, n_channel, n_speed, n_channel)
    of_speeds = np.einsum("vcwc->vw", blocks) / np.trace(blocks[0, :, 0]).real
    of_channels = np.einsum("vcvd,v->cd", blocks, 1 / np.diag(of_speeds).real) / n_speed
    return np.concatenate([_packed_factor(each) for each in (of_speeds, of_channels)])


def _packed_factor(matrix: ComplexArray) -> Array:
    """Real and imaginary parts below the diagonal of the Cholesky factor, and logarithms of that."""
    n = len(matrix)
    factor = np.linalg.cholesky(matrix + 1e-9 * np.trace(matrix).real / n * np.eye(n))
    below = factor[np.tril_indices(n, -1)]
    return np.concatenate([below.real, below.imag, np.clip(np.log(np.diag(factor).real), LOG_SMALLEST, LOG_LARGEST)])


def _factor(packed: Array) -> ComplexArray:
    n = int(np.sqrt(len(packed)))
    rows, columns = np.tril_indices(n, -1)
    factor = np.zeros((n, n), dtype=complex)
    factor[rows, columns] = packed[: len(rows)] + 1j * packed[len(rows) : 2 * len(rows)]
    factor[np.arange(n), np.arange(n)] = np.exp(packed[2 * len(rows) :])
    return factor


def _pairs(theta: Array, n_entry: int, n_speed: int) -> list[tuple[ComplexArray, ComplexArray]]:
    """Factors over speeds and over channels, of the spread and, if there is one, of the drift."""
    length = n_speed**2 + (n_entry // n_speed) ** 2
    return [(_factor(part[: n_speed**2]), _factor(part[n_speed**2 :])) for part in theta.reshape(-1, length)]


def _factors(theta: Array, unit: Array, n_speed: int) -> list[ComplexArray]:
    return [unit[:, None] * np.kron(*pair) for pair in _pairs(theta, len(unit), n_speed)]


def _packed_gradient(by_factor: ComplexArray, pair: tuple[ComplexArray, ComplexArray], unit: Array) -> Array:
    """Derivative by packed factors, from that by both parts of their Kronecker product.

    The parts are the real and the imaginary one.
    """
    of_speeds, of_channels = pair
    n_speed, n_channel = len(of_speeds), len(of_channels)
    scaled = (by_factor * unit[:, None]).reshape(n_speed, n_channel, n_speed, n_channel)
    by_speeds = np.einsum("vcwd,cd->vw", scaled, of_channels.conj())
    by_channels = np.einsum("vcwd,vw->cd", scaled, of_speeds.conj())
    found = []
    for gradient, factor in ((by_speeds, of_speeds), (by_channels, of_channels)):
        below = gradient[np.tril_indices(len(factor), -1)]
        found += [below.real, below.imag, np.diag(gradient).real * np.diag(factor).real]
    return np.concatenate(found)


def _bounds(n_entry: int, n_speed: int, n_matrix: int) -> list[tuple[float | None, float | None]]:
    found: list[tuple[float | None, float | None]] = []
    for n, first in ((n_speed, (0.0, 0.0)), (n_entry // n_speed, (LOG_SMALLEST, LOG_LARGEST))):
        found += [(None, None)] * (n * (n - 1)) + [first] + [(LOG_SMALLEST, LOG_LARGEST)] * (n - 1)
    return found * n_matrix
