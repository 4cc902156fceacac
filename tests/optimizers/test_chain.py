"""One optimiser after another: boxes of objectives, budgets, and stages."""

import numpy as np
import pytest

from ksmea.errors import BudgetSpent, SettingError
from ksmea.numerics.objective import Objective, SearchPart
from optimizers.chain import Chain
from optimizers.de import DE

LOWEST = np.array([0.31, 0.77, 0.52])


def sphere(budget=None, jacobian=True, cost=0):
    return Objective(
        3,
        lambda u: (u - LOWEST) * [1.0, 3.0, 10.0],
        jacobian_at=(lambda u: np.diag([1.0, 3.0, 10.0])) if jacobian else None,
        budget=budget,
        jacobian_cost=cost,
    )


def test_a_part_is_the_same_function_of_its_own_coordinates():
    whole, lower, width = sphere(), np.array([0.2, 0.7, 0.5]), 0.25
    part = SearchPart(whole, lower, width)
    v = np.array([0.3, 0.9, 0.1])
    assert np.allclose(part.residuals(v), sphere().residuals(lower + width * v), rtol=1e-14)
    jacobian = part.jacobian(v)
    assert np.allclose(jacobian, width * sphere().jacobian(lower), rtol=1e-14)
    differences = SearchPart(sphere(jacobian=False), lower, width).jacobian(v)
    # central differences of a linear function: rounding alone
    assert np.allclose(differences, jacobian, rtol=1e-6, atol=1e-9)
    assert (whole.evaluations, whole.jacobians) == (part.evaluations, part.jacobians) == (1, 1)
    assert np.allclose(whole.result().u, lower + width * v) and whole.result().value == part.result().value


@pytest.mark.parametrize("jacobian", [True, False])
def test_what_goes_on_comes_nearer_and_each_is_a_stage(jacobian):
    objective = sphere(jacobian=jacobian)
    chain = Chain("random_search", "lm", {"evaluations": 300}, {"screening": 0, "starts": 1}, width=0.3)
    chain.minimize(objective, np.random.default_rng(1))
    (first, searched), (then, found) = objective.stages
    assert (first, then) == ("random_search", "then lm")
    assert (
        searched.evaluations == 300 and searched.value > 1e-3
    )  # 300 points leave 0.07 of the cube's side between them
    assert found.value < 1e-16  # least squares of linear residuals


def test_the_first_is_the_same_alone_and_in_a_chain():
    alone, objective = sphere(), sphere()
    DE(generations=5).minimize(alone, np.random.default_rng(2))
    Chain("de", "nelder_mead", {"generations": 5}, {"evaluations": 50}).minimize(objective, np.random.default_rng(2))
    first = objective.stages[0][1]
    assert (first.u.tolist(), first.evaluations) == (alone.result().u.tolist(), alone.evaluations)


@pytest.mark.parametrize("budget", [1, 10, 101])
@pytest.mark.parametrize("then", ["pso", "lm"])
def test_a_budget_is_shared_and_spent_to_the_last_point(budget, then):
    objective = sphere(budget)
    with pytest.raises(BudgetSpent):
        Chain("de", then, share=0.3).minimize(objective, np.random.default_rng(3))
    assert objective.evaluations == budget and objective.was_refused
    assert objective.stages[0][1].evaluations == int(np.ceil(0.3 * budget))


def test_jacobians_cost_a_part_what_they_cost_the_whole():
    objective = sphere(60, cost=10)
    with pytest.raises(BudgetSpent):
        Chain("random_search", "lm", {}, {"screening": 0, "starts": 1}, share=0.5).minimize(
            objective, np.random.default_rng(3)
        )
    assert 60 - 10 < objective.evaluations + 10 * objective.jacobians <= 60 and objective.jacobians > 0


def test_a_name_or_setting_that_is_none_is_refused():
    with pytest.raises(SettingError, match="unknown optimizer 'dee'; did you mean 'de'"):
        Chain("dee")
    with pytest.raises(SettingError, match=r"optimizer=de.*'popul'.*did you mean 'population'"):
        Chain(first_settings={"popul": 3})
