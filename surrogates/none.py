"""No surrogate: the "prediction" is the true model, counted like every evaluation of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.model import Model
from ksmea.settings import Settings, setting
from ksmea.transforms import TRANSFORMS


@dataclass(frozen=True)
class TrueModel:
    """A predictor without error: it evaluates the model."""

    model: Model

    def predict(self, u: Array) -> Array:
        """Points (k, d) → the model's outputs (k, q)."""
        return self.model.outputs(u)


@dataclass(frozen=True)
class NoSurrogate(Settings):
    """Settings of a method that works on the true model where others work on a surrogate."""

    transform: str = setting("auto", "outputs that are compared", choices=TRANSFORMS)

    def least_samples(self, d: int) -> int:
        return 1

    def fit(self, u: Array, y: Array, model: Model, rng: np.random.Generator) -> TrueModel:
        """The samples say nothing that the model does not."""
        return TrueModel(model)
