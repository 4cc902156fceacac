"""Polynomial response surface, the classical alternative to Kriging.

It is fitted by ordinary least squares with scikit-learn (Box & Wilson 1951; Myers & Montgomery, Response Surface
Methodology).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.plugins.surrogate import Predictor, Surrogate
from ksmea.plugins.transforms import TRANSFORMS
from ksmea.settings.settings import setting

if TYPE_CHECKING:
    from sklearn.pipeline import Pipeline


@dataclass(frozen=True)
class ResponseSurfacePredictor(Predictor):
    """A fitted polynomial of each output, and its samples."""

    pipeline: Pipeline
    samples: Array  # (n, d)
    outputs: Array  # (n, q)

    def predict(self, u: Array) -> Array:
        """Points (k, d) → (k, q)."""
        return self.pipeline.predict(u)

    def leave_one_out(self) -> Array:
        """Root mean square leave-one-out error of each output (q,).

        Residuals over 1 − h_i, h_i the diagonal of the hat matrix; infinite where one sample alone determines a term.
        """
        terms = self.pipeline[0].transform(self.samples)
        orthogonal, _ = np.linalg.qr(terms)
        residuals = self.outputs - orthogonal @ (orthogonal.T @ self.outputs)
        freedom = 1.0 - np.sum(orthogonal**2, axis=1)
        determined = freedom > 1e-12
        errors = np.where(determined[:, None], residuals / np.where(determined, freedom, 1.0)[:, None], np.inf)
        return np.sqrt(np.mean(errors**2, axis=0))

    def append(self, u: Array, y: Array) -> ResponseSurfacePredictor:
        """The surface with one more sample u (d,), y (q,): a new fit, which is cheap."""
        degree = self.pipeline[0].degree
        return fit_response_surface(degree, np.vstack([self.samples, u]), np.vstack([self.outputs, y]))


@dataclass(frozen=True)
class ResponseSurface(Surrogate):
    """Settings of a polynomial response surface.

    >>> u = np.linspace(0.0, 1.0, 5)[:, None]
    >>> predictor = ResponseSurface(degree=2).fit(u, u**2 - u, np.random.default_rng(1))
    >>> print(f"{predictor.predict(np.array([[0.4]]))[0, 0]:.6f}")
    -0.240000
    """

    transform: str = setting("auto", "outputs that are modelled", choices=TRANSFORMS)
    degree: int = setting(2, "degree of the polynomial, cross terms included", at_least=1, at_most=3)

    def least_samples(self, d: int) -> int:
        """One more than the polynomial has terms, so that leave-one-out errors exist."""
        return comb(d + self.degree, d) + 1

    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> ResponseSurfacePredictor:
        """Samples u (n, d), outputs y (n, q); random numbers are not used."""
        n, d = u.shape
        if n < self.least_samples(d):
            raise SettingError(
                f"a response surface of degree {self.degree} in {d} parameters has {comb(d + self.degree, d)} terms and"
                f" needs {self.least_samples(d)} samples, got {n}: take more samples, or try a lower degree"
            )
        return fit_response_surface(self.degree, u, y)


def fit_response_surface(degree: int, samples: Array, outputs: Array) -> ResponseSurfacePredictor:
    """Ordinary least squares of outputs (n, q) on the polynomial of samples (n, d)."""
    from sklearn.linear_model import LinearRegression  # takes a second to import, which other runs need not wait for
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import PolynomialFeatures

    # The constant is a term of the polynomial; a second one fitted apart would be one too many for the hat matrix.
    pipeline = make_pipeline(PolynomialFeatures(degree), LinearRegression(fit_intercept=False))
    return ResponseSurfacePredictor(pipeline.fit(samples, outputs), samples, outputs)
