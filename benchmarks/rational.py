"""Accuracy of identifications by the rational surrogate of 13 samples.

The rotor is the three-disk rotor, without noise and with 10 %.

    OPENBLAS_NUM_THREADS=1 python benchmarks/rational.py exact [TRUTHS]
    OPENBLAS_NUM_THREADS=1 python benchmarks/rational.py noise [DRAWS]

53 speeds, x and y at 0.1 m. Least squares on the surrogate, and no evaluation beside the samples. `exact`: amplitudes of truths drawn evenly
between the search limits, and the errors of what is found. `noise`: draws at the values of the paper, amplitudes and complex data,
and the standard deviation of what is found in units of the Cramér–Rao bound.
"""

from __future__ import annotations

import sys

import numpy as np

from ksmea.arrays import Array
from ksmea.identification.ksmea import KSMEA
from ksmea.inference.cramer_rao import identifiability
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.plugins.identification import Streams
from ksmea.problem.counted import CountedProblem
from optimizers.lm import LM
from problems.three_disk import ThreeDisk
from surrogates.rational import Rational

SEED = 7
SAMPLES = 13
PROBLEM = ThreeDisk().build()
REFERENCE = np.array(list(ThreeDisk().reference().values()))


def identified(x: Array, observable: Observable, noise: Noise, optimizer: LM, rng: np.random.Generator) -> Array:
    """Identified values (d,) SI from data of x (d,) SI."""
    drawn, *streams = rng.spawn(4)
    values = observe(PROBLEM.response(x[None])[0], observable, noise, drawn)
    measurement = Measurement(PROBLEM.speed, PROBLEM.channels, values, noise, "drawn")
    counted = CountedProblem(PROBLEM)
    method = KSMEA(Rational(), optimizer, SAMPLES, misfit="likelihood", max_updates=0)
    found = method.identify(counted, measurement, Streams(*streams))
    assert (counted.meter.evaluations, counted.meter.jacobians) == (SAMPLES, 0)
    return found.x


def exact(n: int) -> None:
    errors = []
    for truth in range(n):
        rng = np.random.default_rng([SEED, truth])
        x = PROBLEM.parameters.to_si(rng.random(len(REFERENCE)))
        errors.append(np.abs(identified(x, Observable.AMPLITUDE, Noise(0.0, 0.0), LM(starts=30), rng) / x - 1))
    print(f"{n} truths, {SAMPLES} evaluations each")
    for name, median, largest in zip(PROBLEM.parameters.names, np.median(errors, axis=0), np.max(errors, axis=0)):
        print(f"{name:4} relative error: median {median:.0e}, largest {largest:.0e}")
    print(f"all five within 1e-6: {np.sum(np.max(errors, axis=1) <= 1e-6)} of {n}")


def noise(n: int) -> None:
    level, optimizer = Noise(0.1, 0.0), LM(screening=4000, starts=5)
    for observable in Observable:
        crlb = identifiability(PROBLEM, REFERENCE, level, observable, noise_known=True).crlb
        rngs = (np.random.default_rng([SEED, draw]) for draw in range(n))
        deviations = (
            np.array([identified(REFERENCE, observable, level, optimizer, rng) - REFERENCE for rng in rngs]) / crlb
        )
        quartiles = np.quantile(deviations, [0.25, 0.75], axis=0)
        robust = (quartiles[1] - quartiles[0]) / 1.349  # interquartile range of a normal distribution
        print(
            f"{n} draws of {observable}, {SAMPLES} evaluations each: standard deviation / CRLB (from the quartiles), bias / CRLB"
        )
        for name, *row in zip(PROBLEM.parameters.names, deviations.std(axis=0), robust, deviations.mean(axis=0)):
            print(f"{name:4} {row[0]:.2f} ({row[1]:.2f}) {row[2]:+.2f}", flush=True)


if __name__ == "__main__":
    run = {"exact": (exact, 100), "noise": (noise, 300)}[sys.argv[1]]
    run[0](int(sys.argv[2]) if len(sys.argv) > 2 else run[1])
