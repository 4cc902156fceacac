"""Generalised least squares of many outputs on one trend, by Cholesky and QR.

Departures are correlated.

The trend of a Kriging model is the polynomial f(u)ᵀβ that the correlated departures are added to, eq. (9).

With R + nugget·I = C Cᵀ, F̃ = C⁻¹F = Q G and Ỹ = C⁻¹Y, the coefficients are β = G⁻¹ Qᵀ Ỹ, the process variances
σ² = ‖Ỹ − F̃β‖²/n and the weights of the departures γ = C⁻ᵀ(Ỹ − F̃β) = R⁻¹(Y − Fβ), as in DACE (Lophaven, Nielsen &
Søndergaard 2002, IMM-TR-2002-12, section 2). Samples share C whatever the number of outputs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import comb

import numpy as np
from scipy.linalg import blas, lapack

from ksmea.arrays import Array
from ksmea.errors import SettingError

DEGREES = {"constant": 0, "linear": 1, "quadratic": 2}


def n_terms(name: str, d: int) -> int:
    """Number of terms p of the full polynomial, cross terms included.

    >>> [n_terms(name, 5) for name in ("constant", "linear", "quadratic")]
    [1, 6, 21]
    """
    return comb(d + DEGREES[name], d)


@dataclass(frozen=True)
class Trend:
    """Polynomial terms in coordinates that run over [-1, 1] on the samples.

    The affine change of coordinates leaves the span of the terms, and so every prediction, as it is; it keeps F well
    conditioned where the samples fill a small part of the unit cube.
    """

    name: str
    centre: Array  # (d,)
    half_width: Array  # (d,)

    def terms(self, u: Array) -> Array:
        """Points (k, d) → rows f(u)ᵀ (k, p), ordered 1, v_1 … v_d, v_1², v_1 v_2 … v_d²."""
        v = (u - self.centre) / self.half_width
        k, d = v.shape
        terms = np.empty((k, n_terms(self.name, d)))
        terms[:, 0] = 1.0
        if DEGREES[self.name] >= 1:
            terms[:, 1 : d + 1] = v
        if DEGREES[self.name] == 2:
            first = d + 1
            for i in range(d):
                terms[:, first : first + d - i] = v[:, i : i + 1] * v[:, i:]
                first += d - i
        return terms


def trend_over(name: str, samples: Array) -> Trend:
    """The trend with its coordinates fitted to samples (n, d), after a check that these determine it."""
    n, d = samples.shape
    lower, upper = samples.min(axis=0), samples.max(axis=0)
    half_width = np.where(upper > lower, (upper - lower) / 2, 1.0)
    trend = Trend(name, (lower + upper) / 2, half_width)
    rank, p = np.linalg.matrix_rank(trend.terms(samples)), n_terms(name, d)
    if rank < p:
        raise SettingError(
            f"a {name} trend has {p} terms and the {n} samples determine {rank} of them:"
            f" spread the samples over all {d} directions, or try a trend of lower degree"
        )
    return trend


# What the nugget climbs when R is not positive definite in floating point. 1e-6 costs an error of the order of 1e-6
# of the outputs' spread; what needs more than that is better solved by moving samples apart.
NUGGET_LADDER = tuple(10.0**exponent for exponent in range(-12, -5))


@dataclass(frozen=True)
class GeneralisedLeastSquares:
    """The factors and estimates at one θ; p trend terms, q outputs."""

    cholesky: Array  # (n, n) C, lower, Fortran order
    nugget: float
    whitened_trend: Array  # (n, p) F̃
    whitened_outputs: Array  # (n, q) Ỹ

    @cached_property
    def _factors(self) -> tuple[Array, Array]:
        """G with the reflectors of Q below its diagonal (n, p), and their factors (p,)."""
        packed, reflectors, _, _ = lapack.dgeqrf(self.whitened_trend)  # a fifth of the time of numpy's for few terms
        return packed, reflectors

    @cached_property
    def orthogonal(self) -> Array:
        """Q (n, p), in Fortran order."""
        return np.asarray(lapack.dorgqr(*self._factors)[0])

    @cached_property
    def triangle(self) -> Array:
        """G (p, p)."""
        packed, _ = self._factors
        return np.triu(packed[: packed.shape[1]])

    @cached_property
    def coefficients(self) -> Array:
        """β (p, q)."""
        return np.linalg.solve(self.triangle, self.orthogonal.T @ self.whitened_outputs).astype(float, copy=False)

    @cached_property
    def whitened_residuals(self) -> Array:
        """Ỹ − F̃β = (I − QQᵀ)Ỹ, (n, q), in Fortran order."""
        seen = blas.dgemm(1.0, self.orthogonal, self.whitened_outputs, trans_a=1)
        return np.asarray(blas.dgemm(-1.0, self.orthogonal, seen, beta=1.0, c=self.whitened_outputs))

    @cached_property
    def process_variance(self) -> Array:
        """σ² (q,), maximum likelihood: divided by n as in DACE and DiceKriging, not by n − p."""
        return np.einsum("ij,ij->j", self.whitened_residuals, self.whitened_residuals) / len(self.cholesky)

    @cached_property
    def weights(self) -> Array:
        """γ (n, q)."""
        return solve_lower(self.cholesky, self.whitened_residuals, transposed=True)

    @property
    def log_determinant(self) -> float:
        """ln |R|."""
        return 2.0 * float(np.log(self.cholesky.diagonal()).sum())

    def leave_one_out(self) -> Array:
        """Errors (n, q) of predicting each sample from the others, θ fixed and β estimated anew.

        Infinite for a sample that alone determines a term of the trend.

        Dubrule 1983 (doi 10.1007/BF01033232): the error is γ_i/B_ii with B = R⁻¹ − R⁻¹F(FᵀR⁻¹F)⁻¹FᵀR⁻¹, the block of
        the inverse of the augmented matrix of eq. (20); here B = C⁻ᵀ(I − QQᵀ)C⁻¹, whose diagonal is a sum of squares.
        """
        inverse = solve_lower(self.cholesky, np.eye(len(self.cholesky), order="F"))
        projected = inverse - self.orthogonal @ (self.orthogonal.T @ inverse)
        diagonal = np.sum(projected**2, axis=0)
        # B_ii is 0 up to rounding, against (R⁻¹)_ii, where nothing is left without sample i.
        determined = diagonal > 1e-12 * np.sum(inverse**2, axis=0)
        return np.where(determined[:, None], self.weights / np.where(determined, diagonal, 1.0)[:, None], np.inf)

    def append(self, correlation: Array, terms: Array, outputs: Array) -> GeneralisedLeastSquares | None:
        """One more sample with r (n,), f (p,) and y (q,): a new row of C, F̃ and Ỹ, O(n²).

        None if rounding has used up the new pivot; its square is at least the nugget in exact arithmetic.
        """
        n = len(self.cholesky)
        row = solve_lower(self.cholesky, correlation[:, None])[:, 0]
        pivot_squared = 1.0 + self.nugget - row @ row
        if pivot_squared < max(self.nugget / 2, n * np.finfo(float).eps):
            return None
        pivot = np.sqrt(pivot_squared)
        cholesky = np.zeros((n + 1, n + 1), order="F")
        cholesky[:n, :n] = self.cholesky
        cholesky[n, :n] = row
        cholesky[n, n] = pivot
        return GeneralisedLeastSquares(
            cholesky,
            self.nugget,
            np.asfortranarray(np.vstack([self.whitened_trend, (terms - row @ self.whitened_trend) / pivot])),
            np.asfortranarray(np.vstack([self.whitened_outputs, (outputs - row @ self.whitened_outputs) / pivot])),
        )


def side_by_side(terms: Array, outputs: Array) -> Array:
    """F (n, p) and Y (n, q) as one matrix in the order that `generalised_least_squares` takes."""
    return np.asfortranarray(np.hstack([terms, outputs]))


def generalised_least_squares(
    correlation: Array, nugget: float, terms_and_outputs: Array, n_term: int
) -> GeneralisedLeastSquares:
    """Estimates for the upper triangle of R (n, n), with F and Y `side_by_side`.

    The diagonal of R is overwritten.
    """
    cholesky, nugget = factorise(correlation, nugget)
    whitened = solve_lower(cholesky, terms_and_outputs)
    return GeneralisedLeastSquares(cholesky, nugget, whitened[:, :n_term], whitened[:, n_term:])


def factorise(correlation: Array, nugget: float) -> tuple[Array, float]:
    """Cholesky factor of R + nugget·I, of which the upper triangle is given, and the nugget used.

    The one given, or the first of the ladder above it that works.
    """
    n = len(correlation)
    climbing = (nugget, *(step for step in NUGGET_LADDER if step > nugget))
    for step in climbing:
        np.fill_diagonal(correlation, 1.0 + step)
        cholesky, failed_at = lapack.dpotrf(correlation.T, lower=1, clean=1)
        if failed_at == 0:
            return cholesky, step
    raise np.linalg.LinAlgError(
        f"the correlation matrix of {n} samples is not positive definite even with a nugget of {climbing[-1]:g}"
        f" (leading minor {failed_at}): samples nearly coincide, or theta is too small; move or drop samples, raise theta_lower"
    )


def solve_lower(cholesky: Array, right: Array, *, transposed: bool = False) -> Array:
    """C⁻¹ B, or C⁻ᵀ B, for a lower triangle C (n, n) and B (n, m)."""
    return blas.dtrsm(1.0, cholesky, right, lower=1, trans_a=int(transposed))
