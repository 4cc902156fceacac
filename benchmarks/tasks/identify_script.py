"""The paper's loop as a script of scikit-learn, scipy and a finite-element model.

It takes an afternoon to write: a user has it without this project.

A Latin hypercube of samples; Gaussian-process regression of ln amplitudes; scipy's DE on its prediction, a whole generation in one call;
the model there, until the squared multiple correlation, eq. (23), exceeds 0.999 or `MOST_UPDATES` are done; least squares on the model
from the best point. Generations, population, F, C and the stopping rule are those of the runs here. The model is one of `MODELS`:
numpy's solver over all speeds at once, or ROSS.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import differential_evolution, least_squares
from scipy.stats.qmc import LatinHypercube

from benchmarks.harness.task import Task
from benchmarks.tasks.data import NOISE, read_run_ups
from benchmarks.tasks.kriging import fitted_by_sklearn
from benchmarks.tasks.three_disk import LOWER, UPPER, speeds

MOST_UPDATES = 20
N_SPEED = 53

Model = Callable[[np.ndarray], np.ndarray]  # points (n, 5) of the unit cube → ln amplitudes (n, 106)


def run(run_ups: str, samples: int, model: str) -> Task:
    data, evaluate = read_run_ups(run_ups), MODELS[model]()
    return Task(
        lambda turn: identified(data.of(turn), evaluate, samples, np.random.default_rng(turn)), quality=data.error
    )


def identified(amplitudes: np.ndarray, model: Model, samples: int, rng: np.random.Generator) -> np.ndarray:
    """Unknowns (5,) SI from measured amplitudes (n_speed, 2) m."""
    measured = np.log(amplitudes).ravel()
    u = LatinHypercube(5, rng=rng).random(samples)
    y = model(u)
    for _ in range(MOST_UPDATES):
        surrogate = fitted_by_sklearn(u, y)
        best = differential_evolution(
            lambda points, surrogate=surrogate: np.sum((surrogate.predict(points.T) - measured) ** 2, axis=1),
            [(0.0, 1.0)] * 5,
            strategy="rand1bin",
            mutation=0.8,
            recombination=0.95,
            maxiter=100,
            init=LatinHypercube(5, rng=rng).random(100),
            rng=rng,
            vectorized=True,
            updating="deferred",
            polish=False,
            tol=0.0,
            atol=-1.0,
        ).x
        predicted, modelled = surrogate.predict(best[None])[0], model(best[None])[0]
        u, y = np.vstack([u, best]), np.vstack([y, modelled])
        error, residual = np.exp(predicted) - np.exp(modelled), np.exp(modelled) - amplitudes.ravel()
        if 1 - np.sum(error**2) / np.sum(residual**2) > 0.999:
            break
    start = u[np.argmin(np.sum((y - measured) ** 2, axis=1))]
    found = least_squares(
        lambda point: (model(point[None])[0] - measured) / NOISE, start, bounds=(0.0, 1.0), x_scale=0.1, max_nfev=50
    )
    return in_si(found.x)


def in_si(u: np.ndarray) -> np.ndarray:
    return LOWER + u * (UPPER - LOWER)


def by_numpy() -> Model:
    from benchmarks.tasks.fe_dense import DenseModel

    model = DenseModel(N_SPEED)
    return lambda u: np.log(np.abs(model.response(in_si(u)))).reshape(len(u), -1)


def by_ross() -> Model:
    from benchmarks.tasks import fe_ross

    elements, speed = fe_ross.shaft_and_disks(), speeds(N_SPEED)
    return lambda u: np.log(
        np.abs([fe_ross.by_transfer_matrix(elements, x, speed) for x in np.atleast_2d(in_si(u))])
    ).reshape(len(u), -1)


MODELS: dict[str, Callable[[], Model]] = {"numpy": by_numpy, "ROSS": by_ross}
