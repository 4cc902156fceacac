"""Contract of an optimiser: settings that minimise an objective over the unit cube.

A plugin is one file: a frozen dataclass whose fields are its settings, which subclasses a contract, and one entry point.
`ksmea.plugins.registry` rejects a class that does not. Members that are not abstract have a default, which their docstring states.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from ksmea.numerics.objective import Minimum, Objective
from ksmea.settings.settings import Settings


@dataclass(frozen=True)
class Optimizer(Settings):
    """Settings of an optimiser."""

    @abstractmethod
    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Minimise an objective over the unit cube.

        At its budget the objective raises `BudgetSpent`: let it pass.

        Args:
            objective: misfit of points (k, d) in the unit cube; it counts them and keeps the best one.
            rng: the only source of random numbers.

        Returns:
            The best point, as `objective.result()` gives it.

        >>> import ksmea
        >>> class Corners(Optimizer):
        ...     def minimize(self, objective, rng):
        ...         objective(np.indices((2,) * objective.dim).reshape(objective.dim, -1).T)
        ...         return objective.result()
        >>> best = Corners().minimize(ksmea.Objective(2, lambda u: u - 0.9), np.random.default_rng(0))
        >>> best.u.tolist(), round(best.value, 3), best.evaluations
        ([1.0, 1.0], 0.02, 4)
        """

    def check_dimension(self, dim: int) -> None:
        """Check that it suits a number of unknowns.

        Default: it suits any number.

        Args:
            dim: number of unknowns.

        Raises:
            SettingError: it does not suit this number.
        """
