"""Trial weights for a machine, at its disks.

Large enough to show, and no larger than the machine tolerates.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.campaign import Weight
from ksmea.problem.problem import Problem
from ksmea.units import DEGREE, GRAM_MILLIMETRE

ANGLES = (0.0, 90.0, 180.0, 270.0)  # degrees


def equal_unbalance(problem: Problem, x: Array, positions: Sequence[float] | Array) -> float:
    """Unbalance (kg m, two digits in g mm) that causes as much vibration as there is at values x (d,) SI.

    It acts at the position (m) at which it causes most vibration, rms over all speeds and channels.
    """
    response = problem.response(x[None])[0]
    unit = [
        problem.with_unbalance(float(position), GRAM_MILLIMETRE, 0.0).response(x[None])[0] - response
        for position in positions
    ]
    ratio = np.linalg.norm(response) / max(np.linalg.norm(change) for change in unit)
    return float(f"{ratio:.1e}") * GRAM_MILLIMETRE


def weight_positions(problem: Problem) -> list[float]:
    """Where on the shaft a weight could be fixed, m: at its disks, or at any site where it has none."""
    return sorted(set(disk_positions(problem).values())) or problem.sites.tolist()


def trial_weights(problem: Problem, x: Array) -> list[Weight]:
    """Weights of that size at each of these positions and at four angles. None if the problem takes none."""
    positions = weight_positions(problem)
    if not problem.takes_unbalance or not positions:
        return []
    magnitude = equal_unbalance(problem, x, positions)
    return [Weight(position, magnitude, angle * DEGREE) for position in positions for angle in ANGLES]


ON_DISK = 1e-3  # m, from the middle of a disk: a weight that is nearer sits on it


def disk_positions(problem: Problem) -> dict[str, float]:
    """Where each disk is, m, by its name; empty if the problem knows of none."""
    return {name: position for name, position in problem.landmarks.items() if name.startswith("disk")}


def is_on(position: float, disk: float) -> bool:
    """Whether a weight at a position sits on a disk at another, both m."""
    return abs(position - disk) <= ON_DISK
