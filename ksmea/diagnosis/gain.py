"""What an extension is worth on data that it was not fitted to: contiguous blocks of speeds are left out in turn.

Neighbouring speeds know of each other, so that single speeds left out would be predicted by their neighbours; a block
must be predicted by the model. The score is the log density of the left-out data under the fit to the others.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.contracts import Problem
from ksmea.diagnosis.fitting import Fit
from ksmea.likelihood import Likelihood
from ksmea.maximisation import maximise
from ksmea.measurement import Measurement, Noise
from ksmea.model import Model


@dataclass(frozen=True)
class Gain:
    """Log score per left-out block, after minus before, its sum with its standard error, and the rms residuals (m)."""

    by_block: Array  # (n_block,)
    rmse_before: float
    rmse_after: float

    @property
    def log_score(self) -> float:
        return float(self.by_block.sum())

    @property
    def standard_error(self) -> float:
        return float(self.by_block.std(ddof=1) * np.sqrt(len(self.by_block)))

    @property
    def is_proven(self) -> bool:
        return self.log_score > 2 * self.standard_error


def gain(before: Fit, after: Fit, n_block: int, progress: Callable[[], None]) -> Gain:
    """The gain of one fitted model over another, from the speeds in `n_block` contiguous blocks."""
    measurement = before.likelihood.measurement
    n_block = min(n_block, len(measurement.speed))
    scores, squares = [], []
    for block in np.array_split(np.arange(len(measurement.speed)), n_block):
        kept = np.setdiff1d(np.arange(len(measurement.speed)), block)
        results = [_left_out(fit, measurement, kept, block) for fit in (before, after)]
        scores.append(results[1][0] - results[0][0])
        squares.append([result[1] for result in results])
        progress()
    rmse = np.sqrt(np.sum(squares, axis=0) / measurement.values.size)
    return Gain(np.array(scores), float(rmse[0]), float(rmse[1]))


def _left_out(fit: Fit, measurement: Measurement, kept: Array, block: Array) -> tuple[float, float]:
    """Log density of the data in a block under the model fitted to the others, and their summed squared residuals."""
    likelihood = Likelihood(Model(_at(fit.problem, kept)), part_of(measurement, kept))
    start = np.clip(fit.point.theta, likelihood.lower, likelihood.upper)
    theta = maximise(likelihood, start, tolerance=1e-3).theta
    problem = _at(fit.problem, block)
    left_out = part_of(measurement, block)
    if likelihood.noise_is_estimated:
        left_out = dataclasses.replace(left_out, noise=likelihood.noise(theta))
    test = Likelihood(Model(problem), left_out)
    response = problem.response(problem.parameters.to_si(theta[None, : likelihood.d]))[0]
    squares = float(np.sum(np.abs(left_out.seen(response) - left_out.values) ** 2))
    return test.log_density(theta[: likelihood.d]), squares


def _at(problem: Problem, indices: Array) -> Problem:
    return problem.at(problem.speed[indices], problem.channels)


def part_of(measurement: Measurement, indices: Array) -> Measurement:
    """The measurement at some of its speeds."""
    noise = measurement.noise
    if noise is not None and np.ndim(noise.floor):
        noise = Noise(noise.relative, noise.floor[indices])
    return dataclasses.replace(
        measurement, speed=measurement.speed[indices], values=measurement.values[indices], noise=noise
    )
