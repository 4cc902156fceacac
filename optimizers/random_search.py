"""Uniform random points: what every optimiser has to beat.

S. H. Brooks, A discussion of random methods for seeking maxima, Oper. Res. 6 (1958) 244–251, doi 10.1287/opre.6.2.244.
"""
# Shorter than 40 lines: one plugin a file.

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins.optimizer import Optimizer
from ksmea.settings.settings import setting


@dataclass(frozen=True)
class RandomSearch(Optimizer):
    """Points drawn uniformly from the unit cube."""

    evaluations: int = setting(10_100, "points drawn; default: the number of de, pso and ga", at_least=1)
    batch: int = setting(1000, "points evaluated at once; limits the memory needed", at_least=1)

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Draw and evaluate, batch by batch."""
        for first in range(0, self.evaluations, self.batch):
            objective(rng.random((min(self.batch, self.evaluations - first), objective.dim)))
        return objective.result()
