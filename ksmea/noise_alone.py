"""A likelihood as a function of the level of the noise alone: what else it depends on is held."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.point import Point


@dataclass(frozen=True, eq=False)
class NoiseAlone:
    """A likelihood of ln relative and ln floor (p,) between limits, for `ksmea.maximisation`; `at` evaluates it without the model."""

    lower: Array  # (p,)
    upper: Array  # (p,)
    longest_step: Array  # (p,)
    at: Callable[[Array], Point]

    @property
    def d(self) -> int:
        """None of its unknowns lies in the unit cube."""
        return 0

    @property
    def period(self) -> Array:  # (p,)
        return np.full(len(self.lower), np.inf)

    def deviance(self, theta: Array) -> float:
        return self.at(theta).deviance

    def curvature(self, point: Point, step: Array) -> Array:
        """None: the mean does not depend on the noise."""
        return np.zeros(len(point.whitened))

    def other_noise(self, point: Point) -> list[Array]:
        """None: it is what is looked for."""
        return []
