"""Modes followed over spin speed: which free motion at one speed is which at the next.

Each branch is continued by the motion that is most like it, in shape (the modal assurance criterion, R. J. Allemang & D. L. Brown,
*A correlation coefficient for modal vector analysis*, Proc. 1st IMAC, 1982) and in eigenvalue, all branches together by the best
assignment. So two branches that cross keep their direction of whirl, and two that veer apart exchange their shapes slowly.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from ksmea.arrays import Array, ComplexArray
from ksmea.rotordynamics.whirl import BACKWARD, FORWARD, Branches, Motions, direction_of_whirl

LEAST_ALIKE = 0.3  # MAC of a motion that continues a branch
FAR = 0.3  # relative change of an eigenvalue that weighs as much as a shape with nothing in common
SIGNS = {FORWARD: 1.0, BACKWARD: -1.0}


def tracked(motions: Sequence[Motions], n_branch: int) -> Branches:
    """First `n_branch` modes of any speed, followed over all speeds of `motions`.

    Each of these has some more modes.
    """
    n_speed = len(motions)
    histories: list[dict[int, int]] = []  # of each branch: motion by index of the speed
    open_branches: list[int] = []
    for index, now in enumerate(motions):
        taken: set[int] = set()
        if index and open_branches:
            before = [histories[branch][index - 1] for branch in open_branches]
            rows, columns = _assigned(motions[index - 1], before, now)
            for row, column in zip(rows, columns):
                histories[open_branches[row]][index] = column
                taken.add(column)
        histories += [{index: each} for each in range(len(now.eigenvalue)) if each not in taken]
        open_branches = [branch for branch, history in enumerate(histories) if index in history]
    shown = [history for history in histories if any(motion < n_branch for motion in history.values())]
    eigenvalue = np.full((n_speed, len(shown)), np.nan + 1j * np.nan)
    direction = np.full((n_speed, len(shown)), np.nan)
    for column, history in enumerate(shown):
        for index, motion in history.items():
            eigenvalue[index, column] = motions[index].eigenvalue[motion]
            shape = motions[index].shape[motion]
            direction[index, column] = SIGNS.get(direction_of_whirl(shape[:, 0], shape[:, 1]), 0.0)
    order = np.argsort([min(motions[at].eigenvalue[each].imag for at, each in history.items()) for history in shown])
    speed = np.array([each.speed for each in motions])
    return Branches(speed, eigenvalue[:, order], direction[:, order])


def continued(before: Motions, index: int, now: Motions) -> int | None:
    """The motion that continues one of those before; None if none is like it."""
    rows, columns = _assigned(before, range(len(before.eigenvalue)), now)
    return dict(zip(rows, columns)).get(index)


def _assigned(before: Motions, chosen: Sequence[int], now: Motions) -> tuple[list[int], list[int]]:
    """Which of the chosen motions before is continued by which one now."""
    alike = _likeness(before.shape[list(chosen)], now.shape)
    old, new = before.eigenvalue[list(chosen)][:, None], now.eigenvalue[None]
    change = np.abs(new - old) / np.maximum(np.abs(old), np.abs(new))
    rows, columns = scipy.optimize.linear_sum_assignment((1 - alike) + change / FAR)
    kept = alike[rows, columns] >= LEAST_ALIKE
    return rows[kept].tolist(), columns[kept].tolist()


def _likeness(one: ComplexArray, other: ComplexArray) -> Array:
    """MAC of shapes (n, n_place, 2) and (m, n_place, 2), (n, m)."""
    one, other = one.reshape(len(one), -1), other.reshape(len(other), -1)
    sizes = np.sum(np.abs(one) ** 2, axis=1)[:, None] * np.sum(np.abs(other) ** 2, axis=1)
    return np.asarray(np.abs(one.conj() @ other.T) ** 2 / sizes)
