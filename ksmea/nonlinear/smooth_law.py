"""A force that is a smooth function of speed and nothing else.

Through values at a few knots, by a Gaussian process.

Between the knots it is the mean of a process with an unknown constant mean and Matérn's correlation of order 5/2, through the
values at the knots: linear in them, which are the coefficients. Beyond the knots nothing is known of it.

C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, eqs. (2.38), (4.17).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import DIRECTIONS
from ksmea.nonlinear.laws import LawOfSpeed

SMOOTH = "smooth"
CORRELATION_LENGTH = 2.0  # distances of the knots: what they hold is smooth between them
PARTS = (("Re", 1.0), ("Im", 1j))


@dataclass(frozen=True)
class SmoothForce(LawOfSpeed):
    """`knots` (n_knot,), rad/s."""

    knots: Array


def smooth(knots: Array) -> SmoothForce:
    """The law with knots (n_knot,), rad/s, rising: real and imaginary part of f_x and f_y at each of them.

    >>> law = smooth(np.array([100.0, 200.0, 400.0]))
    >>> law.at_motion(np.ones((1, 12)), np.array([250.0]), np.zeros((1, 1, 2))).round(9).tolist()
    [[[(1+1j), (1+1j)]]]
    """

    def terms(speed: Array) -> ComplexArray:
        inside = (speed >= knots[0]) & (speed <= knots[-1])
        if not np.all(inside):
            raise SettingError(
                f"smooth force: expected speeds from {knots[0]:g} to {knots[-1]:g} rad/s, where it was measured, got"
                f" {speed[~inside][0]:g}; ask within that range, or measure there"
            )
        unit = np.array(
            [[[factor * (axis == each) for each in DIRECTIONS] for _, factor in PARTS] for axis in DIRECTIONS]
        )
        columns = np.einsum("sk,apd->kapsd", _weights(knots, speed), unit)
        return np.asarray(columns.reshape(-1, len(speed), len(DIRECTIONS)))

    names = tuple(
        (f"{part} f_{axis} at {knot:.4g} rad/s", "N", 1.0) for knot in knots for axis in DIRECTIONS for part, _ in PARTS
    )
    return SmoothForce(SMOOTH, f"smooth function of speed ({len(knots)} knots)", names, terms, knots)


def _weights(knots: Array, speed: Array) -> Array:
    """Weights of the values at the knots in those at other speeds, (n_speed, n_knot)."""
    length = CORRELATION_LENGTH * np.median(np.diff(knots))
    between, to = (_correlation(np.abs(each[:, None] - knots) / length) for each in (knots, speed))
    ones = np.linalg.solve(between, np.ones(len(knots)))
    weights = np.linalg.solve(between, to.T).T
    return np.asarray(weights + (1 - weights.sum(axis=1))[:, None] * ones / ones.sum())


def _correlation(distance: Array) -> Array:
    scaled = np.sqrt(5) * distance
    return np.asarray((1 + scaled + scaled**2 / 3) * np.exp(-scaled))
