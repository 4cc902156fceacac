"""Uncertainty budget of a joint fit.

How much of each unknown's variance comes from noise and how much from each uncertain number.

Around the maximum the model is linear: with M = JᵀJ + P the information of data and priors, P diagonal, an estimate is off by
M⁻¹(Jᵀε − P δ), ε standard normal noise and δ the true deviations of the numbers from their statements. Its variance M⁻¹ is the sum of
M⁻¹JᵀJM⁻¹ by noise and Σₖ cov(·, δₖ)² / sdₖ² by the numbers.

The pull of a number is (δ̂ − δ₀) / √(sd² − sd_post²), standard normal where the statement holds (the variance of an estimate and the
prior it shrinks to). For a number that the data hardly see, both parts of the fraction vanish: its pull is a lower bound. The level of the
largest of n pulls is Šidák's (J. Am. Stat. Assoc. 62 (1967) 626–633).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ksmea.arrays import Array, Indices, Mask
from ksmea.likelihood.fisher import UNKNOWABLE, Point
from ksmea.problem.parameters import SEEN, Parameters

LEVEL = 0.01  # chance of a contradiction anywhere where all statements hold


@dataclass(frozen=True)
class InputBudget:
    """Contributions of noise and numbers to the uncertainty of unknowns, at a maximum, in the unit cube.

    The standard deviations (n_prior,) of the numbers, their pulls, and by unknown (d,) the standard deviation by noise
    and by each number (d, n_prior).
    """

    sd: Array
    pull: Array
    by_noise: Array
    by_input: Array

    @property
    def by_inputs(self) -> Array:
        """Standard deviations (d,) by all numbers together."""
        return np.asarray(np.linalg.norm(self.by_input, axis=1))

    @property
    def is_contradicted(self) -> Mask:
        """Which numbers have a pull that is as large in `LEVEL` of cases at most."""
        return np.asarray(np.abs(self.pull) > critical_pull(len(self.pull)))


def critical_pull(n: int, level: float = LEVEL) -> float:
    """The largest of n standard normal numbers in size exceeds it with a chance of `level`.

    >>> round(critical_pull(18), 2)
    3.45
    """
    return float(scipy.stats.norm.isf((1 - (1 - level) ** (1 / max(n, 1))) / 2))


def input_budget(point: Point, parameters: Parameters) -> InputBudget:
    """The budget at a maximum of a joint likelihood."""
    columns, (value, stated) = parameters.with_prior, parameters.priors
    by_noise, by_input, sd = by_noise_and_inputs(point.whitened, len(parameters), columns, stated)
    told = np.sqrt(
        np.maximum(stated**2 - sd**2, (1 - SEEN**2) * stated**2)
    )  # else rounding over nothing for one that is not seen
    return InputBudget(sd, (point.theta[columns] - value) / told, by_noise, by_input)


def by_noise_and_inputs(whitened: Array, d: int, columns: Indices, stated: Array) -> tuple[Array, Array, Array]:
    """Standard deviations of the first d unknowns of J (m, k) by noise and by each prior.

    They are (d,) and (d, n_prior); numbers with priors have (n_prior,). `columns` and `stated`
    (n_prior,) are the places and standard deviations of the priors.
    """
    covariance = _covariance(whitened)
    by_input = covariance[:d, columns] / stated
    by_noise = np.sqrt(np.maximum(np.diag(covariance)[:d] - np.sum(by_input**2, axis=1), 0.0))
    return by_noise, np.abs(by_input), np.minimum(np.sqrt(np.diag(covariance)[columns]), stated)


def _covariance(whitened: Array) -> Array:
    """(JᵀJ)⁻¹ (p, p), of directions that are known at all."""
    scale = np.linalg.norm(whitened, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    _, singular, directions = np.linalg.svd(whitened / scale, full_matrices=False)
    singular = np.maximum(singular, np.sqrt(UNKNOWABLE) * singular[0])
    half = (directions / singular[:, None]) / scale
    return np.asarray(half.T @ half)
