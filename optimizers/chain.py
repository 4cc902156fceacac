"""One optimiser after another: the second goes on around the best point of the first.

A global search and a local one after it are known as a memetic algorithm: P. Moscato, Caltech Concurrent Computation Program
Report 826 (1989). Here any optimiser can be either, as the second one is given a box around that point to search, not a start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ksmea.errors import BudgetSpent
from ksmea.numerics.objective import Minimum, Objective, SearchPart
from ksmea.plugins import registry
from ksmea.plugins.optimizer import Optimizer
from ksmea.settings.settings import Settings, setting


@dataclass(frozen=True)
class Chain(Optimizer):
    """Two optimisers, one after the other, each a stage of the trace.

    Without a budget each takes as much as it requests.
    """

    first: str = setting("de", "the optimiser that begins")
    then: str = setting("nelder_mead", "the optimiser that goes on around the best point of the first")
    first_settings: dict[str, Any] = setting({}, "settings of the first, by name")
    then_settings: dict[str, Any] = setting({}, "settings of the second, by name")
    share: float = setting(0.5, "part of the budget that the first may take", above=0.0, at_most=0.99)
    width: float = setting(
        0.1,
        "side of the box around that point that the second searches, in widths of the limits",
        above=0.0,
        at_most=1.0,
    )

    def check(self) -> None:
        """Raise `SettingError` if an optimiser does not exist, or lacks one of its settings."""
        _ = self._optimizers

    @cached_property
    def _optimizers(self) -> tuple[Optimizer, Optimizer]:
        first: Optimizer = registry.create("optimizer", self.first, self.first_settings)
        then: Optimizer = registry.create("optimizer", self.then, self.then_settings)
        return first, then

    @property
    def parts(self) -> Sequence[Settings]:
        """Both optimisers, and what they are made of."""
        return [part for each in self._optimizers for part in (each, *each.parts)]

    def check_dimension(self, dim: int) -> None:
        for each in self._optimizers:
            each.check_dimension(dim)

    def minimize(self, objective: Objective, rng: np.random.Generator) -> Minimum:
        """Search the whole cube, then the box around the best point."""
        first, then = self._optimizers
        budget = None if objective.left is None else int(np.ceil(self.share * objective.left))
        whole = SearchPart(objective, np.zeros(objective.dim), 1.0, budget)
        try:
            first.minimize(whole, rng)
        except BudgetSpent:
            if objective.was_refused or not whole.was_refused:
                raise
        finally:
            objective.end_stage(self.first)
        lower = np.clip(objective.result().u - self.width / 2, 0.0, 1.0 - self.width)
        try:
            then.minimize(SearchPart(objective, lower, self.width), rng)
        finally:
            objective.end_stage(f"then {self.then}")
        return objective.result()
