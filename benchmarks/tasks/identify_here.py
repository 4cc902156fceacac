"""Identifications by this project, each turn from data of another seed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.harness.task import Task
from benchmarks.tasks.data import NOISE, read_run_ups
from ksmea.identification.direct import Direct
from ksmea.identification.trace import TracedProblem, thinned
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins import registry
from ksmea.plugins.identification import Streams
from ksmea.plugins.optimizer import Optimizer
from ksmea.problem.case import Case
from ksmea.problem.counted import CountedProblem
from ksmea.studies.identify import identification
from optimizers.de import DE
from optimizers.lm import LM
from problems.three_disk import ThreeDisk


def method(
    run_ups: str, method: str, settings: dict[str, Any], optimizer: str, surrogate: str = "none", samples: int = 100
) -> Task:
    """A method alone, without intervals."""
    problem, data = ThreeDisk().build(), read_run_ups(run_ups)
    chosen = _method(method, settings, optimizer, surrogate, samples)

    def run(turn: int) -> np.ndarray:
        found = chosen.identify(CountedProblem(problem), _measurement(problem, data.of(turn)), _streams(turn))
        return found.x

    return Task(run, quality=data.error)


def run_of_table3(run_ups: str, samples: int) -> Task:
    """A whole run of Table 3: Kriging, DE, updates, final step, intervals and Cramér–Rao lower bounds."""
    problem, data = ThreeDisk().build(), read_run_ups(run_ups)
    chosen = _method("ksmea", {}, "de", "kriging", samples)

    def run(turn: int) -> np.ndarray:
        record = identification(Case(problem, _measurement(problem, data.of(turn))), chosen, _streams(turn))
        return np.asarray(record.values)

    return Task(run, quality=data.error)


def noiseless(surrogate: str, samples: int) -> Task:
    """Least squares on a surrogate of so many samples, from data without noise."""
    problem = ThreeDisk().build()
    truth = np.array(list(ThreeDisk().reference().values()))
    values = observe(problem.response(truth[None])[0], Observable.AMPLITUDE, Noise(0.0, 0.0), np.random.default_rng(0))
    measurement = Measurement(problem.speed, problem.channels, values, Noise(0.0, 0.0), "exact")
    chosen = _method("ksmea", {"max_updates": 0, "misfit": "likelihood"}, "lm", surrogate, samples)
    return Task(
        lambda turn: chosen.identify(CountedProblem(problem), measurement, _streams(turn)).x,
        quality=lambda x: float(np.max(np.abs(x / truth - 1))),
    )


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


def traced(run_ups: str, search: str, is_traced: bool) -> Task:
    """A search of the model itself with its trace, or with evaluations counted alone."""
    problem, data = ThreeDisk().build(), read_run_ups(run_ups)
    measurement, chosen = _measurement(problem, data.of(0)), Direct(SEARCHES[search])

    def run(turn: int) -> np.ndarray:
        traced = TracedProblem(problem, measurement)
        found = chosen.identify(traced if is_traced else CountedProblem(problem), measurement, _streams(turn))
        thinned(traced.improvements, found.stages)
        return found.x

    return Task(run)


def _method(name: str, settings: dict[str, Any], optimizer: str, surrogate: str, samples: int) -> Any:
    parts = {
        "surrogate": registry.create("surrogate", surrogate, {}),
        "optimizer": registry.create("optimizer", optimizer, {}),
        "samples": samples,
    }
    return registry.create("method", name, settings, parts)


def _measurement(problem: Any, values: np.ndarray) -> Measurement:
    return Measurement(problem.speed, problem.channels, values, Noise(NOISE, 0.0), "synthetic")


def _streams(turn: int) -> Streams:
    return Streams(*(np.random.default_rng([turn, part]) for part in range(3)))
