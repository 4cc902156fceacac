"""The fitted universal Kriging model.

Prediction, its variance, leave-one-out errors and one more sample.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ksmea.arrays import Array
from ksmea.plugins.surrogate import Predictor
from surrogates.correlation import Correlation, SamplePairs
from surrogates.generalised_least_squares import (
    GeneralisedLeastSquares,
    Trend,
    generalised_least_squares,
    side_by_side,
    solve_lower,
)

CHUNK = 1024  # points predicted at once: r and f of 200 samples then stay in a 2 MB cache


@dataclass(frozen=True)
class OutputGroup:
    """Outputs that share one θ, and their estimates."""

    outputs: slice
    theta: Array  # (d,)
    estimate: GeneralisedLeastSquares


class KrigingPredictor(Predictor):
    """Universal Kriging of q outputs over samples (n, d); the outputs are standardised inside.

    `theta` holds a row per group of outputs that share it, (n_group, d); `notes` the largest nugget, the number of
    repeated samples that were left out, and θ (the geometric mean over groups).
    """

    def __init__(
        self,
        samples: Array,  # (n, d)
        outputs: Array,  # (n, q)
        correlation: Correlation,
        trend: Trend,
        groups: Sequence[OutputGroup],
        mean: Array,  # (q,)
        spread: Array,  # (q,)
        n_repeated: int,
    ) -> None:
        self.samples = samples
        self.outputs = outputs
        self.correlation = correlation
        self.trend = trend
        self.groups = tuple(groups)
        self.mean = mean
        self.spread = spread
        self.n_repeated = n_repeated
        self._weights = [self._prediction_weights(group) for group in self.groups]
        self._rows = [correlation.rows(group.theta, samples) for group in self.groups]

    @property
    def theta(self) -> Array:
        return np.array([group.theta for group in self.groups])

    @property
    def process_variance(self) -> Array:
        """σ² (q,) in squared units of the outputs."""
        return self._over_groups(lambda group: group.estimate.process_variance) * self.spread**2

    @property
    def notes(self) -> Mapping[str, float]:
        theta = np.exp(np.mean(np.log(self.theta), axis=0))
        return {
            "nugget": max(group.estimate.nugget for group in self.groups),
            "repeated_samples": float(self.n_repeated),
            **{f"theta_{k}": float(value) for k, value in enumerate(theta, start=1)},
        }

    def predict(self, u: Array) -> Array:
        """Points (k, d) → predicted outputs (k, q), eq. (22) as r(u)ᵀγ + f(u)ᵀβ."""
        n = len(self.samples)
        predicted = np.empty((len(u), len(self.mean)))
        for first in range(0, len(u), CHUNK):
            points = u[first : first + CHUNK]
            terms = self.trend.terms(points)
            features = np.empty((len(points), n + terms.shape[1]))
            features[:, n:] = terms
            for group, weights, rows in zip(self.groups, self._weights, self._rows):
                features[:, :n] = rows(points)
                predicted[first : first + CHUNK, group.outputs] = features @ weights
        return predicted

    def variance(self, u: Array) -> Array:
        """Points (k, d) → mean squared error of each output (k, q), eq. (16) with c of eq. (21):

        s² = σ² (1 + vᵀ(FᵀR⁻¹F)⁻¹v − rᵀR⁻¹r), v = FᵀR⁻¹r − f, never below zero. Zero at samples without a nugget.
        """
        variance = np.empty((len(u), len(self.mean)))
        for first in range(0, len(u), CHUNK):
            points = u[first : first + CHUNK]
            terms = self.trend.terms(points)
            for group, correlated in zip(self.groups, self._rows):
                factor = self._variance_factor(group, correlated(points), terms)
                rows = slice(first, first + CHUNK)
                variance[rows, group.outputs] = np.outer(factor, group.estimate.process_variance)
        return variance * self.spread**2

    def leave_one_out(self) -> Array:
        """Root mean square leave-one-out error of each output (q,) over samples.

        θ is fixed, β is estimated anew.
        """
        return self.spread * self._over_groups(
            lambda group: np.sqrt(np.mean(group.estimate.leave_one_out() ** 2, axis=0))
        )

    def append(self, u: Array, y: Array) -> KrigingPredictor:
        """Predictor with one more sample u (d,), y (q,), θ as it is.

        It adds a row of the Cholesky factor and is not a new fit.

        A sample that is there already changes nothing: the model is deterministic.
        """
        if np.any(np.all(self.samples == u, axis=1)):
            return self
        samples, outputs = np.vstack([self.samples, u]), np.vstack([self.outputs, y])
        groups = [self._with_last_sample(*each, samples, outputs) for each in zip(self.groups, self._rows)]
        return KrigingPredictor(
            samples, outputs, self.correlation, self.trend, groups, self.mean, self.spread, self.n_repeated
        )

    def _prediction_weights(self, group: OutputGroup) -> Array:
        """γ over β in units of the outputs, the mean in the constant term: (n + p, q of the group)."""
        weights = np.vstack([group.estimate.weights, group.estimate.coefficients]) * self.spread[group.outputs]
        weights[len(self.samples)] += self.mean[group.outputs]
        return weights

    def _variance_factor(self, group: OutputGroup, correlation: Array, terms: Array) -> Array:
        """s²/σ² (k,) at points with rows (k, n) of correlations and terms (k, p) of the trend."""
        estimate = group.estimate
        whitened = solve_lower(estimate.cholesky, correlation.T)  # C⁻¹r, (n, k)
        v = estimate.whitened_trend.T @ whitened - terms.T
        trend_part = np.linalg.solve(estimate.triangle.T, v)  # FᵀR⁻¹F = GᵀG
        return np.maximum(1.0 + np.sum(trend_part**2, axis=0) - np.sum(whitened**2, axis=0), 0.0)

    def _with_last_sample(
        self, group: OutputGroup, correlated: Callable[[Array], Array], samples: Array, outputs: Array
    ) -> OutputGroup:
        """The group with the last row of samples (n + 1, d) and outputs (n + 1, q) added to its estimates."""
        added = samples[-1:]
        estimate = group.estimate.append(
            correlated(added)[0], self.trend.terms(added)[0], self._standardised(outputs[-1:], group)[0]
        )
        if estimate is None:  # too close to another sample for the present nugget
            pairs, terms = SamplePairs.of(samples), self.trend.terms(samples)
            estimate = generalised_least_squares(
                pairs.upper(self.correlation.among(group.theta, pairs.squared)),
                group.estimate.nugget,
                side_by_side(terms, self._standardised(outputs, group)),
                terms.shape[1],
            )
        return replace(group, estimate=estimate)

    def _standardised(self, outputs: Array, group: OutputGroup) -> Array:
        return (outputs[:, group.outputs] - self.mean[group.outputs]) / self.spread[group.outputs]

    def _over_groups(self, of_group: Callable[[OutputGroup], Array]) -> Array:
        """A value per output (q,), gathered from the values of the groups."""
        values = np.empty(len(self.mean))
        for group in self.groups:
            values[group.outputs] = of_group(group)
        return values
