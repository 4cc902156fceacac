"""Estimation of the correlation parameters θ.

The objective, its analytic gradient and the search for its minimum.

Both objectives are profiled over β and σ² (`generalised_least_squares`), and their slopes follow from
∂σ_l²/∂θ = −γ_lᵀ (∂R/∂θ) γ_l / n, where β being optimal leaves no term in ∂β, and ∂ln|R|/∂θ = tr(R⁻¹ ∂R/∂θ).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import blas, lapack
from scipy.optimize import minimize

from ksmea.arrays import Array
from surrogates.correlation import Correlation, SamplePairs
from surrogates.generalised_least_squares import GeneralisedLeastSquares, generalised_least_squares, side_by_side

OBJECTIVES = ("likelihood", "dace")

# σ² of a standardised output that the trend reproduces is rounding, eps² over a nugget of 1e-10 at most; without this
# floor its logarithm would decide on θ for all outputs that share it.
VARIANCE_FLOOR = 1e-20


@dataclass(frozen=True)
class ThetaObjective:
    """Objective of θ for outputs (n, q) standardised to spread 1 that share it.

    - `likelihood`: mean_l ln σ_l² + ln|R|/n, the concentrated log-likelihood of independent outputs, −2/(n q) of it;
    - `dace`: ln(Σ_l σ_l²) + ln|R|/n, the logarithm of DACE's Σσ²·|R|^(1/n), with the same minimum.
    """

    name: str
    correlation: Correlation
    pairs: SamplePairs
    terms: Array  # (n, p)
    outputs: Array  # (n, q)
    nugget: float

    def estimate(self, theta: Array) -> GeneralisedLeastSquares:
        """θ (d,) → the least-squares estimates there."""
        return self._estimate(self.correlation.among(theta, self.pairs.squared))

    def value(self, log_theta: Array) -> float:
        return self._value(self.estimate(np.exp(log_theta)))

    def value_and_slope(self, log_theta: Array) -> tuple[float, Array]:
        """The objective and its derivatives with respect to ln θ, (d,)."""
        theta = np.exp(log_theta)
        correlation = self.correlation.among(theta, self.pairs.squared)
        estimate = self._estimate(correlation)
        inverse, _ = lapack.dpotri(estimate.cholesky, lower=1)
        weighted = estimate.weights * np.sqrt(self._output_weights(estimate))
        # R⁻¹ − Σ_l w_l γ_l γ_lᵀ in the lower triangle
        sensitivity = blas.dsyrk(-1.0, weighted, beta=1.0, c=inverse, lower=1, overwrite_c=1)
        # A pair counts twice; the diagonal of ∂R/∂θ is zero.
        pair_weights = self.pairs.values(sensitivity.T) * correlation
        slope = self.correlation.log_slope(theta, self.pairs.squared, pair_weights) * (2.0 / self.pairs.n)
        return self._value(estimate), slope

    def _estimate(self, correlation: Array) -> GeneralisedLeastSquares:
        """Estimates with the correlation (n_pair,) of each pair."""
        n_term = self.terms.shape[1]
        return generalised_least_squares(self.pairs.upper(correlation), self.nugget, self._terms_and_outputs, n_term)

    @cached_property
    def _terms_and_outputs(self) -> Array:
        return side_by_side(self.terms, self.outputs)

    def _value(self, estimate: GeneralisedLeastSquares) -> float:
        variance = estimate.process_variance + VARIANCE_FLOOR
        spread = np.mean(np.log(variance)) if self.name == "likelihood" else np.log(np.sum(variance))
        return float(spread) + estimate.log_determinant / len(estimate.cholesky)

    def _output_weights(self, estimate: GeneralisedLeastSquares) -> Array:
        """Derivative of the objective with respect to σ_l², (q,)."""
        variance = estimate.process_variance + VARIANCE_FLOOR
        if self.name == "likelihood":
            return 1.0 / (len(variance) * variance)
        return np.full(len(variance), 1.0 / np.sum(variance))


def isotropic_minima(objective: ThetaObjective, lower: float, upper: float, n_step: int) -> list[Array]:
    """The local minima, each (d,), on a logarithmic ladder of θ that are equal in all directions.

    A gradient search from a cold start can sit where R is all but singular, or all but the identity, and see no slope.
    There are often two minima: the nugget makes a shallow one of its own at small θ, which can win on the ladder and
    lose once θ differs by direction.
    """
    d = len(objective.pairs.squared)
    ladder = np.linspace(np.log(lower), np.log(upper), n_step)
    values = np.array([np.inf, *(objective.value(np.full(d, log_theta)) for log_theta in ladder), np.inf])
    lowest = (values[1:-1] <= values[:-2]) & (values[1:-1] < values[2:])
    return [np.full(d, np.exp(log_theta)) for log_theta in ladder[lowest]]


def search_theta(objective: ThetaObjective, starts: Sequence[Array], lower: float, upper: float) -> Array:
    """Best θ (d,) of L-BFGS-B searches in ln θ from each of the starts (d,).

    Limits are common to all directions.
    """
    bounds = [(np.log(lower), np.log(upper))] * len(objective.pairs.squared)
    searches = [
        # A step of 1e-6 in the objective is 1e-4 in the log-likelihood of an output with 200 samples.
        minimize(
            objective.value_and_slope,
            np.clip(np.log(start), *bounds[0]),
            jac=True,
            bounds=bounds,
            method="L-BFGS-B",
            options={"ftol": 1e-6, "gtol": 1e-4, "maxiter": 100},
        )
        for start in starts
    ]
    return np.exp(min(searches, key=lambda search: search.fun).x)
