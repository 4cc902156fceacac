"""Bounded least squares from one start.

The local end of a search, also from the optimum of a surrogate (polish).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from ksmea.arrays import Array
from ksmea.numerics.objective import Objective


def descend(
    objective: Objective,
    start: Array,
    *,
    max_iterations: int,
    margin: float = 1e-6,
    xtol: float = 1e-12,
    ftol: float = 1e-12,
    gtol: float = 1e-12,
) -> None:
    """Trust-region-reflective least squares in the unit cube from `start` (d,).

    The objective remembers the best point.

    `max_iterations` limits the evaluations of the residuals, Jacobians are the objective's own. The start is moved
    `margin` inside the limits, which the iteration must not start on. A derivative that cannot be computed counts
    as zero, so that one bad direction does not end the others.

    M. A. Branch, T. F. Coleman and Y. Li, A subspace, interior, and conjugate gradient method for large-scale
    bound-constrained minimization problems, SIAM J. Sci. Comput. 21 (1999) 1–23, doi 10.1137/S1064827595289108.
    """

    def jacobian(u: Array) -> Array:
        return np.nan_to_num(objective.jacobian(u), nan=0.0, posinf=0.0, neginf=0.0)

    least_squares(
        objective.residuals,
        np.clip(start, margin, 1 - margin),
        jac=jacobian,
        bounds=(0.0, 1.0),
        method="trf",
        xtol=xtol,
        ftol=ftol,
        gtol=gtol,
        max_nfev=max_iterations,
    )


ITERATIONS = 50  # evaluations of the residuals at most; a smooth surrogate takes about ten


def polish(objective: Objective) -> None:
    """Bounded least squares from the best point so far; the objective remembers what is better."""
    descend(objective, objective.result().u, max_iterations=ITERATIONS)
