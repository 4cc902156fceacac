"""Nonlinear least squares from the best points of a screening, by scipy.

The peaks of a lightly damped rotor give the misfit many minima: least squares from random starts finds the right one
in few percent of them. Thousands of batched evaluations of a robust misfit first, and least squares from the best of
these points, find it.

M. A. Branch, T. F. Coleman and Y. Li, A subspace, interior, and conjugate gradient method for large-scale
bound-constrained minimization problems, SIAM J. Sci. Comput. 21 (1999) 1–23, doi 10.1137/S1064827595289108;
Levenberg and Marquardt's step in a trust region: J. J. Moré, Lect. Notes Math. 630 (1978) 105–116,
doi 10.1007/BFb0067700. Screening: `ksmea.numerics.screening`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.numerics.least_squares import descend
from ksmea.numerics.objective import Minimum, Objective
from ksmea.numerics.screening import Screened, ranked, sobol
from ksmea.plugins.optimizer import Optimizer
from ksmea.settings.settings import setting


@dataclass(frozen=True)
class LM(Optimizer):
    """Bounded least squares (trust region reflective) from distant best points of a screening.

    It evaluates `screening` points, the misfit at the starts, and at most `max_iterations` points from each start
    in addition to Jacobians. Of a budget at most half is screened, so that the best of it is sure to be evaluated.
    """

    screening: int = setting(8000, "points of the screening, a scrambled Sobol' sequence", at_least=0)
    starts: int = setting(15, "screened points from which least squares starts, at most", at_least=1)
    min_distance: float = setting(
        0.1, "least distance of two starts in the unit cube; fewer points as far apart: fewer starts", at_least=0.0
    )
    margin: float = setting(
        1e-3, "starts are moved this far inside the limits, from where the method barely leaves", above=0.0, at_most=0.5
    )
    max_iterations: int = setting(100, "evaluations of the residuals in one start, Jacobians apart", at_least=1)
    xtol: float = setting(1e-10, "relative change of the parameters that ends a start", above=0.0)
    ftol: float = setting(1e-12, "relative change of the misfit that ends a start", above=0.0)
    gtol: float = setting(1e-12, "norm of the scaled gradient that ends a start", above=0.0)
    batch: int = setting(1000, "points screened at once; limits the memory needed", at_least=1)

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Screen, choose starts and run least squares from each, the best first."""
        chosen = self._screened(objective, rng).apart(self.starts, self.min_distance)
        starts = np.clip(chosen.points, self.margin, 1.0 - self.margin)
        for start in starts[np.isfinite(objective(starts))]:
            descend(
                objective,
                start,
                max_iterations=self.max_iterations,
                margin=self.margin,
                xtol=self.xtol,
                ftol=self.ftol,
                gtol=self.gtol,
            )
        return objective.result()

    def _screened(self, objective: Objective, rng: np.random.Generator) -> Screened:
        n = self.screening
        if objective.budget is not None:
            n = min(n, max(objective.budget - objective.evaluations, 0) // 2)
        points = sobol(max(n, self.starts), objective.dim, rng)
        if n == 0:
            return Screened(points, np.zeros(len(points)))
        points = points[:n]
        batches = np.split(points, range(self.batch, n, self.batch))
        return ranked(points, np.concatenate([objective.screening(batch) for batch in batches]))
