"""No surrogate: the "prediction" is the true model, counted like every evaluation of it."""
# Shorter than 40 lines: one plugin a file.

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.plugins.surrogate import Predictor, Surrogate
from ksmea.plugins.transforms import TRANSFORMS
from ksmea.settings.settings import setting


@dataclass(frozen=True)
class NoSurrogate(Surrogate):
    """Settings of a method that works on the true model where others work on a surrogate."""

    is_true_model: ClassVar[bool] = True

    transform: str = setting("auto", "outputs that are compared", choices=TRANSFORMS)

    def least_samples(self, d: int) -> int:
        return 1

    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> Predictor:
        """Never requested: a method evaluates the true model in its place."""
        raise TypeError("surrogate=none: expected a method that evaluates the true model, got a fit to samples")
