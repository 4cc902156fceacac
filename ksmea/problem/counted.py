"""True model: every evaluation of it is counted, timed and kept within budgets here, never by plugins."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.numerics.differences import CUBE_STEP, differenced
from ksmea.numerics.meter import Meter
from ksmea.problem.forwarding import ProblemProxy
from ksmea.problem.load import Load
from ksmea.problem.problem import Problem
from ksmea.rotordynamics.whirl import Campbell, Mode

Seen = Callable[[Array, ComplexArray, int], None]


class CountedProblem(ProblemProxy):
    """A problem evaluated through a meter, at any speeds and channels and with any unbalance.

    An evaluation is of one set of unknowns; a sensitivity, alone or with the response at its point (`linearised`), is
    one Jacobian; free motions count apart. `seen` receives each response at the problem's own speeds and channels:
    points (k, d) SI, responses (k, n_speed, n_channel) and the count of the first evaluation.
    """

    def __init__(self, behind: Problem, meter: Meter | None = None, seen: Seen | None = None) -> None:
        self._behind = behind
        self.meter = Meter() if meter is None else meter
        self._seen = seen

    @property
    def behind(self) -> Problem:
        return self._behind

    def around(self, behind: Problem) -> Problem:
        return CountedProblem(behind, self.meter)

    def changed(self, change: Callable[[Problem], Problem]) -> Problem:
        def counted(problem: Problem) -> Problem:
            made = change(self.around(problem))
            return made.behind if isinstance(made, CountedProblem) else made

        return self.around(self._behind.changed(counted))

    def linearises_cheaply(self, loads: Sequence[Load] = ()) -> bool:
        """Evaluations are counted, so none is made before it is needed."""
        return False

    def response(self, x: Array) -> ComplexArray:
        return self.meter.ask(x, self._behind.response, self._seen)

    def dense_response(self, x: Array) -> ComplexArray:
        return self.meter.ask(x, self._behind.dense_response)

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        return self.meter.ask(x, lambda points: self._behind.load_response(points, loads))

    def sensitivity(self, x: Array) -> ComplexArray:
        return self.meter.ask_jacobian(lambda: self._behind.sensitivity(x))

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        response, sensitivity = self.meter.ask_jacobian(lambda: self._behind.linearised(x))
        if self._seen is not None:
            self._seen(x[None], response[None], self.meter.evaluations)
        return response, sensitivity

    def critical_speeds(self, x: Array, highest: float | None = None) -> Array:
        return self.meter.ask_other(lambda: self._behind.critical_speeds(x, highest))

    def modes(self, x: Array, speed: float, n_mode: int | None = None) -> tuple[Mode, ...]:
        return self.meter.ask_other(lambda: self._behind.modes(x, speed, n_mode))

    def campbell(self, x: Array, speed: Array, n_mode: int = 6) -> Campbell:
        return self.meter.ask_other(lambda: self._behind.campbell(x, speed, n_mode))

    def growth_rate(self, x: Array, speed: Array) -> Array:
        return self.meter.ask_other(lambda: self._behind.growth_rate(x, speed))

    def stability_threshold(self, x: Array, highest: float) -> float:
        return self.meter.ask_other(lambda: self._behind.stability_threshold(x, highest))

    def is_stable(self, x: Array) -> bool:
        return self.meter.ask_other(lambda: self._behind.is_stable(x))


class Model(Meter):
    """Problem over the unit cube with counts of points and sensitivities.

    They are `evaluations`, `jacobians` and `seconds`.

    Points that exceed `budget` are not evaluated: `BudgetSpent` is raised instead. A sensitivity takes `jacobian_cost`
    points of the budget; 0: it is counted, and costs nothing. If the problem has a budget of its own
    (`CountedProblem`), both hold, and a sensitivity costs no less than it does there.
    """

    def __init__(self, problem: Problem, budget: int | None = None, jacobian_cost: int = 0) -> None:
        of_run = problem.meter if isinstance(problem, CountedProblem) else Meter()
        super().__init__(budget, jacobian_cost if of_run.budget is None else max(jacobian_cost, of_run.jacobian_cost))
        self._of_run = of_run
        self.problem = problem

    @property
    def left(self) -> int | None:
        """Points that both budgets leave; None without any."""
        left = [each for each in (super().left, self._of_run.left) if each is not None]
        return min(left, default=None)

    @property
    def is_spent(self) -> bool:
        return self.left == 0

    def response(self, u: Array) -> ComplexArray:
        """(k, d) in the unit cube → complex response (k, n_speed, n_channel), m."""
        return self.response_of(self.problem, u)

    def response_of(self, problem: Problem, u: Array) -> ComplexArray:
        """Response of its problem, or of its problem at other speeds, which counts alike."""
        self.require(len(u))
        return self.ask(problem.parameters.to_si(u), problem.response)

    def linearise(self, u: Array) -> tuple[ComplexArray, ComplexArray]:
        """Response (n_speed, n_channel) at a point (d,) of the unit cube and its derivatives.

        These are (n_speed, n_channel, d).

        Together they count as one Jacobian; of a problem without a sensitivity they are central differences of 2 d + 1
        points, one batch.
        """
        if not self.problem.has_sensitivity:
            return differenced(self.response, u, CUBE_STEP, np.zeros(len(u)), np.ones(len(u)))
        parameters = self.problem.parameters
        response, sensitivity = self.ask_jacobian(lambda: self.problem.linearised(parameters.to_si(u)))
        return response, sensitivity * parameters.width
