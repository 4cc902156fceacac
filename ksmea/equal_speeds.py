"""Which speeds of a measurement are the same: of repeats within a run, and of runs that were measured alike."""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, Indices

SAME_SPEED = 1e-4  # relative: beside a resonance of quality 100 a response changes by 2 % over as much


def equal_speeds(speed: Array, tolerance: float = SAME_SPEED) -> list[Indices]:
    """Indices of speeds (n_speed,) that are the same within a relative tolerance of the lowest of them, by rising speed.

    >>> equal_speeds(np.array([2.0, 1.0, 2.0]))
    [array([1]), array([0, 2])]
    """
    order = np.argsort(speed, kind="stable")
    groups: list[list[int]] = []
    for index in order.tolist():
        if groups and speed[index] <= speed[groups[-1][0]] * (1 + tolerance):
            groups[-1].append(index)
        else:
            groups.append([index])
    return [np.array(sorted(group)) for group in groups]
