"""Evolution strategy with covariance matrix adaptation and restarts, by cma.

N. Hansen and A. Ostermeier, Completely derandomized self-adaptation in evolution strategies, Evol. Comput. 9 (2001)
159–195, doi 10.1162/106365601750190398; restarts with growing populations (IPOP): A. Auger and N. Hansen, IEEE CEC (2005)
1769–1776, doi 10.1109/CEC.2005.1554902; with large and small ones in turn (BIPOP): N. Hansen, GECCO (2009) 2389–2396,
doi 10.1145/1570256.1570333.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.numerics.isolation import finite, global_generators
from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins.optimizer import Optimizer
from ksmea.settings.settings import setting

if importlib.util.find_spec("cma") is None:
    raise SettingError("expected the package cma, which is not installed; pip install 'ksmea-bench[methods]'")

RESTARTS = ("bipop", "ipop", "none")
SILENT = {"verbose": -9, "verb_log": 0, "verb_disp": 0, "signals_filename": ""}


@dataclass(frozen=True)
class CMAES(Optimizer):
    """CMA-ES from random points, started again with other populations whenever it has converged.

    Coordinates are bounded by cma's own transformation. It evaluates one batch per generation, and the mean of the
    population at the end of each start.
    """

    evaluations: int = setting(
        10_100, "points after which no generation begins; default: the number of de, pso and ga", at_least=1
    )
    step: float = setting(
        0.25, "initial standard deviation of each coordinate, in widths of the limits", above=0.0, at_most=1.0
    )
    population: int | None = setting(None, "points of a generation of the first start; null: 4 + 3 ln d", at_least=4)
    restarts: str = setting(
        "bipop",
        "populations after the first start: large and small in turn, each twice as large as the last, or no further start",
        source="Hansen 2009; Auger & Hansen 2005",
        choices=RESTARTS,
    )
    max_restarts: int = setting(9, "starts after the first, small populations not counted", at_least=0)

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Start at random points until the evaluations or the restarts are used up."""
        import cma  # takes a second to import, which other runs need not wait for

        def misfits(points: Sequence[Array]) -> list[float]:
            return finite(objective(np.array(points))).tolist()

        options = {"bounds": [0.0, 1.0], "maxfevals": self.evaluations, "seed": np.nan, **SILENT}
        if self.population is not None:
            options["popsize"] = self.population
        with global_generators(rng):  # with seed=nan cma draws from numpy's global generator as it finds it
            cma.fmin2(
                None,
                lambda: rng.random(objective.dim),
                self.step,
                options,
                parallel_objective=misfits,
                restarts=0 if self.restarts == "none" else self.max_restarts,
                bipop=self.restarts == "bipop",
            )
        return objective.result()
