"""The optimiser on the true model: least squares on the three-disk rotor, counted and within its budget."""

import numpy as np
import pytest
from scipy.stats import spearmanr

from ksmea.errors import BudgetSpent, SettingError
from ksmea.identification.direct import Direct
from ksmea.identification.true_model import model_objective
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.numerics.least_squares import descend
from ksmea.numerics.screening import sobol
from ksmea.plugins.identification import Streams
from ksmea.problem.case import Case
from ksmea.problem.counted import Model
from ksmea.problem.problem import Problem
from optimizers.de import DE
from optimizers.ga import GA
from optimizers.lm import LM
from optimizers.pso import PSO
from problems.three_disk import ThreeDisk

TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
NOISE = Noise(0.1, 0.0)


@pytest.fixture(scope="module")
def rotor():
    return ThreeDisk().build()  # k anywhere from 10 to 100 MN/m


class Counted(Problem):
    """A problem that counts what it is asked, without a sensitivity unless it is to have one."""

    has_sensitivity = True

    def __init__(self, problem, with_sensitivity=True):
        self._problem = problem
        self.parameters, self.speed, self.channels = problem.parameters, problem.speed, problem.channels
        self.points = self.sensitivities = 0
        self.has_sensitivity = with_sensitivity

    def response(self, x):
        self.points += len(x)
        return self._problem.response(x)

    def sensitivity(self, x):
        self.sensitivities += 1
        return self._problem.sensitivity(x)

    @property
    def evaluations(self):
        """Points besides those that a Jacobian takes the response at: those count as part of it."""
        return self.points - self.sensitivities


def measured(problem, seed, kind="amplitude"):
    values = observe(problem.response(TRUTH[None])[0], kind, NOISE, np.random.default_rng(seed))
    return Measurement(problem.speed, problem.channels, values, NOISE, "test")


def identified(optimizer, problem, measurement, seed=0, **settings):
    streams = Streams(*(np.random.default_rng([seed, part]) for part in range(3)))
    return Direct(optimizer, **settings).identify(problem, measurement, streams)


def misfit_from_the_truth(problem, measurement):
    """Misfit of least squares from the true values, which no method knows."""
    misfit = Misfit(measurement, "likelihood")
    objective = model_objective(Model(problem), misfit)
    descend(objective, problem.parameters.to_cube(TRUTH), max_iterations=200)
    return objective.result().value - misfit.offset


def test_many_speeds_are_screened_at_200_of_them():
    """Means over 200 of 800 speeds rank points as those over all do; each counts as one evaluation."""
    problem = ThreeDisk(n_speed=800).build()
    model, misfit = Model(problem), Misfit(measured(problem, 0), "log")
    points = sobol(256, len(problem.parameters))
    found = model_objective(model, misfit).screening(points)
    assert model.evaluations == 256
    every = misfit.screening(misfit.observed(problem.response(problem.parameters.to_si(points))))
    assert spearmanr(found, every).statistic > 0.999
    few = Case(problem, misfit.measurement).for_screening()
    assert len(few.measurement.speed) == 200 and few.measurement.speed[[0, -1]] == pytest.approx(problem.speed[[0, -1]])
    assert few.for_screening() is few


@pytest.mark.parametrize("seed", range(4))
def test_least_squares_finds_the_global_minimum_from_honest_starts(rotor, seed):
    measurement = measured(rotor, seed)
    found = identified(LM(), rotor, measurement, seed)
    # both descents end where the misfit changes by less than 1e-12 of the sum of squares, which is about 1e4
    assert found.misfit <= misfit_from_the_truth(rotor, measurement) + 1e-6
    assert found.stop == "optimizer" and not found.was_cut_short
    # five times the CRLB for 10 % amplitude noise and 53 speeds: 0.11, 0.11, 8.6, 21.5 and 0.99 %
    assert np.all(np.abs(found.x / TRUTH - 1) < 5 * np.array([0.0011, 0.0011, 0.086, 0.215, 0.0099]))


def test_the_misfit_it_tells_is_that_of_the_values_it_returns(rotor):
    for kind in ("amplitude", "complex"):
        measurement = measured(rotor, 0, kind)
        found = identified(DE(generations=5), rotor, measurement)
        misfit = Misfit(measurement, "likelihood")
        assert found.misfit == pytest.approx(
            misfit.value(misfit.observed(rotor.response(found.x[None])))[0],
            rel=1e-6,  # to SI and back at a peak
        )


@pytest.mark.parametrize("form", ["plain", "weighted", "log"])
def test_other_forms_of_the_misfit_are_minimised_too(rotor, form):
    measurement = measured(rotor, 0)
    found = identified(LM(screening=4000), rotor, measurement, misfit=form)
    at_truth = Misfit(measurement, form).value(np.abs(rotor.response(TRUTH[None])))[0]
    assert found.misfit < at_truth


