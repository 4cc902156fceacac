"""Contract of an optimiser: settings that minimise an objective over the unit cube.

A plugin is one file: a frozen dataclass whose fields are its settings, which subclasses a contract, and one entry point.
`ksmea.plugins.registry` rejects a class that does not. Members that are not abstract have a default, which their docstring states.
"""
# Shorter than 40 lines: one contract a file.

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
        """Ask the objective for values and return `objective.result()`; let `BudgetSpent` pass."""

    def check_dimension(self, dim: int) -> None:
        """Raise `SettingError` if it does not suit `dim` unknowns. Default: it suits any number."""
