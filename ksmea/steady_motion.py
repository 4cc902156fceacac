"""The steady motion of a site under a force that depends on it: q = Q + G f(q), by Newton's method at each speed.

Q is the motion without the force and G that per unit of it. f need not be analytic in q: the equations are solved for the four
real numbers of q. Where a resonance curve folds over there are several solutions; which one is found is a choice: the one
that Newton's method leads to from Q, or from a motion that is known from elsewhere, as by measurement; and where it leads
nowhere, from the solution at the speed below, as in a slow run-up, then from that at the speed above, and at last from smaller
and turned motions.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ksmea.arrays import Array, ComplexArray
from ksmea.nonlinear_forces import ForceOfMotion

Mask = NDArray[np.bool_]

MAX_ITERATIONS = 60
CONVERGED = 1e-11  # of |Q|: rounding keeps a motion that is a million times as large from it, which is none
# Times Q, where Newton's method starts at last: a force that holds the site back turns its phase too.
PARTS = np.outer([1.0, 0.3, 0.1], np.exp(2j * np.pi * np.arange(6) / 6)).ravel()[1:]
SHORTEST = 2.0**-12  # part of a Newton step


@dataclass(frozen=True)
class SiteMotion:
    """How a site moves at speeds (n_speed,), rad/s: by Q (n, n_speed, 2), m, without a force on it, and by G
    (n, n_speed, 2, 2), m/N, with each unit of that. `near` (n, n_speed, 2), m, is a motion that is known from elsewhere."""

    speed: Array
    without_force: ComplexArray
    per_force: ComplexArray
    near: ComplexArray | None = None


def steady_motion(force: ForceOfMotion, coefficients: Array, site: SiteMotion) -> ComplexArray:
    """q (n, n_speed, 2), m, under a force with coefficients (n, n_coefficient).

    Raises LinAlgError where no steady motion is found."""
    motion, per_force = site.without_force, site.per_force
    found, is_found = _newton(force, coefficients, motion, per_force, motion if site.near is None else site.near)
    if is_found.all():
        return found
    rising = np.argsort(site.speed)
    for order in (rising, rising[::-1]):
        for last, index in pairwise(order):
            lacking = np.logical_not(is_found[:, index]) & is_found[:, last]
            if lacking.any():
                only, start = np.ix_(lacking, [index]), found[np.ix_(lacking, [last])]
                solved = _newton(force, coefficients[lacking], motion[only], per_force[only], start)
                found[only], is_found[only] = solved
    for part in PARTS:
        rows, columns = (np.flatnonzero(np.any(~is_found, axis=axis)) for axis in (1, 0))
        if not len(rows):
            break
        only = np.ix_(rows, columns)
        further, is_further = _newton(force, coefficients[rows], motion[only], per_force[only], part * motion[only])
        found[only] = np.where((is_further & ~is_found[only])[..., None], further, found[only])
        is_found[only] |= is_further
    if not is_found.all():
        raise np.linalg.LinAlgError("no steady motion was found under this force")
    return found


def _newton(
    force: ForceOfMotion, coefficients: Array, motion: ComplexArray, per_force: ComplexArray, start: ComplexArray
) -> tuple[ComplexArray, Mask]:
    """q from a start, and where it is a solution (n, n_speed). A step is halved until it lowers |q − Q − G f(q)|."""
    found = np.array(start)
    part = np.ones(found.shape[:2])
    is_found: Mask = np.zeros(found.shape[:2], dtype=bool)
    acting = force(coefficients, found)
    left = found - motion - _times(per_force, acting.force)
    for _ in range(MAX_ITERATIONS):
        size = np.linalg.norm(left, axis=-1)
        is_found = size <= CONVERGED * np.linalg.norm(motion, axis=-1)
        if np.all(is_found | (part < SHORTEST)):
            break
        step = _solved(np.eye(2) - per_force @ acting.by_motion, -per_force @ acting.by_conjugate, -left)
        trial = found + np.where(is_found, 0.0, part)[..., None] * step
        tried = force(coefficients, trial)
        rest = trial - motion - _times(per_force, tried.force)
        is_lower = np.linalg.norm(rest, axis=-1) < size
        part = np.where(is_lower, np.minimum(2 * part, 1.0), part / 2)
        found, left = (np.where(is_lower[..., None], *pair) for pair in ((trial, found), (rest, left)))
        acting = tried.where(is_lower, acting)
    return found, is_found


def _solved(of_motion: ComplexArray, of_conjugate: ComplexArray, right: ComplexArray) -> ComplexArray:
    """x of A x + B conj(x) = b, with A and B (…, 2, 2) and b (…, 2)."""
    total, difference = of_motion + of_conjugate, of_motion - of_conjugate
    real = np.block([[total.real, -difference.imag], [total.imag, difference.real]])
    solved = np.linalg.solve(real, np.concatenate([right.real, right.imag], axis=-1)[..., None])[..., 0]
    return np.asarray(solved[..., :2] + 1j * solved[..., 2:])


def _times(matrix: ComplexArray, vector: ComplexArray) -> ComplexArray:
    return np.asarray((matrix @ vector[..., None])[..., 0])
