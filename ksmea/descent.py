"""Bounded least squares from one start: the local end of a search."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from ksmea.objective import Objective
from ksmea.parameters import Array

INSIDE = 1e-6  # a trust-region-reflective iteration must start off the bounds


def descend(objective: Objective, start: Array, *, max_iterations: int, tolerance: float = 1e-12) -> None:
    """Trust-region-reflective least squares in the unit cube from `start` (d,); the objective remembers the best point.

    `max_iterations` bounds the evaluations of the residuals; Jacobians are the objective's own.
    """
    least_squares(
        objective.residuals,
        np.clip(start, INSIDE, 1 - INSIDE),
        jac=objective.jacobian,
        bounds=(0.0, 1.0),
        method="trf",
        ftol=tolerance,
        xtol=tolerance,
        gtol=tolerance,
        max_nfev=max_iterations,
    )
