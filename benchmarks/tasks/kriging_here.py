"""Kriging by this project: universal, linear trend, one anisotropic Gaussian correlation for all outputs."""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.harness.task import Task
from benchmarks.tasks.responses import fit_by, predict_by, read
from ksmea.plugins.surrogate import Predictor
from surrogates.kriging import Kriging


def fitted(u: np.ndarray, y: np.ndarray, objective: str = "dace") -> Predictor:
    return Kriging(objective=objective).fit(u, y, np.random.default_rng(0))


def fit(samples: str, objective: str = "dace") -> Task:
    """θ estimated and the model made; how good it is, at points held out."""
    return fit_by(partial(fitted, objective=objective), samples)


def fit_all(samples: str, outputs: int | None = None) -> Task:
    """The same of the first so many outputs, counted as one."""
    data = read(samples)
    return Task(lambda turn: fitted(data.u, data.y[:, :outputs]))


def predict(samples: str, points: int) -> Task:
    return predict_by(fitted, samples, points)


def append(samples: str) -> Task:
    """One more sample with θ as it is."""
    data = read(samples)
    model = fitted(data.u, data.y)
    return Task(lambda turn: model.append(data.more_u, data.more_y))
