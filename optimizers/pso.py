"""Particle swarm optimisation with one global best, by pyswarms.

J. Kennedy and R. Eberhart, Particle swarm optimization, Proc. IEEE ICNN (1995) 1942–1948,
doi 10.1109/ICNN.1995.488968; inertia by Y. Shi and R. Eberhart (1998), doi 10.1109/ICEC.1998.699146.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ksmea.numerics.isolation import finite, global_generators, logging_unconfigured
from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins.optimizer import Optimizer
from ksmea.settings.settings import setting

with logging_unconfigured():
    from pyswarms.single import GlobalBestPSO


@dataclass(frozen=True)
class PSO(Optimizer):
    """Global-best particle swarm; a particle that leaves the unit cube stops at its nearest limit.

    v ← w v + c₁ r₁ (own best − x) + c₂ r₂ (swarm's best − x); x ← x + v, with r₁, r₂ uniform in each coordinate.
    It evaluates population · (generations + 1) points, in one batch per generation.
    """

    inertia: float = setting(0.5, "w, the part of its velocity a particle keeps", source="Table 5", at_least=0.0)
    cognitive: float = setting(0.5, "c₁, attraction by the particle's own best point", source="Table 5", at_least=0.0)
    social: float = setting(
        2.0,
        "c₂, attraction by the swarm's best point; Table 5's 'cooperative factor' is read as this",
        source="Table 5",
        at_least=0.0,
    )
    population: int = setting(100, "particles", source="Table 5", at_least=1)
    generations: int = setting(
        100, "moves after the initial positions; assumed, the paper does not state their number", at_least=1
    )

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Move a Latin hypercube of particles."""
        start = scipy.stats.qmc.LatinHypercube(objective.dim, rng=rng).random(self.population)
        with global_generators(rng), logging_unconfigured():
            swarm = GlobalBestPSO(
                n_particles=self.population,
                dimensions=objective.dim,
                options={"w": self.inertia, "c1": self.cognitive, "c2": self.social},
                bounds=(np.zeros(objective.dim), np.ones(objective.dim)),
                bh_strategy="nearest",
                init_pos=start,
            )
            swarm.swarm.velocity = initial_velocity(start, rng)
            swarm.optimize(lambda points: finite(objective(points)), iters=self.generations + 1, verbose=False)
        return objective.result()


def initial_velocity(position: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Velocities (population, d) that lead each particle to a random point of the unit cube.

    M. Clerc, Standard particle swarm optimisation (2012), hal-00764996, § 3.2. pyswarms would draw them from U(0, 1),
    which drives the whole swarm to the upper limits at its first move.
    """
    return rng.random(position.shape) - position
