"""What a surrogate becomes by its fit."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

from ksmea.arrays import Array


class Predictor(ABC):
    """A fitted surrogate."""

    @abstractmethod
    def predict(self, u: Array) -> Array:
        """(k, d) → (k, q)."""

    def variance(self, u: Array) -> Array | None:
        """Prediction variance of each output, (k, q). Left out: None, it is not known."""
        return None

    def leave_one_out(self) -> Array | None:
        """Root mean square leave-one-out error of each output, (q,). Left out: None, the prediction counts as exact."""
        return None

    def append(self, u: Array, y: Array) -> Predictor | None:
        """A new predictor with one more sample u (d,), y (q,), cheaper than a new fit. Left out: None, fit anew."""
        return None

    @property
    def notes(self) -> Mapping[str, float]:
        """What is worth keeping in the run's record (a nugget that grew, θ …). Left out: nothing."""
        return {}
