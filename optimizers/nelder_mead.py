"""Downhill simplex from random points, by scipy.

J. A. Nelder and R. Mead, A simplex method for function minimization, Comput. J. 7 (1965) 308–313,
doi 10.1093/comjnl/7.4.308; coefficients that depend on the dimension: F. Gao and L. Han, Comput. Optim. Appl. 51 (2012)
259–277, doi 10.1007/s10589-010-9329-3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, minimize

from ksmea.arrays import Array
from ksmea.numerics.isolation import finite
from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins.optimizer import Optimizer
from ksmea.settings.settings import setting


@dataclass(frozen=True)
class NelderMead(Optimizer):
    """Nelder and Mead's simplex, from another random simplex whenever it has shrunk to a point.

    Points outside the unit cube are moved to its nearest limit. It evaluates one point at a time.
    """

    evaluations: int = setting(10_100, "points of all starts; default: the number of de, pso and ga", at_least=1)
    adaptive: bool = setting(False, "coefficients that depend on the dimension", source="Gao & Han 2012")
    xatol: float = setting(1e-8, "size of the simplex that ends a start, in widths of the limits", above=0.0)
    fatol: float = setting(1e-10, "difference of misfits that ends a start where the simplex is small too", above=0.0)

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Start from simplices of random points until the evaluations are used up."""
        d = objective.dim

        def misfit(u: Array) -> float:
            return float(finite(objective(u[None]))[0])

        left = self.evaluations
        while left > 0:
            simplex = rng.random((d + 1, d))
            start = minimize(
                misfit,
                simplex[0],
                method="Nelder-Mead",
                bounds=Bounds(np.zeros(d), np.ones(d)),
                options={
                    "initial_simplex": simplex,
                    "adaptive": self.adaptive,
                    "xatol": self.xatol,
                    "fatol": self.fatol,
                    "maxfev": left,
                    "maxiter": left,
                },
            )
            left -= start.nfev
        return objective.result()
