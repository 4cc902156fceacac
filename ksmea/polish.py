"""The polish: what goes on from where the optimiser ended on a surrogate, as a part of the search of its own."""

from __future__ import annotations

from ksmea.descent import descend
from ksmea.objective import Objective

ITERATIONS = 50  # evaluations of the residuals at most; a smooth surrogate takes about ten


def polish(objective: Objective) -> None:
    """Bounded least squares from the best point so far; the objective remembers what is better."""
    descend(objective, objective.result().u, max_iterations=ITERATIONS)
