"""Meter of a model: counts of evaluations and Jacobians, their time, and their budget.

A run evaluates its problem through a meter (`ksmea.problem.counted.CountedProblem`), a method has one of its own
(`ksmea.problem.counted.Model`) and an optimiser another (`ksmea.numerics.objective.Objective`). All count alike: an evaluation is one
point, at any speeds; a batch counts by its rows; a Jacobian is counted apart and has a price in evaluations.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NoReturn, TypeVar

from ksmea.arrays import Array
from ksmea.errors import BudgetSpent

Answer = TypeVar("Answer")

JACOBIAN_AS_EVALUATIONS = 2  # a response and an adjoint-like solution
SPENT_BEHIND = "budget spent behind the objective"  # by a plugin that evaluated points in another way


class Meter:
    """Counts of `evaluations`, `jacobians` and `others`, and the `seconds` of the first two.

    Others are free motions of a point, such as its modes.

    `budget` is the number of evaluations at most; None: no limit. In it a Jacobian counts as `jacobian_cost` evaluations, any of the
    others as one. A request beyond the budget raises `BudgetSpent`, and `was_refused` is true from then on.

    >>> import numpy as np
    >>> meter = Meter(budget=3, jacobian_cost=2)
    >>> meter.ask(np.array([[0.5]]), np.square), meter.evaluations, meter.left
    (array([[0.25]]), 1, 2)
    """

    def __init__(self, budget: int | None = None, jacobian_cost: int = 0) -> None:
        self.budget = budget
        self.jacobian_cost = jacobian_cost
        self.evaluations = 0
        self.jacobians = 0
        self.others = 0
        self.seconds = 0.0
        self.was_refused = False

    @property
    def spent(self) -> int:
        """Cost of the counts within a budget, in evaluations."""
        return self.evaluations + self.jacobian_cost * self.jacobians + self.others

    @property
    def left(self) -> int | None:
        """Evaluations that the budget leaves; None without one."""
        return None if self.budget is None else max(self.budget - self.spent, 0)

    def admitted(self, n: int) -> int:
        """How many of `n` evaluations the budget still holds."""
        return n if self.budget is None else min(n, max(self.budget - self.spent, 0))

    def require(self, n: int) -> None:
        """Raise `BudgetSpent` if the budget does not hold `n` more evaluations."""
        if self.admitted(n) < n:
            self.refuse()

    def refuse(self) -> NoReturn:
        self.was_refused = True
        raise BudgetSpent(f"the budget of {self.budget} evaluations is spent")

    def ask(
        self,
        points: Array,
        evaluate: Callable[[Array], Answer],
        seen: Callable[[Array, Answer, int], None] | None = None,
    ) -> Answer:
        """Evaluate points (k, d) → (k, …).

        A batch that exceeds the budget is cut: the part within it is evaluated before `BudgetSpent` is raised, so that
        the budget is spent exactly. An evaluation that raises does not count.

        `seen` receives each part that was evaluated: points, values and the count of the first of them.
        """
        n = self.admitted(len(points))
        if n or not len(points):
            started = time.perf_counter()
            values = evaluate(points[:n])
            self.seconds += time.perf_counter() - started
            self.evaluations += n
            if seen is not None:
                seen(points[:n], values, self.evaluations - n + 1)
        if n < len(points):
            self.refuse()
        return values

    def ask_jacobian(self, evaluate: Callable[[], Answer]) -> Answer:
        """A Jacobian, alone or with the value at its point."""
        self.require(self.jacobian_cost)
        started = time.perf_counter()
        answer = evaluate()
        self.seconds += time.perf_counter() - started
        self.jacobians += 1
        return answer

    def ask_other(self, evaluate: Callable[[], Answer]) -> Answer:
        """Anything else at a point."""
        self.require(1)
        answer = evaluate()
        self.others += 1
        return answer
