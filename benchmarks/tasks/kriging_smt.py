"""Kriging by SMT (Saves et al., Adv. Eng. Softw. 188 (2024) 103571, doi 10.1016/j.advengsoft.2023.103571): linear trend, squared
exponential, its own start points and optimiser. One output: several have no θ in common there."""

from __future__ import annotations

import numpy as np
from smt.surrogate_models import KRG

from benchmarks.harness.task import Task
from benchmarks.tasks.responses import read


def fitted(u: np.ndarray, y: np.ndarray) -> KRG:
    """Of one output (n, 1)."""
    model = KRG(poly="linear", corr="squar_exp", print_global=False)
    model.set_training_values(u, y)
    model.train()
    return model


def fit(samples: str) -> Task:
    data = read(samples)
    return Task(
        lambda turn: fitted(data.u, data.y), quality=lambda model: data.rmse(model.predict_values(data.held_out_u))
    )


def predict(samples: str, points: int) -> Task:
    data = read(samples)
    model, u = fitted(data.u, data.y), data.many_u[:points]
    return Task(lambda turn: model.predict_values(u), values=lambda found: found, units=points)
