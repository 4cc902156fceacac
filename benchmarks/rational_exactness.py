"""How exactly the rational surrogate identifies the three-disk rotor without noise.

    OPENBLAS_NUM_THREADS=1 python benchmarks/rational_exactness.py [TRUTHS]

Each of 100 truths is drawn evenly between the search limits; amplitudes at 53 speeds in x and y at 0.1 m. 13 samples, least squares on
their surrogate, and no evaluation besides: the errors are those of the samples' surrogate alone.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from ksmea.identification import Streams
from ksmea.loop import KSMEA
from ksmea.measurement import Measurement, Noise, observe
from ksmea.model import CountedProblem
from optimizers.lm import LM
from problems.three_disk import ThreeDisk
from surrogates.rational import Rational

SEED = 7
SAMPLES = 13
NONE = Noise(0.0, 0.0)


def main(truths: int) -> None:
    problem = CountedProblem(ThreeDisk().build())
    method = KSMEA(Rational(), LM(), SAMPLES, misfit="likelihood", max_updates=0)
    errors, evaluations, started = [], set(), time.perf_counter()
    for truth in range(truths):
        drawn, design, surrogate, optimizer = np.random.default_rng([SEED, truth]).spawn(4)
        x = problem.parameters.to_si(drawn.random(len(problem.parameters)))
        values = observe(problem.response(x[None])[0], "amplitude", NONE, drawn)
        measurement = Measurement(problem.speed, problem.channels, values, NONE, "drawn")
        before = problem.count.evaluations
        found = method.identify(problem, measurement, Streams(design, surrogate, optimizer))
        evaluations.add(problem.count.evaluations - before)
        errors.append(np.abs(found.x / x - 1))
    print(
        f"{truths} truths, evaluations of the true model {sorted(evaluations)}, {time.perf_counter() - started:.0f} s"
    )
    for name, median, largest in zip(problem.parameters.names, np.median(errors, axis=0), np.max(errors, axis=0)):
        print(f"{name:4} relative error: median {median:.0e}, largest {largest:.0e}")
    print(f"all five within 1e-6: {np.sum(np.max(errors, axis=1) <= 1e-6)} of {truths}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
