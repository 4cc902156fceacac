"""Kriging by OpenTURNS (Baudin, Dutfoy, Iooss & Popelin 2017, doi 10.1007/978-3-319-12385-1_64): linear trend, anisotropic squared
exponential. One output: several at once are a matrix of n·q rows there."""

from __future__ import annotations

import numpy as np
import openturns as ot

from benchmarks.harness.task import Task
from benchmarks.tasks.responses import read

LENGTHS = (1 / np.sqrt(2 * 1e3), 1 / np.sqrt(2 * 1e-3))  # θ from 1e-3 to 1e3

ot.Log.Show(ot.Log.NONE)
ot.TBB.Disable()


def fitted(u: np.ndarray, y: np.ndarray) -> ot.Function:
    """The metamodel of one output (n, 1)."""
    d = u.shape[1]
    covariance = ot.SquaredExponential([0.5] * d)
    covariance.setNuggetFactor(1e-10)
    fitter = ot.GaussianProcessFitter(ot.Sample(u), ot.Sample(y), covariance, ot.LinearBasisFactory(d).build())
    fitter.setOptimizationBounds(ot.Interval([LENGTHS[0]] * d, [LENGTHS[1]] * d))
    fitter.run()
    regression = ot.GaussianProcessRegression(fitter.getResult())
    regression.run()
    return regression.getResult().getMetaModel()


def fit(samples: str) -> Task:
    data = read(samples)
    held_out = ot.Sample(data.held_out_u)
    return Task(lambda turn: fitted(data.u, data.y), quality=lambda model: data.rmse(np.array(model(held_out))))


def predict(samples: str, points: int) -> Task:
    data = read(samples)
    model, u = fitted(data.u, data.y), ot.Sample(data.many_u[:points])
    return Task(lambda turn: np.array(model(u)), values=lambda found: found, units=points)
