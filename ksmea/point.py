"""A point of a likelihood: what its maximisation needs to know there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array


@dataclass(frozen=True)
class Point:
    """The likelihood at θ (p,): unknowns in the unit cube (d,), then ln relative and ln floor where they are
    estimated."""

    theta: Array
    deviance: float
    gradient: Array  # (p,) of the deviance
    whitened: Array  # (m, p); whitenedᵀ whitened is the Fisher information

    @property
    def information(self) -> Array:
        return self.whitened.T @ self.whitened

    @cached_property
    def triangle(self) -> Array:
        """R (p, p), upper triangular, with Rᵀ R the Fisher information, to the accuracy of `whitened`; of fewer rows where that has
        fewer."""
        return np.asarray(np.linalg.qr(self.whitened, mode="r"))
