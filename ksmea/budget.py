"""A budget of true-model evaluations that holds for any method, whether it knows of it or not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NoReturn

from ksmea.arrays import Array, ComplexArray
from ksmea.contracts import Problem
from ksmea.errors import BudgetSpent
from ksmea.load import Load
from ksmea.proxy import ProblemProxy

JACOBIAN_AS_EVALUATIONS = 2  # a response and an adjoint-like solution; it is recorded apart


@dataclass
class Budget:
    """Evaluations of the true model at most, a Jacobian counted as `jacobian_cost` of them; what is spent, and whether more was
    asked for."""

    evaluations: int
    jacobian_cost: int = 0
    spent: int = 0
    was_refused: bool = False

    @property
    def left(self) -> int:
        return self.evaluations - self.spent

    def refuse(self) -> NoReturn:
        self.was_refused = True
        raise BudgetSpent(f"the budget of {self.evaluations} evaluations of the true model is spent")


class BudgetedProblem(ProblemProxy):
    """A problem that answers within a budget. Of a batch that exceeds it, what is left is evaluated before `BudgetSpent` is
    raised, so that a method that goes on asking has seen exactly as much as the budget holds."""

    def __init__(self, behind: Problem, budget: Budget) -> None:
        self._behind = behind
        self.budget = budget

    @property
    def behind(self) -> Problem:
        return self._behind

    def around(self, behind: Problem) -> Problem:
        return BudgetedProblem(behind, self.budget)

    def response(self, x: Array) -> ComplexArray:
        return self._within(x, self._behind.response)

    def dense_response(self, x: Array) -> ComplexArray:
        return self._within(x, self._behind.dense_response)

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        return self._within(x, lambda points: self._behind.load_response(points, loads))

    def sensitivity(self, x: Array) -> ComplexArray:
        self._require_jacobian()
        sensitivity = self._behind.sensitivity(x)
        self.budget.spent += self.budget.jacobian_cost
        return sensitivity

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        self._require_jacobian()
        both = self._behind.linearised(x)
        self.budget.spent += self.budget.jacobian_cost
        return both

    def _within(self, x: Array, evaluate: Callable[[Array], ComplexArray]) -> ComplexArray:
        n_admitted = min(len(x), self.budget.left)
        if n_admitted or not len(x):
            response = evaluate(x[:n_admitted])
            self.budget.spent += n_admitted
        if n_admitted < len(x):
            self.budget.refuse()
        return response

    def _require_jacobian(self) -> None:
        if self.budget.jacobian_cost > self.budget.left:
            self.budget.refuse()
