"""A run's budget of true-model evaluations: exact for any method, and the best point so far is what a spent one leaves."""

from dataclasses import dataclass

import numpy as np
import pytest

from budgeted import SETTINGS, record_of
from ksmea.errors import BudgetSpent
from ksmea.identification.direct import Direct
from ksmea.identification.ksmea import KSMEA
from ksmea.numerics.meter import Meter
from ksmea.plugins.identification import Method
from ksmea.plugins.optimizer import Optimizer
from ksmea.problem.counted import CountedProblem
from optimizers.de import DE
from optimizers.lm import LM
from optimizers.pso import PSO
from surrogates.kriging import Kriging
from surrogates.none import NoSurrogate


@dataclass(frozen=True)
class Swallowing(Optimizer):
    """Goes on after its budget is spent, and takes batches of 7."""

    def minimize(self, objective, rng):
        for _ in range(50):
            try:
                objective(rng.random((7, objective.dim)))
            except BudgetSpent:
                continue
        return objective.result()


@dataclass(frozen=True)
class Ignorant(Method):
    """Asks the problem itself, in batches of 7, and either dies of a spent budget, by its own error, or goes on without."""

    ending: str = "passes"

    def identify(self, problem, measurement, streams):
        for _ in range(50):
            try:
                problem.response(problem.parameters.to_si(streams.optimizer.random((7, len(problem.parameters)))))
            except BudgetSpent:
                if self.ending == "passes":
                    raise
                if self.ending == "dies":
                    raise RuntimeError("no more points") from None
        raise AssertionError("the budget was to end this")


METHODS = {
    "DE": Direct(optimizer=DE()),
    "PSO": Direct(optimizer=PSO()),
    "an optimiser that swallows the end": Direct(optimizer=Swallowing()),
    "Kriging, of more samples than the budget": KSMEA(surrogate=Kriging(), optimizer=DE(), samples=150),
    "no surrogate": KSMEA(surrogate=NoSurrogate(), optimizer=DE(), samples=10),
    "a method that knows no budget": Ignorant(),
    "a method that dies of it": Ignorant("dies"),
}


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_exactly_the_budget_is_spent(method):
    """103 is no multiple of any batch here: the last one is cut."""
    record = record_of(method, 103)
    assert record.model_evaluations == 103 and record.model_jacobians == 0
    assert record.status == record.stop == "budget"
    assert record.trace.evaluations[-1] <= 103


def test_a_surrogates_updating_steps_count():
    method = KSMEA(surrogate=Kriging(), optimizer=LM(screening=500), samples=40, smc=1, sdf=0)
    record = record_of(method, 45)
    assert record.model_evaluations == 45 and record.updates == 5 and record.stop == "budget"


@pytest.mark.parametrize("method", [*METHODS.values()][2:], ids=[*METHODS][2:])
def test_what_a_spent_budget_leaves_is_the_best_point_so_far(method):
    record = record_of(method, 103)
    assert record.x == pytest.approx(np.array(record.trace.x[-1]), rel=1e-9)  # a trace keeps ten digits


def test_jacobians_have_their_price():
    """Least squares asks for a Jacobian and a point at a time; what is left at the end does not pay for one more."""
    for price in (0, 2, 10):
        record = record_of(Direct(optimizer=LM(screening=100, starts=3)), 120, jacobian_cost=price)
        assert record.model_jacobians > 0
        spent = record.model_evaluations + price * record.model_jacobians
        assert 120 - max(price, 1) < spent <= 120 or (price == 0 and record.stop == "optimizer")


def test_the_optimiser_is_told_the_budget():
    """Least squares screens at most half of it; with the 8000 points of its default it would never begin."""
    record = record_of(Direct(optimizer=LM()), 400)
    assert record.model_jacobians > 0


def test_a_method_within_the_budget_ends_as_without():
    method = KSMEA(surrogate=Kriging(), optimizer=LM(screening=500), samples=40, max_updates=2)
    assert np.array_equal(record_of(method, 1000).x, record_of(method, None).x)


def test_the_smaller_of_two_budgets_holds():
    assert record_of(Direct(optimizer=DE(), budget=50), 103).model_evaluations == 50
    assert record_of(Direct(optimizer=DE(), budget=500), 103).model_evaluations == 103


def test_a_refused_batch_is_evaluated_as_far_as_the_budget_goes():
    counted = CountedProblem(SETTINGS.build())
    budget = Meter(5, jacobian_cost=2)
    problem = CountedProblem(counted, budget)
    x = np.tile(problem.parameters.to_si(np.full(5, 0.5)), (4, 1))
    problem.sensitivity(x[0])
    with pytest.raises(BudgetSpent):
        problem.at(problem.speed[:2], problem.channels).response(x)  # the same rotor elsewhere counts alike
    assert (counted.meter.evaluations, counted.meter.jacobians, budget.left) == (3, 1, 0)
    with pytest.raises(BudgetSpent):
        problem.linearised(x[0])
    assert budget.was_refused and counted.meter.jacobians == 1


def test_free_motions_have_their_price_too():
    problem = CountedProblem(SETTINGS.build(), Meter(3))
    x = problem.parameters.to_si(np.full(5, 0.5))
    problem.modes(x, 100.0)
    problem.is_stable(x)
    assert problem.changed(lambda bare: bare.with_phase_origin()).meter is problem.meter
    problem.changed(lambda bare: [bare.response(x[None]), bare][1])  # what changes it is within the budget
    assert problem.meter.left == 0
    with pytest.raises(BudgetSpent):
        problem.critical_speeds(x)


def test_predictions_of_a_method_that_dies_are_counted():
    @dataclass(frozen=True)
    class Dying(Method):
        surrogate: Kriging

        def identify(self, problem, measurement, streams):
            u = streams.design.random((30, 5))
            predictor = self.surrogate.fit(
                u, np.abs(problem.response(problem.parameters.to_si(u)))[:, :, 0], streams.surrogate
            )
            predictor.predict(streams.optimizer.random((500, 5)))
            problem.response(problem.parameters.to_si(u))

    assert record_of(Dying(Kriging()), 40).surrogate_evaluations == 500


def test_an_error_of_the_method_itself_passes():
    with pytest.raises(AssertionError, match="the budget was to end this"):
        record_of(Ignorant(), 10_000)
