"""A search of a free objective by our optimisers: what their adapters and the count of points cost."""

from __future__ import annotations

import numpy as np

from benchmarks.harness.task import Task
from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins import registry

DIM = 5
CENTRE = 0.3


def search(optimizer: str, population: int, generations: int) -> Task:
    """One search of the sphere in five unknowns; a unit is a generation."""
    settings = {"population": population, "generations": generations}
    if optimizer == "cmaes":  # it counts evaluations, not generations
        settings = {"population": population, "evaluations": population * generations}
    chosen = registry.create("optimizer", optimizer, settings)

    def run(turn: int) -> Minimum:
        return chosen.minimize(Objective(DIM, lambda u: u - CENTRE), np.random.default_rng(turn))

    return Task(run, quality=lambda found: found.value, units=generations)
