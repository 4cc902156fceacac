"""Measured data that all sides identify from: amplitudes of the three-disk rotor with 10 % noise, of another seed in each turn. They
are made once by this project and handed over as a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

N_SEED = 32
NOISE = 0.1  # of each value, 1 σ


@dataclass(frozen=True)
class RunUps:
    """Amplitudes (N_SEED, n_speed, 2) m, the true values (5,) SI and their Cramér–Rao lower bounds (5,), 1 σ."""

    values: np.ndarray
    truth: np.ndarray
    crlb: np.ndarray

    def of(self, turn: int) -> np.ndarray:
        return self.values[turn % N_SEED]

    def error(self, x: np.ndarray) -> float:
        """Root mean square over the unknowns of the errors in units of their bounds: 1 is what an efficient method has."""
        return float(np.sqrt(np.mean(((x - self.truth) / self.crlb) ** 2)))


def write(path: Path) -> None:
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
    np.savez(path, values=np.array(values), truth=TRUTH, crlb=crlb)


def read(path: str) -> RunUps:
    with np.load(path) as arrays:
        return RunUps(**{name: arrays[name] for name in RunUps.__dataclass_fields__})
