"""Cubic radial basis functions on a linear trend: Buhmann, *Radial Basis Functions*, 2003; by scipy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RBFInterpolator

from ksmea import Predictor, Surrogate, setting


@dataclass(frozen=True)
class RadialBasisPredictor(Predictor):
    """Interpolates all outputs between its samples."""

    interpolator: RBFInterpolator

    def predict(self, u: np.ndarray) -> np.ndarray:
        return self.interpolator(u)


@dataclass(frozen=True)
class RadialBasis(Surrogate):
    """Cubic radial basis functions on a linear trend, through all samples or smoothed."""

    smoothing: float = setting(0.0, "0: through all samples; larger: nearer to the trend", at_least=0)

    def least_samples(self, d: int) -> int:
        return d + 1  # the trend has as many terms

    def fit(self, u: np.ndarray, y: np.ndarray, rng: np.random.Generator) -> RadialBasisPredictor:
        return RadialBasisPredictor(RBFInterpolator(u, y, kernel="cubic", smoothing=self.smoothing))
