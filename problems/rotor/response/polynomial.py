"""Unbalance response as a ratio of polynomials in the unknown coefficients of bearings.

The dynamic stiffness is linear in each of them, D(x) = D₀ + Σ x_j D_j, so that by Cramer's rule a channel's response per unbalance is
N(x) / Q(x) with Q = det D. Both are known exactly once their coefficients are: a set of unknowns then costs one row of a matrix product.
In an impedance between two ports N and Q are linear, which gives their coefficients from the corners of a box of impedances, by the
updates and determinants of `problems.rotor.response.receptance`; impedances are linear in the unknowns.

Corners lie at zero impedance and at the largest, with a damped phase: monomials of small coefficients of bearings cancel nothing.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from problems.rotor.response.links import NOMINAL_PHASE
from problems.rotor.response.receptance import Reduction

MOST_IMPEDANCES = 6  # whose corners are computed
MOST_MONOMIALS = 120  # with three times as many the updates are as fast
MOST_COEFFICIENTS = 2**20  # 16 MB

Powers = tuple[int, ...]  # of each unknown


@dataclass(frozen=True, eq=False)
class LinearImpedance:
    """An impedance a + Σ_j s_j t_j of scaled unknowns t."""

    constant: ComplexArray  # (n_speed,) N/m
    slopes: dict[int, ComplexArray]  # (n_speed,) N/m, by unknown

    @property
    def largest(self) -> float:
        """A bound of its size where no |t| is above 1; 1 if it is zero."""
        return float(np.max(np.abs(self.constant) + sum(np.abs(each) for each in self.slopes.values()))) or 1.0


@dataclass(frozen=True, eq=False)
class ResponsePolynomial:
    """N and Q of all speeds, channels and planes."""

    scale: Array  # (d,) SI, by which unknowns are divided
    factors: Indices  # (a power of 2, n_monomial): unknown of each factor of a monomial, d for the factor 1
    # (n_monomial, 2 · n_speed · (1 + n_channel · n_plane)): of Q at all speeds, then of N, Re and Im side by side
    coefficients: Array
    shape: tuple[int, int, int]  # n_speed, n_channel, n_plane

    @cached_property
    def nbytes_per_set(self) -> int:
        """Size of the largest temporary array."""
        return self.coefficients[0].nbytes

    def response(self, x: Array, unbalance: ComplexArray) -> ComplexArray:
        """(n, n_speed, n_channel) m at sets x (n, d) SI with the unbalance (n, n_plane) kg m of each plane.

        NaN for a singular rotor.
        """
        determinant, numerator = self._values(self._monomials(x))
        if not determinant.all():  # `np.errstate` in its place would slow every call within it
            is_singular = determinant == 0
            numerator[is_singular], determinant[is_singular] = np.nan, 1
        return _combined(numerator, unbalance[:, None] / determinant[..., None])

    def linearised(
        self, x: Array, unbalance: ComplexArray, unbalance_slopes: ComplexArray
    ) -> tuple[ComplexArray, ComplexArray]:
        """Response (n_speed, n_channel) m at one set x (d,) SI, and its derivatives (n_speed, n_channel, d).

        `unbalance` (n_plane,) kg m of each plane has the derivatives `unbalance_slopes` (n_plane, d).
        """
        powers, lowered = self._derivatives
        slopes = powers * self._products(x[None], lowered)[0] / self.scale[:, None]
        determinant, numerator = self._values(np.concatenate([self._monomials(x[None]), slopes]))
        seen = _combined(numerator, unbalance / determinant[:1, :, None])  # (1 + d, n_speed, n_channel)
        of_coefficients = seen[1:] - seen[0] * (determinant[1:] / determinant[0])[:, :, None]
        of_unbalance = (numerator[0] @ unbalance_slopes) / determinant[0][:, None, None]
        return seen[0], of_coefficients.transpose(1, 2, 0) + of_unbalance

    def _values(self, monomials: Array) -> tuple[ComplexArray, ComplexArray]:
        """Q (n, n_speed) and N (n, n_speed, n_channel, n_plane) of sums of monomials (n, n_monomial).

        There is a product for each set: in one for all, last digits would depend on the number of sets.
        """
        is_alone = len(monomials) == 1  # the same product, without a loop over sets
        found = monomials.dot(self.coefficients) if is_alone else (monomials[:, None] @ self.coefficients)[:, 0]
        values = found.view(complex)
        n_speed = self.shape[0]
        return values[:, :n_speed], values[:, n_speed:].reshape(-1, *self.shape)

    def _monomials(self, x: Array) -> Array:
        """(n, n_monomial)."""
        return self._products(x, self.factors)

    def _products(self, x: Array, factors: Indices) -> Array:
        """(n, …) of factors (…, a power of 2, n_monomial): their products over the second last axis."""
        with_one = np.empty((len(x), len(self.scale) + 1))
        with_one[:, -1] = 1
        np.divide(x, self.scale, out=with_one[:, :-1])
        values = with_one.take(factors, axis=1)
        while values.shape[-2] > 1:
            values = values[..., ::2, :] * values[..., 1::2, :]
        return values[..., 0, :]

    @cached_property
    def _derivatives(self) -> tuple[Array, Indices]:
        """Power of each unknown in each monomial (d, n_monomial), and the factors with that unknown once less."""
        is_factor = self.factors == np.arange(len(self.scale))[:, None, None]
        is_first = is_factor & (np.cumsum(is_factor, axis=1) == 1)
        return is_factor.sum(axis=1).astype(float), np.where(is_first, len(self.scale), self.factors)


def _combined(numerator: ComplexArray, force: ComplexArray) -> ComplexArray:
    """Sum over planes of N (n, n_speed, n_channel, n_plane) times unbalance over Q (n, n_speed, n_plane)."""
    total = numerator[..., 0] * force[..., :1]
    for plane in range(1, numerator.shape[-1]):
        total += numerator[..., plane] * force[..., plane, None]
    return total


def has_few_monomials(impedances: Sequence[Sequence[int]], n_value: int) -> bool:
    """Whether a polynomial pays, from the unknowns of each impedance and the number of values of N."""
    if len(impedances) > MOST_IMPEDANCES:
        return False
    return len(_powers(impedances)) <= min(MOST_MONOMIALS, MOST_COEFFICIENTS // n_value)


def _powers(impedances: Sequence[Sequence[int]]) -> set[Powers]:
    """Powers of the unknowns that a product of linear impedances may have."""
    unknowns = sorted({unknown for each in impedances for unknown in each})
    found = {(0,) * len(unknowns)}
    for each in impedances:
        found |= {_raised(powers, unknowns.index(unknown)) for powers in found for unknown in each}
    return found


def response_polynomial(
    reduction: Reduction, impedances: Sequence[LinearImpedance], scale: Array, n_plane: int
) -> ResponsePolynomial | None:
    """The polynomial of a reduced rotor with impedances in the order of the reduction's own.

    None if the rotor is singular at a corner.
    """
    n_speed, n_channel = len(reduction.speed), len(reduction.receptance) - reduction.n_port
    largest = [each.largest * NOMINAL_PHASE for each in impedances]
    parts = _at_corners(reduction, largest, n_plane)
    if not np.all(np.isfinite(parts)):
        return None
    for axis in range(len(impedances)):  # values at corners → coefficients of Π z_i
        at_zero, at_largest = np.moveaxis(parts, axis, 0)
        at_largest -= at_zero
    terms: dict[Powers, ComplexArray] = {(0,) * len(scale): parts}
    for each, size in zip(impedances, largest):
        terms = _substituted(terms, each, size)
    degree = 2 ** math.ceil(math.log2(max(1, *(sum(powers) for powers in terms))))
    factors = [[unknown for unknown, power in enumerate(powers) for _ in range(power)] for powers in terms]
    padded = [each + [len(scale)] * (degree - len(each)) for each in factors]
    # Of Q, then of N: (n_monomial, n_speed · (1 + n_channel · n_plane))
    rows = [np.concatenate([values[:, 0], values[:, 1:].ravel()]) for values in terms.values()]
    shape = n_speed, n_channel, n_plane
    return ResponsePolynomial(scale, np.array(padded, dtype=int).T.copy(), np.array(rows).view(float), shape)


def _at_corners(reduction: Reduction, largest: Sequence[complex], n_plane: int) -> ComplexArray:
    """Q and N where each impedance is zero or the largest: (2, …, 2, n_speed, 1 + n_channel · n_plane)."""
    corners = np.array(list(product(*((0, size) for size in largest))), dtype=complex)
    n_corner, n_port, n_speed = len(corners), reduction.n_port, len(reduction.speed)
    impedance = np.broadcast_to(corners.T[:, :, None], (len(largest), n_corner, n_speed))
    change = impedance - reduction.nominal[:, None]
    system = np.zeros((n_corner, n_speed, n_port, n_port), dtype=complex)
    system[..., range(n_port), range(n_port)] = 1
    for item, values in zip(reduction.impedances, change, strict=True):
        of_row = reduction.receptance[:n_port, item.row_port]  # (n_port, n_speed)
        system[..., item.column_port] += np.moveaxis(of_row[:, None] * values, 0, -1)
    determinant = np.linalg.det(system)  # (n_corner, n_speed), over the nominal one
    with np.errstate(divide="ignore", invalid="ignore"):
        per_unbalance = reduction.response_per_load(impedance)[:, :n_plane]  # (n_channel, n_plane, n_corner, n_speed)
    numerator = (per_unbalance * determinant).transpose(2, 3, 0, 1).reshape(n_corner, n_speed, -1)
    whole = np.concatenate([determinant[..., None], numerator], axis=2)
    return whole.reshape(*(2,) * len(largest), *whole.shape[1:])


def _substituted(
    terms: dict[Powers, ComplexArray], impedance: LinearImpedance, size: complex
) -> dict[Powers, ComplexArray]:
    """Terms in which the first remaining impedance, in units of a size, is put in by its unknowns."""
    constant = impedance.constant[:, None] / size
    slopes = {unknown: slope[:, None] / size for unknown, slope in impedance.slopes.items()}
    found: dict[Powers, ComplexArray] = defaultdict(lambda: np.zeros((), dtype=complex))
    for powers, (without, with_it) in terms.items():
        found[powers] = found[powers] + without + constant * with_it
        for unknown, slope in slopes.items():
            raised = _raised(powers, unknown)
            found[raised] = found[raised] + slope * with_it
    return dict(found)


def _raised(powers: Powers, unknown: int) -> Powers:
    return (*powers[:unknown], powers[unknown] + 1, *powers[unknown + 1 :])
