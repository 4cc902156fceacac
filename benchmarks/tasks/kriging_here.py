"""Kriging by this project: universal, linear trend, one anisotropic Gaussian correlation for all outputs."""

from __future__ import annotations

import numpy as np

from benchmarks.harness.task import Task
from benchmarks.tasks.responses import read
from surrogates.kriging import Kriging


def fit(samples: str, objective: str = "dace") -> Task:
    """θ estimated and the model made; how good it is, at points held out."""
    data = read(samples)
    return Task(
        lambda turn: Kriging(objective=objective).fit(data.u, data.y, np.random.default_rng(0)),
        quality=lambda model: data.rmse(model.predict(data.held_out_u)),
        units=data.y.shape[1],
    )


def fit_all(samples: str, outputs: int | None = None) -> Task:
    """The same of the first so many outputs, counted as one."""
    data = read(samples)
    return Task(lambda turn: Kriging().fit(data.u, data.y[:, :outputs], np.random.default_rng(0)))


def predict(samples: str, points: int) -> Task:
    data = read(samples)
    model = Kriging().fit(data.u, data.y, np.random.default_rng(0))
    u = data.many_u[:points]
    return Task(lambda turn: model.predict(u), values=lambda found: found, units=points * data.y.shape[1])


def append(samples: str) -> Task:
    """One more sample with θ as it is."""
    data = read(samples)
    model = Kriging().fit(data.u, data.y, np.random.default_rng(0))
    return Task(lambda turn: model.append(data.more_u, data.more_y))
