"""Targets of a run: values of excess and error that rate a point, whatever the problem.

The cost of a point is the evaluations of the true model until then and its Jacobians, each at its price (`jacobian_price`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array

# Differences below a tenth of a deviance, or of the CRLB, are none to the data: such results rank alike.
RESOLUTION = 0.1


@dataclass(frozen=True)
class Measure:
    """How good a point is, 0 at best. `main` is the target that tables show where they show one."""

    name: str
    words: str
    targets: tuple[float, ...]  # the farthest first
    main: float

    @property
    def main_index(self) -> int:
        """Index of the main target in `targets`."""
        return self.targets.index(self.main)


# Two for each decade. A point 1 above the maximum lies within one standard deviation of it, and 0.1 within a third of one: the
# data hardly tell it from the maximum.
EXCESS = Measure(
    "excess",
    "deviance above the maximum nearest to the truth",
    (1000.0, 300.0, 100.0, 30.0, 10.0, 3.0, 1.0, 0.3, 0.1),
    1.0,
)
# The maximum of the likelihood itself is about 1 CRLB from the truth, so that 2 and less are its basin.
ERROR = Measure("error", "rms error of the unknowns (CRLB)", (30.0, 10.0, 3.0, 2.0, 1.2), 2.0)
MEASURES = (EXCESS, ERROR)


def reached(values: Array, targets: Sequence[float]) -> np.ndarray:
    """Index (n_target,) of the improvement from which on all values (n,) are at or below each target.

    N where the last is not.

    The excess only falls. The error of the best point may rise again: a target that was passed by chance is not reached.

    >>> reached(np.array([9.0, 2.0, 4.0, 1.0]), (10.0, 5.0, 3.0, 0.5))
    array([0, 1, 3, 4])
    """
    above = ~(np.asarray(values)[None] <= np.asarray(targets)[:, None])  # (n_target, n); not a number is above all
    return np.asarray(len(values) - np.argmax(np.c_[np.ones(len(above), bool), above][:, ::-1], axis=1))


def resolved(values: Array) -> Array:
    """Logarithms of values rounded to the resolution of the data (`RESOLUTION`).

    Values that cannot be distinguished tie.

    >>> resolved(np.array([-3.0, 0.14, 0.98, 1.02, 100.0]))
    array([-1., -1.,  0.,  0.,  2.])
    """
    return np.asarray(np.log10(np.maximum(np.round(np.asarray(values) / RESOLUTION), 1.0) * RESOLUTION))
