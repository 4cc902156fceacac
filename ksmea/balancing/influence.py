"""The mean response of a machine to weights.

Influence coefficients, with what the speed and the size of a weight change.

    y = (y0 + Σ_p c_p w_p (1 + g |w_p / scale|²)) (1 + γ_v (Ω / Ω_v - 1))

per entry, with weights w_p in planes p, the bare response y0, influence coefficients c_p, one slope γ_v = d ln y / d ln Ω per
nominal speed Ω_v and one growth g for all: the cubic term of a machine that answers so, or of large weights that are more
than their mark says. Thearle, Trans. ASME 56 (1934) 745–753, has the first part of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices, Mask

SMALLEST_SINGULAR_VALUE = 1e-6  # of bare response and weights relative to the largest one: below it planes look alike


@dataclass(frozen=True)
class Influence:
    """`coefficients` (1 + n_plane, n_entry): the bare response, m, then influence coefficients, m/(kg m)."""

    coefficients: ComplexArray
    slope: ComplexArray  # (n_speed,); 0 where it is not fitted
    growth: complex  # relative, at a weight of size `scale`; 0 where it is not fitted
    scale: float  # kg m
    speed_of_entry: Indices  # (n_entry,)

    @property
    def bare(self) -> ComplexArray:
        return np.asarray(self.coefficients[0])

    @property
    def planes(self) -> ComplexArray:
        """(n_plane, n_entry) m/(kg m)."""
        return np.asarray(self.coefficients[1:])

    def effective(self, weights: ComplexArray) -> ComplexArray:
        """Weights (…, n_plane) of linear influence coefficients that do what these weights do."""
        return np.asarray(weights * (1 + self.growth * np.abs(weights / self.scale) ** 2))

    def marked(self, effective: ComplexArray) -> ComplexArray:
        """The weights whose `effective` these are, by iteration of the factor between them."""
        factor = np.ones(np.shape(effective), dtype=complex)
        for _ in range(50):  # each takes the error times 2 · growth or less
            factor = 1 + self.growth * np.abs(effective / factor / self.scale) ** 2
        return np.asarray(effective / factor)

    def gain(self, deviation: Array) -> ComplexArray:
        """Factor on each entry by a deviation of the speed (n_run, n_speed), (n_run, n_entry)."""
        return np.asarray(1 + self.slope[self.speed_of_entry] * deviation[:, self.speed_of_entry])

    def response(self, weights: ComplexArray, deviation: Array) -> ComplexArray:
        """(n_run, n_entry) m."""
        return np.asarray((self.bare + self.effective(weights) @ self.planes) * self.gain(deviation))

    def columns(self, weights: ComplexArray, deviation: Array, with_slope: bool, with_growth: bool) -> ComplexArray:
        """Derivatives (n_run, n_entry, n_coefficient) of `response` by coefficients, slopes and growth."""
        n_entry, at, gain = len(self.speed_of_entry), self.speed_of_entry, self.gain(deviation)
        regressors = np.column_stack([np.ones(len(weights)), self.effective(weights)])
        found = [gain[:, :, None] * np.kron(regressors[:, None, :], np.eye(n_entry))]
        if with_slope:
            still = self.bare + self.effective(weights) @ self.planes
            of_speed = at[:, None] == np.arange(len(self.slope))
            found.append((still * deviation[:, at])[:, :, None] * of_speed)
        if with_growth:
            more = weights * np.abs(weights / self.scale) ** 2
            found.append((gain * (more @ self.planes))[:, :, None])
        return np.concatenate(found, axis=2)

    def stepped(self, step: ComplexArray, with_slope: bool, with_growth: bool) -> Influence:
        """Coefficients, slopes and growth changed by a step in the order of `columns`."""
        n = self.coefficients.size
        n_slope = len(self.slope) if with_slope else 0
        return Influence(
            self.coefficients + step[:n].reshape(self.coefficients.shape),
            np.asarray(self.slope + step[n : n + n_slope]) if with_slope else self.slope,
            self.growth + complex(step[-1]) if with_growth else self.growth,
            self.scale,
            self.speed_of_entry,
        )


def tell_planes_apart(weights: ComplexArray) -> bool:
    """Whether runs with weights (n_run, n_plane) determine the bare response and all coefficients."""
    regressors = np.column_stack([np.ones(len(weights)), weights / (np.max(np.abs(weights), initial=0.0) or 1.0)])
    return bool(np.linalg.matrix_rank(regressors, tol=SMALLEST_SINGULAR_VALUE) == regressors.shape[1])


def plain_influence(
    response: ComplexArray, is_missing: Mask, weights: ComplexArray, speed_of_entry: Indices, n_speed: int
) -> Influence:
    """Least squares without slopes or growth, at each speed from the runs that have it."""
    regressors = np.column_stack([np.ones(len(weights)), weights])
    size = float(np.max(np.abs(weights), initial=0.0)) or 1.0
    regressors = regressors / np.r_[1, np.full(weights.shape[1], size)]
    solved = np.empty((regressors.shape[1], len(speed_of_entry)), dtype=complex)
    for index in range(n_speed):
        entries = np.flatnonzero(speed_of_entry == index)
        runs = np.flatnonzero(~is_missing[:, entries[0]])
        solved[:, entries] = np.linalg.lstsq(regressors[runs], response[np.ix_(runs, entries)], rcond=None)[0]
    coefficients: ComplexArray = np.concatenate([solved[:1], solved[1:] / size])
    return Influence(coefficients, np.zeros(n_speed, dtype=complex), 0j, size, speed_of_entry)
