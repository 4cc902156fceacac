"""What surrogates are fitted to: ln amplitude of the three-disk rotor at 53 speeds in x and y, (n, 106), over a Latin hypercube of its
unknowns, or one of these outputs. It is made once by this project and handed to all sides as a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.task import Task

Fitted = Callable[[np.ndarray, np.ndarray], Any]  # a model of points (n, 5) and outputs (n, q)
N_HELD_OUT, N_MANY = 1000, 10_000
ONE = 42  # the output of those who fit one at a time: x at 725 rad/s, between two critical speeds


@dataclass(frozen=True)
class Samples:
    """Points (n, 5) of the unit cube with outputs (n, q), one more, those held out, and many to predict."""

    u: np.ndarray
    y: np.ndarray
    more_u: np.ndarray  # (5,)
    more_y: np.ndarray  # (q,)
    held_out_u: np.ndarray
    held_out_y: np.ndarray
    many_u: np.ndarray

    def rmse(self, predicted: np.ndarray) -> float:
        """Of predictions (N_HELD_OUT, q)."""
        return float(np.sqrt(np.mean((predicted.reshape(self.held_out_y.shape) - self.held_out_y) ** 2)))


def write(path: Path, n: int, q: int) -> None:
    """The file of n samples of all outputs, or of one."""
    from scipy.stats import qmc

    from problems.three_disk import ThreeDisk

    problem = ThreeDisk().build()

    def outputs(u: np.ndarray) -> np.ndarray:
        all_outputs = np.log(np.abs(problem.response(problem.parameters.to_si(u)))).reshape(len(u), -1)
        return all_outputs[:, [ONE]] if q == 1 else all_outputs

    u = qmc.LatinHypercube(5, rng=np.random.default_rng(n)).random(n)
    more = np.random.default_rng(1).random((1, 5))
    held_out = qmc.LatinHypercube(5, rng=np.random.default_rng(99)).random(N_HELD_OUT)
    many = np.random.default_rng(2).random((N_MANY, 5))
    arrays = [u, outputs(u), more[0], outputs(more)[0], held_out, outputs(held_out), many]
    np.savez(path, **dict(zip(Samples.__dataclass_fields__, arrays, strict=True)))


def fit_by(fitted: Fitted, samples: str) -> Task:
    """A fit by a library whose models have `predict`, of all outputs; how good it is, at points held out."""
    data = read(samples)
    return Task(
        lambda turn: fitted(data.u, data.y),
        quality=lambda model: data.rmse(model.predict(data.held_out_u)),
        units=data.y.shape[1],
    )


def predict_by(fitted: Fitted, samples: str, points: int) -> Task:
    """So many predictions of all outputs by such a model."""
    data = read(samples)
    model, u = fitted(data.u, data.y), data.many_u[:points]
    return Task(lambda turn: model.predict(u), values=lambda found: found, units=points * data.y.shape[1])


def read(path: str) -> Samples:
    with np.load(path) as arrays:
        return Samples(**{name: arrays[name] for name in Samples.__dataclass_fields__})