@pytest.mark.parametrize("budget", [1, 150, 401])
@pytest.mark.parametrize("optimizer", [DE(), PSO(), GA(), LM()], ids=lambda optimizer: type(optimizer).__name__)
def test_the_budget_is_used_exactly(rotor, optimizer, budget):
    problem = Counted(rotor)
    found = identified(optimizer, problem, measured(rotor, 0), budget=budget)
    assert found.stop == "budget" and found.was_cut_short
    assert problem.evaluations == found.model_evaluations == budget
    assert np.isfinite(found.misfit)


@pytest.mark.parametrize("cost", [0, 1, 7])
def test_jacobians_count_in_the_budget_at_their_price(rotor, cost):
    found = identified(LM(), rotor, measured(rotor, 0), budget=420, jacobian_cost=cost)
    spent = found.model_evaluations + cost * found.model_jacobians
    assert found.model_jacobians > 0 and spent <= 420
    if cost == 7:
        assert found.stop == "budget" and spent > 420 - 7
    if cost == 0:
        plain = identified(LM(), rotor, measured(rotor, 0), budget=420)
        assert np.array_equal(found.x, plain.x) and found.model_evaluations == plain.model_evaluations


def test_a_model_refuses_a_jacobian_that_its_budget_does_not_pay(rotor):
    model = Model(rotor, budget=10, jacobian_cost=4)
    u = np.full(5, 0.5)
    for left in (6, 2):
        model.linearise(u)
        assert model.left == left
    with pytest.raises(BudgetSpent):
        model.linearise(u)
    assert (model.jacobians, model.evaluations) == (2, 0)


def test_an_optimizer_that_ends_at_its_budget_was_not_cut_short(rotor):
    found = identified(DE(population=20, generations=2), rotor, measured(rotor, 0), budget=60)
    assert (found.stop, found.model_evaluations) == ("optimizer", 60)


def test_a_budget_that_the_optimizer_swallowed_was_spent_all_the_same(rotor):
    class Swallowing(DE):
        def minimize(self, objective, rng):
            try:
                return super().minimize(objective, rng)
            except BudgetSpent:
                return None

    found = identified(Swallowing(), rotor, measured(rotor, 0), budget=50)
    assert (found.stop, found.model_evaluations) == ("budget", 50)


def test_evaluations_and_jacobians_are_counted_apart(rotor):
    problem = Counted(rotor)
    found = identified(LM(screening=500, starts=3), problem, measured(rotor, 0))
    assert found.model_evaluations == problem.evaluations > 500
    assert found.model_jacobians == problem.sensitivities > 0
    assert found.surrogate_evaluations == found.updates == 0
    assert found.seconds["model"] + found.seconds["search"] == pytest.approx(found.seconds["total"])


def test_population_methods_take_no_derivatives(rotor):
    found = identified(DE(population=20, generations=4), rotor, measured(rotor, 0))
    assert (found.model_evaluations, found.model_jacobians) == (20 * 5, 0)


def test_a_problem_without_sensitivity_works_by_differences(rotor):
    measurement = measured(rotor, 0)
    problem = Counted(rotor, with_sensitivity=False)
    found = identified(LM(), problem, measurement)
    assert found.model_evaluations == problem.points and found.model_jacobians == 0
    # differences with steps of 1e-5, at peaks 1e-3 of the cube wide, are wrong by 1e-4; the minimum by its square
    assert found.misfit == pytest.approx(misfit_from_the_truth(rotor, measurement), abs=1e-3)
    with_sensitivity = identified(LM(), rotor, measurement)
    # ten points for each Jacobian
    assert found.model_evaluations > with_sensitivity.model_evaluations + 5 * with_sensitivity.model_jacobians


def test_the_same_streams_give_the_same_result(rotor):
    measurement = measured(rotor, 0)
    first, again, other = (identified(DE(generations=5), rotor, measurement, seed).x.tolist() for seed in (1, 1, 2))
    assert first == again != other


def test_values_at_a_limit_are_told(rotor):
    narrow = ThreeDisk(limits={"kxx": [52.0, 100.0]}).build()
    found = identified(LM(screening=1000), narrow, measured(rotor, 0))
    assert found.at_limit[0] and not found.at_limit[4]


def test_a_model_without_any_value_is_an_error_that_says_so(rotor):
    class Silent(Counted):
        def response(self, x):
            return np.full_like(super().response(x), np.nan)

    with pytest.raises(ArithmeticError, match="none of the 60 points of the optimiser has a finite misfit"):
        identified(DE(population=20, generations=2), Silent(rotor), measured(rotor, 0))


def test_an_optimizer_that_does_not_suit_the_unknowns_is_refused(rotor):
    with pytest.raises(SettingError, match="bits: expected one entry for each of 5 parameters, got 2"):
        Direct(GA(bits=[20, 32])).validate(rotor)
    Direct(GA()).validate(rotor)
