"""Files that all sides of a row are handed, made once by this project and removed with the process.

- Samples for surrogates: ln amplitude of the three-disk rotor at 53 speeds in x and y, (n, 106), over ten Latin hypercubes of its
  unknowns, or one of these outputs.
- Run-ups to identify from: its amplitudes with 10 % noise, of another seed in each turn.
"""

from __future__ import annotations

import atexit
import shutil
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

N_HELD_OUT, N_MANY = 1000, 10_000
N_DESIGN = 10
FAILED = 0.9  # a fit whose error is above this part of a mean's
ONE = 42  # the output of those who fit one at a time: x at 725 rad/s, between two critical speeds
N_SEED = 32
NOISE = 0.1  # of each value, 1 σ


@dataclass(frozen=True)
class Samples:
    """Designs of n points (N_DESIGN, n, 5) of the unit cube with outputs (N_DESIGN, n, q).

    All share the other points: one more sample, those held out, and many to predict.
    """

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

    @property
    def failed_above(self) -> float:
        """RMSE above which a fit predicts hardly better than the mean of the held-out outputs."""
        return FAILED * self.rmse(np.broadcast_to(self.held_out_y.mean(axis=0), self.held_out_y.shape))


@dataclass(frozen=True)
class RunUps:
    """Amplitudes (N_SEED, n_speed, 2) m, true values (5,) SI and Cramér–Rao lower bounds (5,), 1 σ."""

    values: np.ndarray
    truth: np.ndarray
    crlb: np.ndarray

    def of(self, turn: int) -> np.ndarray:
        return self.values[turn % N_SEED]

    def error(self, x: np.ndarray) -> float:
        """Root mean square over the unknowns of the errors in units of their bounds.

        1 is what an efficient method has.
        """
        return float(np.sqrt(np.mean(((x - self.truth) / self.crlb) ** 2)))


def read_samples(path: str) -> Samples:
    return Samples(**np.load(path))


def read_run_ups(path: str) -> RunUps:
    return RunUps(**np.load(path))


@cache
def samples(n: int, q: int = 106) -> str:
    """The file of designs of n samples, with all outputs or with one."""
    from scipy.stats import qmc

    from problems.three_disk import ThreeDisk

    problem = ThreeDisk().build()

    def outputs(u: np.ndarray) -> np.ndarray:
        all_outputs = np.log(np.abs(problem.response(problem.parameters.to_si(u)))).reshape(len(u), -1)
        return all_outputs[:, [ONE]] if q == 1 else all_outputs

    u = [qmc.LatinHypercube(5, rng=np.random.default_rng((n, design))).random(n) for design in range(N_DESIGN)]
    more = np.random.default_rng(1).random((1, 5))
    held_out = qmc.LatinHypercube(5, rng=np.random.default_rng(99)).random(N_HELD_OUT)
    many = np.random.default_rng(2).random((N_MANY, 5))
    return _file(
        f"samples_{n}_{q}.npz",
        Samples(
            np.array(u),
            np.array([outputs(each) for each in u]),
            more[0],
            outputs(more)[0],
            held_out,
            outputs(held_out),
            many,
        ),
    )


@cache
def run_ups() -> str:
    """The file of measured data."""
    from benchmarks.tasks.three_disk import TRUTH
    from ksmea.inference.cramer_rao import identifiability
    from ksmea.measurement.measurement import observe
    from ksmea.measurement.noise import Noise
    from ksmea.measurement.observable import Observable
    from problems.three_disk import ThreeDisk

    problem, noise = ThreeDisk().build(), Noise(NOISE, 0.0)
    response = problem.response(TRUTH[None])[0]
    values = [observe(response, Observable.AMPLITUDE, noise, np.random.default_rng(seed)) for seed in range(N_SEED)]
    crlb = identifiability(problem, TRUTH, noise, Observable.AMPLITUDE).crlb
    return _file("run_ups.npz", RunUps(np.array(values), TRUTH, crlb))


def _file(name: str, content: Samples | RunUps) -> str:
    np.savez(_folder() / name, **vars(content))
    return str(_folder() / name)


@cache
def _folder() -> Path:
    folder = tempfile.mkdtemp(prefix="ksmea-benchmarks-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)
