"""True model over the unit cube: every evaluation is counted and timed here, never by plugins."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import BudgetSpent
from ksmea.numerics.differences import CUBE_STEP, differenced
from ksmea.problem.budget_and_journal import BudgetedProblem
from ksmea.problem.forwarding import ProblemProxy
from ksmea.problem.load import Load
from ksmea.problem.problem import Problem


class CountedProblem(ProblemProxy):
    """A problem that counts what it is asked, at whatever speeds and channels and with whatever unbalance: points, and
    sensitivities as Jacobians; one with the response at its point (`linearised`) is one Jacobian. Modes are not counted."""

    def __init__(self, behind: Problem, count: Count | None = None) -> None:
        self._behind = behind
        self.count = Count() if count is None else count

    @property
    def behind(self) -> Problem:
        return self._behind

    def around(self, behind: Problem) -> Problem:
        return CountedProblem(behind, self.count)

    def linearises_cheaply(self, loads: Sequence[Load] = ()) -> bool:
        """What is counted is not to be asked for before it is needed."""
        return False

    def response(self, x: Array) -> ComplexArray:
        with self.count.adds(evaluations=len(x)):
            return self._behind.response(x)

    def dense_response(self, x: Array) -> ComplexArray:
        with self.count.adds(evaluations=len(x)):
            return self._behind.dense_response(x)

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        with self.count.adds(evaluations=len(x)):
            return self._behind.load_response(x, loads)

    def sensitivity(self, x: Array) -> ComplexArray:
        with self.count.adds(jacobians=1):
            return self._behind.sensitivity(x)

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        with self.count.adds(jacobians=1):
            return self._behind.linearised(x)


@dataclass
class Count:
    """What was asked of a problem, and the time that it took."""

    evaluations: int = 0
    jacobians: int = 0
    seconds: float = 0.0

    @contextmanager
    def adds(self, evaluations: int = 0, jacobians: int = 0) -> Iterator[None]:
        """Count what is computed inside, once it is."""
        started = time.perf_counter()
        yield
        self.seconds += time.perf_counter() - started
        self.evaluations += evaluations
        self.jacobians += jacobians


class Model:
    """A problem over the unit cube, counting points (`evaluations`), sensitivities (`jacobians`) and `seconds`.

    `budget` is the number of points at most: what would exceed it raises `BudgetSpent` and is not evaluated. In it a
    sensitivity counts as `jacobian_cost` points; 0: it is counted, and costs nothing. Where the problem has a budget of its own
    (`ksmea.problem.budget_and_journal`), both hold, and a sensitivity costs no less than it does there.
    """

    def __init__(self, problem: Problem, budget: int | None = None, jacobian_cost: int = 0) -> None:
        self.problem = problem
        self.budget = budget
        self._of_run = problem.budget if isinstance(problem, BudgetedProblem) else None
        self.jacobian_cost = max(jacobian_cost, self._of_run.jacobian_cost if self._of_run else 0)
        self._counted = CountedProblem(problem)

    @property
    def evaluations(self) -> int:
        return self._counted.count.evaluations

    @property
    def jacobians(self) -> int:
        return self._counted.count.jacobians

    @property
    def seconds(self) -> float:
        return self._counted.count.seconds

    @property
    def left(self) -> int | None:
        """Points that both budgets leave; None without any."""
        left = [each for each in (self._own_left, self._of_run.left if self._of_run else None) if each is not None]
        return min(left, default=None)

    @property
    def is_spent(self) -> bool:
        return self.left is not None and self.left <= 0

    def response(self, u: Array) -> ComplexArray:
        """(k, d) in the unit cube → complex response (k, n_speed, n_channel), m."""
        self._require(len(u))
        return self._counted.response(self.problem.parameters.to_si(u))

    def linearise(self, u: Array) -> tuple[ComplexArray, ComplexArray]:
        """Response (n_speed, n_channel) at a point (d,) of the unit cube and its derivatives (n_speed, n_channel, d).

        Together they count as one Jacobian; of a problem without a sensitivity they are central differences of 2 d + 1
        points, one batch.
        """
        if not self.problem.has_sensitivity:
            return self._differences(u)
        self._require(self.jacobian_cost)
        parameters = self.problem.parameters
        response, sensitivity = self._counted.linearised(parameters.to_si(u))
        return response, sensitivity * parameters.width

    @property
    def _own_left(self) -> int | None:
        spent = self.evaluations + self.jacobian_cost * self.jacobians
        return None if self.budget is None else self.budget - spent

    def _require(self, n_point: int) -> None:
        """Raise `BudgetSpent` where the model's own budget leaves fewer points; the problem sees to the other."""
        if self._own_left is not None and n_point and n_point > self._own_left:
            raise BudgetSpent(f"the budget of {self.budget} evaluations of the true model is spent")

    def _differences(self, u: Array) -> tuple[ComplexArray, ComplexArray]:
        return differenced(self.response, u, CUBE_STEP, np.zeros(len(u)), np.ones(len(u)))
