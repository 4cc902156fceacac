"""The predictive gain of an extended model.

Its elpd difference from the baseline model on left-out blocks of speeds.

Contiguous blocks of speeds are left out in turn. A single speed left out would be predicted by its neighbours; a block
must be predicted by the model. Of several runs a block is a band that all of them leave out. What is compared is the log density of the left-out data under the fit to the others.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ksmea.fits.fitting import Fit
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.numerics.parallel import ALONE, Workers
from ksmea.problem.case import Case
from ksmea.records.extension import ElpdDifference

Indices = NDArray[np.intp]  # of speeds


@dataclass(frozen=True)
class PredictiveGain:
    """Elpd difference, extended minus baseline, and rms errors (m) of predicting left-out blocks by each."""

    elpd: ElpdDifference
    rmse_before: float
    rmse_after: float


def predictive_gain(before: Fit, after: Fit, n_block: int, workers: Workers = ALONE) -> PredictiveGain:
    """Predictive gain of one fitted model over another.

    The speeds are left out in `n_block` contiguous blocks.
    """
    measurement = before.measurement
    n_block = min(n_block, len(measurement.speed))
    differences, squares = [], []
    for block in np.array_split(np.argsort(measurement.speed, kind="stable"), n_block):
        block = np.sort(block)
        kept = np.setdiff1d(np.arange(len(measurement.speed)), block)
        results = [_left_out(fit, kept, block) for fit in (before, after)]
        differences.append(results[1][0] - results[0][0])
        squares.append([result[1] for result in results])
        workers.progress()
    rmse = np.sqrt(np.sum(squares, axis=0) / measurement.values.size)
    return PredictiveGain(ElpdDifference(np.array(differences)), float(rmse[0]), float(rmse[1]))


def _left_out(fit: Fit, kept: Indices, block: Indices) -> tuple[float, float]:
    """Log density of a block of data under the model fitted to the others, and squared residuals.

    The squares are summed.
    """
    likelihood = likelihood_of(Case.of(fit.problem, fit.measurement.part(kept)))
    start = np.clip(fit.point.theta, likelihood.lower, likelihood.upper)
    theta = maximise(likelihood, start, tolerance=1e-3).theta
    left_out = fit.measurement.part(block)
    if likelihood.noise_is_estimated:
        left_out = dataclasses.replace(left_out, noise=likelihood.noise_of(theta, left_out))
    test = likelihood_of(Case.of(fit.problem, left_out))
    problem = test.case.problem
    response = problem.response(problem.parameters.to_si(theta[None, : likelihood.d]))[0]
    squares = float(np.sum(np.abs(left_out.seen(response) - left_out.values) ** 2))
    return test.log_density(theta[: likelihood.d]), squares
