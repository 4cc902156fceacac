"""A box of an objective as an objective of its own: what one optimiser of several is given."""

from __future__ import annotations

from typing import NoReturn

from ksmea.arrays import Array
from ksmea.errors import BudgetSpent
from ksmea.objective import Objective


class SearchPart(Objective):
    """The points lower + width · v of an objective, for v in the unit cube (d,), with a budget of its own (None: what is left).

    The whole objective counts and remembers every point too.

    >>> import numpy as np
    >>> whole = Objective(1, lambda u: u - 0.5, budget=10)
    >>> part = SearchPart(whole, np.array([0.4]), 0.2, budget=2)
    >>> part(np.array([[0.0], [0.5]])).round(3), whole.result().u, whole.evaluations
    (array([0.01, 0.  ]), array([0.5]), 2)
    """

    def __init__(self, whole: Objective, lower: Array, width: float, budget: int | None = None) -> None:
        def inside(v: Array) -> Array:
            return lower + width * v

        super().__init__(
            whole.dim,
            lambda v: whole.all_residuals(inside(v)),
            jacobian_at=(lambda v: width * whole.jacobian(inside(v))) if whole.has_jacobian else None,
            screening_at=lambda v: whole.screening(inside(v)),
            budget=whole.left if budget is None else budget,
            jacobian_cost=whole.jacobian_cost,
        )
        self._whole = whole
        self._takes_all = budget is None

    def _refuse(self) -> NoReturn:
        self.was_refused = True
        self._whole.was_refused |= self._takes_all
        raise BudgetSpent(f"the budget of {self.budget} evaluations is spent")
