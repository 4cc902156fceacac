"""Generalised simulated annealing with local searches, by scipy.

C. Tsallis and D. A. Stariolo, Generalized simulated annealing, Physica A 233 (1996) 395–406,
doi 10.1016/S0378-4371(96)00271-3; Y. Xiang, D. Y. Sun, W. Fan and X. G. Gong, Generalized simulated annealing algorithm
and its application to the Thomson model, Phys. Lett. A 233 (1997) 216–220, doi 10.1016/S0375-9601(97)00474-X.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, dual_annealing

from ksmea.arrays import Array
from ksmea.numerics.isolation import finite
from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins.optimizer import Optimizer
from ksmea.settings.settings import setting


@dataclass(frozen=True)
class DualAnnealing(Optimizer):
    """Simulated annealing with heavy-tailed steps, and L-BFGS-B from each better point.

    L-BFGS-B uses difference quotients.

    It evaluates one point at a time.
    """

    evaluations: int = setting(
        10_100,
        "points after which neither a step nor a local search begins; default: the number of de, pso and ga",
        at_least=1,
    )
    initial_temp: float = setting(5230.0, "temperature at the beginning", source="scipy", above=0.01, at_most=5e4)
    restart_temp_ratio: float = setting(
        2e-5, "part of it at which the annealing begins anew", source="scipy", above=0.0, at_most=0.99
    )
    visit: float = setting(
        2.62,
        "q of the distribution of steps: larger, heavier tails",
        source="Xiang et al. 1997",
        above=1.0,
        at_most=3.0,
    )
    local_search: bool = setting(True, "search locally from better points; false: the classical annealing alone")

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Anneal from a random point."""

        def misfit(u: Array) -> float:
            return float(finite(objective(u[None]))[0])

        dual_annealing(
            misfit,
            Bounds(np.zeros(objective.dim), np.ones(objective.dim)),
            maxiter=self.evaluations,  # each iteration takes more than one: the evaluations end it
            maxfun=self.evaluations,
            initial_temp=self.initial_temp,
            restart_temp_ratio=self.restart_temp_ratio,
            visit=self.visit,
            no_local_search=not self.local_search,
            rng=rng,
        )
        return objective.result()
