"""A budget that a plugin spends behind the objective, by asking the problem or the misfit itself, is said in one sentence."""

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from budgeted import record_of
from ksmea.errors import BudgetSpent
from ksmea.identification.direct import Direct
from ksmea.identification.ksmea import KSMEA
from ksmea.plugins.identification import Method
from ksmea.plugins.optimizer import Optimizer
from ksmea.plugins.surrogate import Predictor, Surrogate
from optimizers.de import DE
from surrogates.kriging import Kriging
from surrogates.none import NoSurrogate


@dataclass(frozen=True)
class Several(Method):
    """Searches again and again, whatever the budget has left."""

    optimizer: Optimizer

    def identify(self, problem, measurement, streams):
        found = [Direct(self.optimizer).identify(problem, measurement, streams) for _ in range(3)]
        return min(found, key=lambda each: each.misfit)


def test_a_search_that_finds_the_budget_spent_ends_with_the_best_point_so_far():
    record = record_of(Several(DE()), 103)
    assert (record.model_evaluations, record.status, record.stop) == (103, "budget", "budget")
    assert record.x == pytest.approx(np.array(record.trace.x[-1]), rel=1e-9)


@dataclass(frozen=True)
class BehindTheObjective(Optimizer):
    """Asks for the residuals where the objective does not see it, and passes or swallows what comes then."""

    swallows: bool = False

    def minimize(self, objective, rng):
        for _ in range(30):
            try:
                objective._residuals_at(rng.random((7, objective.dim)))
            except BudgetSpent:
                if not self.swallows:
                    raise
        return objective.result()


@pytest.mark.parametrize("swallows", [False, True])
@pytest.mark.parametrize("budgets", [(35, None), (None, 35), (35, 35), (35, 40)])  # of the method, of the run
def test_an_optimiser_that_asks_behind_the_objective_ends_with_its_budget(budgets, swallows):
    own, of_run = budgets
    record = record_of(Direct(BehindTheObjective(swallows), budget=own), of_run)
    assert (record.model_evaluations, record.status) == (35, "budget")
    assert record.x == pytest.approx(np.array(record.trace.x[-1]), rel=1e-9)


@pytest.mark.parametrize("swallows", [False, True])
def test_under_a_surrogate_that_is_the_true_model_it_does_too(swallows):
    method = KSMEA(surrogate=NoSurrogate(), optimizer=BehindTheObjective(swallows), samples=14, budget=35)
    record = record_of(method, None)
    assert (record.model_evaluations, record.status) == (35, "budget")


class Asks(Predictor):
    def __init__(self, problem):
        self.problem = problem

    def predict(self, u):
        return np.abs(self.problem.response(self.problem.parameters.to_si(u))).reshape(len(u), -1)


@dataclass(frozen=True)
class AsksTheProblem(Surrogate):
    """Asks the problem at every prediction."""

    transform = "none"
    problem: Any = None

    def least_samples(self, d):
        return 1

    def fit(self, u, y, rng):
        return Asks(self.problem)


@dataclass(frozen=True)
class HandsItOn(Method):
    """Tells its surrogate of the problem."""

    inner: KSMEA

    def identify(self, problem, measurement, streams):
        inner = dataclasses.replace(self.inner, surrogate=AsksTheProblem(problem))
        return inner.identify(problem, measurement, streams)


def test_a_surrogate_that_asks_the_problem_ends_with_the_best_point_so_far():
    record = record_of(HandsItOn(KSMEA(surrogate=Kriging(), optimizer=DE(), samples=20)), 103)
    assert (record.model_evaluations, record.status) == (103, "budget")


@dataclass(frozen=True)
class LooksAtModes(Method):
    """Spends the budget on free motions alone."""

    def identify(self, problem, measurement, streams):
        for value in np.linspace(0.1, 0.9, 5):
            problem.modes(problem.parameters.to_si(np.full(5, value)), 100.0)
        raise AssertionError("the budget was to end this")


def test_where_nothing_was_compared_with_the_data_it_is_said_so():
    with pytest.raises(ArithmeticError, match="budget spent behind the objective: no point was compared"):
        record_of(LooksAtModes(), 3)


@dataclass(frozen=True)
class Leaks(Method):
    """Lets the end of a budget of its own pass."""

    def identify(self, problem, measurement, streams):
        problem.response(problem.parameters.to_si(streams.design.random((6, 5))))
        raise BudgetSpent("enough")


@pytest.mark.parametrize("budget", [None, 40])
def test_a_budget_of_the_methods_own_that_is_spent_is_no_error(budget):
    record = record_of(Leaks(), budget)
    assert (record.model_evaluations, record.status) == (6, "budget")
