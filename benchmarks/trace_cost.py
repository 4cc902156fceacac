"""What the trace costs: core time of a search with it, over that of the same search with evaluations counted alone.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.trace_cost

Three-disk rotor, amplitudes at two probes and 53 speeds: the cheapest model here, 6 µs a point in a batch and 60 µs alone. `single
points` does nothing but ask for one after the other, which is the dearest for the trace; `batches` asks for 1000 at once.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from ksmea.identification.direct import Direct
from ksmea.identification.trace import TracedProblem, thinned
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins.identification import Streams
from ksmea.plugins.optimizer import Optimizer
from ksmea.problem.counted import CountedProblem
from optimizers.de import DE
from optimizers.lm import LM
from problems.three_disk import ThreeDisk

TURNS = 25  # of both, in turn; the least time of each counts
NOISE = Noise(0.1, 0.0)


@dataclass(frozen=True)
class RandomPoints(Optimizer):
    """Random points, so many at once, so many times."""

    at_once: int = 1
    times: int = 2000

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        for _ in range(self.times):
            objective(rng.random((self.at_once, objective.dim)))
        return objective.result()


SEARCHES = {"DE": DE(), "LM": LM(), "single points": RandomPoints(), "batches": RandomPoints(1000, 20)}


def main() -> None:
    settings = ThreeDisk()
    problem, truth = settings.build(), settings.reference()
    x = np.array([truth[name] for name in problem.parameters.names])
    values = observe(problem.response(x[None])[0], "amplitude", NOISE, np.random.default_rng(0))
    measurement = Measurement(problem.speed, problem.channels, values, NOISE, "synthetic")
    for name, optimizer in SEARCHES.items():
        least = {False: np.inf, True: np.inf}
        for _ in range(TURNS):
            for is_traced in (False, True):
                streams = Streams(*(np.random.default_rng(part) for part in range(3)))
                traced = TracedProblem(problem, measurement)
                started = time.process_time()
                asked = traced if is_traced else CountedProblem(problem)
                found = Direct(optimizer).identify(asked, measurement, streams)
                trace = thinned(traced.improvements, found.stages)
                least[is_traced] = min(least[is_traced], time.process_time() - started)
                if is_traced:
                    kept = len(trace.misfit)
        print(
            f"{name}: {least[True] / least[False]:.3f} times, {found.model_evaluations} evaluations, {kept} improvements kept"
        )


if __name__ == "__main__":
    main()
