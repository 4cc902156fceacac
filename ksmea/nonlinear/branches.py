"""All steady motions of a harmonic balance, by following a curve over the level of the excitation.

At level s of the excitation, y = s Q + G f(y). From rest at s = 0 a curve leads over s, at one speed. If the
resonance curve folds over speed, this curve folds over s, and each passage of s = 1 is a steady motion of the rotor
as it is. It needs no receptances between the speeds, and all speeds are followed at once. The curve goes on as far
as dissipation lets motions grow, and steps are parts of what has been reached (pseudo-arclength: H. B. Keller, in
Applications of Bifurcation Theory, 1977, 359–384; E. L. Allgower and K. Georg, Introduction to Numerical
Continuation Methods, 2003, ch. 6).

Motions at which dI/dy of the equations has a determinant below zero lie between two folds and are unstable:
disturbances grow without changing their phase. That is exact for the folds, at which a Floquet multiplier passes 1.
It does not detect motions that begin to beat (a pair of multipliers leaving the unit circle). Motions on loops over
speed that no curve from rest reaches at their own speed are not found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, Indices, Mask
from ksmea.nonlinear.harmonic_balance import Balance, solved

LINEAR = 0.1  # |G ∂f/∂y| up to which the curve is as good as straight
LEVELS = 0.5 ** np.arange(0, 40, 2.0)  # where it is looked for
FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.3, 1.0, 1e-4  # parts of what is reached
CORRECTIONS = 6  # of a step
EASY = 3  # corrections after which the next step is longer
LONGER, SHORTER = 1.6, 0.4
LEAST_COSINE = 0.3  # between tangents before and after a step
ON_CURVE = 1e-3  # of the motion: the curve is a way, its ends are solved for
MAX_STEPS = 300
BEYOND = 1.2  # times the largest motion that dissipation allows: corrected motions differ


@dataclass(frozen=True)
class Branches:
    """Steady motions, in the order in which the curve of each point meets them, point by point not."""

    point: Indices  # (n_found,)
    motion: Array  # (n_found, p), m
    is_stable: Mask  # (n_found,)


def branches(balance: Balance, largest: Array, only_first: Mask | None = None) -> Branches:
    """All steady-state motions on the curves from rest.

    They are of points whose motion cannot be larger than `largest` (n,), m. `only_first` (n,) marks points for which
    the first one is enough, which is stable.
    """
    level = _linear_up_to(balance)
    only_first = np.zeros(len(level), dtype=bool) if only_first is None else only_first
    motion = level[:, None] * balance.alone
    direction = _tangent(
        balance, motion, level, np.concatenate([motion, level[:, None]], axis=1) / _scale(motion, level)
    )
    step = np.full(len(level), FIRST_STEP)
    active = np.flatnonzero((level != 1) | ~only_first)
    points, starts = [np.flatnonzero(level == 1)], [motion[level == 1]]
    for _ in range(MAX_STEPS):
        here = balance[active]
        scale = _scale(motion[active], level[active])
        ahead = scale * direction[active] * step[active, None]
        reached, is_on, n_correction = _corrected(here, motion[active], level[active], ahead, direction[active], scale)
        step[active] *= np.where(is_on, np.where(n_correction <= EASY, LONGER, 1.0), SHORTER)
        np.minimum(step, LONGEST_STEP, out=step)
        on, new = active[is_on], reached[is_on]
        onwards = _tangent(here[np.flatnonzero(is_on)], new[:, :-1], new[:, -1], direction[on])
        is_straight = np.sum(onwards * direction[on], axis=1) > LEAST_COSINE
        on, new, onwards, old = (each[is_straight] for each in (on, new, onwards, level[on]))
        step[active[is_on][~is_straight]] *= SHORTER
        passed = (old - 1) * (new[:, -1] - 1) < 0
        part = ((1 - old) / np.where(passed, new[:, -1] - old, 1.0))[passed, None]
        points.append(on[passed])
        starts.append((1 - part) * motion[on[passed]] + part * new[passed, :-1])
        motion[on], level[on] = new[:, :-1], new[:, -1]
        direction[on] = onwards
        is_done = (np.linalg.norm(motion[active], axis=1) > BEYOND * largest[active]) | only_first[active]
        is_done &= level[active] > 1
        active = active[~is_done & (step[active] > SHORTEST_STEP)]
        if not len(active):
            break
    return _checked(balance, np.concatenate(points), np.concatenate(starts))


def _checked(balance: Balance, point: Indices, start: Array) -> Branches:
    here = balance[point]
    motion, is_found = solved(here, start)
    here, point, motion = here[np.flatnonzero(is_found)], point[is_found], motion[is_found]
    sign, _ = np.linalg.slogdet(here.left(motion, np.ones(len(point)))[1])
    return Branches(point, motion, sign > 0)


def _linear_up_to(balance: Balance) -> Array:
    """A level (n,) up to which the force as good as does not act."""
    found = np.full(len(balance.alone), LEVELS[-1])
    left = np.arange(len(found))
    for level in LEVELS:
        here = balance[left]
        _, derivative = here.left(level * here.alone, np.full(len(left), level))
        is_linear = np.linalg.norm(derivative - np.eye(derivative.shape[1]), axis=(1, 2)) < LINEAR
        found[left[is_linear]] = level
        left = left[~is_linear]
        if not len(left):
            break
    return found


def _scale(motion: Array, level: Array) -> Array:
    """Units in which steps are measured, (n, p + 1): the motion, and the level."""
    size = np.broadcast_to(np.linalg.norm(motion, axis=1, keepdims=True), motion.shape)
    return np.concatenate([size, level[:, None]], axis=1)


def _tangent(balance: Balance, motion: Array, level: Array, last: Array) -> Array:
    """Unit tangents (n, p + 1), in these units, that point onwards.

    With the derivatives of the equations above them the determinant is above zero, as at rest, all along the curve.
    `last` are the tangents a step before.
    """
    _, by_motion = balance.left(motion, level)
    rows = np.concatenate([by_motion, -balance.alone[..., None]], axis=2) * _scale(motion, level)[:, None]
    bordered = np.concatenate([rows, last[:, None]], axis=1)
    right = np.zeros((*last.shape, 1))
    right[:, -1] = np.linalg.slogdet(bordered)[0][:, None]
    tangent = np.linalg.solve(bordered, right)[..., 0]
    return np.asarray(tangent / np.linalg.norm(tangent, axis=1, keepdims=True))


def _corrected(
    balance: Balance, motion: Array, level: Array, ahead: Array, direction: Array, scale: Array
) -> tuple[Array, Mask, Indices]:
    """Points (n, p + 1) of the curve near predicted ones, whether they are on it, and corrections.

    The predicted points lie `ahead` of known ones. Newton's method corrects them at right angles to the curve; the
    number of its corrections is returned."""
    found = np.concatenate([motion, level[:, None]], axis=1) + ahead
    is_on: Mask = np.zeros(len(found), dtype=bool)
    n_correction = np.zeros(len(found), dtype=int)
    active = np.arange(len(found))
    for number in range(1, CORRECTIONS + 1):
        here = balance[active]
        left, by_motion = here.left(found[active, :-1], found[active, -1])
        rows = np.concatenate([by_motion, -here.alone[..., None]], axis=2) * scale[active, None]
        bordered = np.concatenate([rows, direction[active, None]], axis=1)
        right = np.concatenate([-left, np.zeros((len(active), 1))], axis=1)
        move = np.linalg.solve(bordered, right[..., None])[..., 0] * scale[active]
        found[active] += move
        size = np.linalg.norm(found[active, :-1], axis=1)
        n_correction[active] = number
        is_on[active] = np.linalg.norm(move[:, :-1], axis=1) < ON_CURVE * size
        active = active[~is_on[active]]
        if not len(active):
            break
    far = np.linalg.norm(found[:, :-1] - motion - ahead[:, :-1], axis=1) > np.linalg.norm(ahead[:, :-1], axis=1)
    return found, is_on & (found[:, -1] > 0) & ~far, n_correction
