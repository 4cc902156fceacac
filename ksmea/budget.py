"""A budget of true-model evaluations that holds for any method, whether it knows of it or not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NoReturn, TypeVar

from ksmea.arrays import Array, ComplexArray
from ksmea.contracts import Problem
from ksmea.errors import BudgetSpent
from ksmea.load import Load
from ksmea.modes import Campbell, Mode
from ksmea.proxy import ProblemProxy

Found = TypeVar("Found")

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
    raised, so that a method that goes on asking has seen exactly as much as the budget holds. An evaluation is of one set of
    unknowns, at any speeds; free motions of one, such as its modes, count as one too."""

    def __init__(self, behind: Problem, budget: Budget) -> None:
        self._behind = behind
        self.budget = budget

    @property
    def behind(self) -> Problem:
        return self._behind

    def around(self, behind: Problem) -> Problem:
        return BudgetedProblem(behind, self.budget)

    def changed(self, change: Callable[[Problem], Problem]) -> Problem:
        def within(problem: Problem) -> Problem:
            made = change(BudgetedProblem(problem, self.budget))
            return made.behind if isinstance(made, BudgetedProblem) else made

        return self.around(self._behind.changed(within))

    def critical_speeds(self, x: Array, highest: float | None = None) -> Array:
        return self._as_one(lambda: self._behind.critical_speeds(x, highest))

    def modes(self, x: Array, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        return self._as_one(lambda: self._behind.modes(x, speed, n_mode))

    def campbell(self, x: Array, speed: Array, n_mode: int = 6) -> Campbell:
        return self._as_one(lambda: self._behind.campbell(x, speed, n_mode))

    def growth_rate(self, x: Array, speed: Array) -> Array:
        return self._as_one(lambda: self._behind.growth_rate(x, speed))

    def stability_threshold(self, x: Array, highest: float) -> float:
        return self._as_one(lambda: self._behind.stability_threshold(x, highest))

    def is_stable(self, x: Array) -> bool:
        return self._as_one(lambda: self._behind.is_stable(x))

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

    def _as_one(self, evaluate: Callable[[], Found]) -> Found:
        if not self.budget.left:
            self.budget.refuse()
        found = evaluate()
        self.budget.spent += 1
        return found

    def _require_jacobian(self) -> None:
        if self.budget.jacobian_cost > self.budget.left:
            self.budget.refuse()
