"""Objective: every point counted, the best one kept, the budget exact."""

import numpy as np
import pytest

from ksmea.errors import BudgetSpent
from ksmea.numerics.objective import Objective

LOWEST = np.array([0.3, 0.7])


class Bowl:
    """(2 (u₁ − 0.3), (u₂ − 0.7)²) with the points it was asked for."""

    def __init__(self):
        self.points = []

    def residuals(self, u):
        self.points.extend(u.tolist())
        return np.stack([2 * (u[:, 0] - 0.3), (u[:, 1] - 0.7) ** 2], axis=1)

    def jacobian(self, u):
        return np.array([[2.0, 0.0], [0.0, 2 * (u[1] - 0.7)]])


def random_points(n, seed=0):
    return np.random.default_rng(seed).random((n, 2))


def test_the_value_is_the_sum_of_squared_residuals():
    u = np.array([[0.3, 0.7], [0.8, 0.7], [0.3, 0.2]])
    assert np.allclose(Objective(2, Bowl().residuals)(u), [0.0, 1.0, 0.0625], rtol=1e-14)


def test_points_are_counted_wherever_they_are_evaluated():
    bowl = Bowl()
    objective = Objective(2, bowl.residuals, jacobian_at=bowl.jacobian, screening_at=lambda u: u[:, 0])
    objective(random_points(7))
    objective.residuals(np.array([0.1, 0.2]))
    assert objective.evaluations == len(bowl.points) == 8
    objective.screening(random_points(5))
    assert objective.evaluations == 13
    objective.jacobian(np.array([0.1, 0.2]))
    minimum = objective.result()
    assert (minimum.evaluations, minimum.jacobians) == (13, 1)


def test_screening_is_the_misfit_where_there_is_none():
    bowl = Bowl()
    objective = Objective(2, bowl.residuals)
    u = random_points(4)
    assert np.array_equal(objective.screening(u), np.sum(Bowl().residuals(u) ** 2, axis=1))
    assert objective.evaluations == len(bowl.points) == 4
    assert objective.result().value < np.inf  # these points have a misfit and may be the best


def test_a_screened_point_has_no_misfit_and_is_never_the_best():
    objective = Objective(2, Bowl().residuals, screening_at=lambda u: np.full(len(u), -1.0))
    objective.screening(random_points(4))
    assert objective.result().value == np.inf


def test_the_best_point_is_the_best_of_all_batches():
    objective = Objective(2, Bowl().residuals)
    u = random_points(50)
    for batch in np.split(u, 5):
        objective(batch)
    values = np.sum(Bowl().residuals(u) ** 2, axis=1)
    assert objective.result().value == values.min()
    assert np.array_equal(objective.result().u, u[values.argmin()])


def test_the_result_does_not_change_with_the_callers_array():
    objective = Objective(2, Bowl().residuals)
    u = LOWEST[None].copy()
    objective(u)
    u[:] = 0.0
    objective.result().u[:] = 0.0
    assert np.array_equal(objective.result().u, LOWEST)


def test_the_last_batch_is_cut_to_the_budget_and_then_it_is_spent():
    bowl = Bowl()
    objective = Objective(2, bowl.residuals, budget=10)
    u = random_points(8)
    assert len(objective(u)) == 8
    with pytest.raises(BudgetSpent, match="budget of 10 evaluations"):
        objective(u)
    assert objective.evaluations == len(bowl.points) == 10
    assert np.array_equal(bowl.points[8:], u[:2])
    with pytest.raises(BudgetSpent):
        objective(u[:1])
    assert objective.evaluations == len(bowl.points) == 10


def test_a_batch_that_fits_exactly_does_not_spend_the_budget():
    objective = Objective(2, Bowl().residuals, budget=4)
    assert len(objective(random_points(4))) == 4 and not objective.was_refused
    with pytest.raises(BudgetSpent):
        objective(random_points(1))
    assert objective.was_refused


def test_the_best_point_of_a_cut_batch_is_remembered():
    objective = Objective(2, Bowl().residuals, budget=2)
    with pytest.raises(BudgetSpent):
        objective(np.array([[0.9, 0.9], LOWEST, [0.1, 0.1]]))
    assert np.array_equal(objective.result().u, LOWEST)


def test_a_point_beyond_the_budget_is_not_remembered():
    objective = Objective(2, Bowl().residuals, budget=2)
    with pytest.raises(BudgetSpent):
        objective(np.array([[0.9, 0.9], [0.1, 0.1], LOWEST]))
    assert objective.result().value > 0


@pytest.mark.parametrize("ask", ["residuals", "screening", "jacobian"])
def test_every_kind_of_question_ends_at_the_budget(ask):
    bowl = Bowl()
    objective = Objective(2, bowl.residuals, budget=3)
    with pytest.raises(BudgetSpent):
        for _ in range(4):
            getattr(objective, ask)(LOWEST)
    assert objective.evaluations == len(bowl.points) == 3


def test_spending_the_budget_is_an_exception_that_libraries_do_not_mistake():
    assert BudgetSpent.__bases__ == (Exception,)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_point_without_a_value_is_the_worst(bad):
    objective = Objective(2, lambda u: np.where(u[:, :1] > 0.5, bad, u))
    values = objective(np.array([[0.9, 0.1], [0.4, 0.2]]))
    assert values[0] == np.inf and np.isfinite(values[1])
    assert np.array_equal(objective.result().u, [0.4, 0.2])


def test_screening_without_a_value_is_the_worst():
    objective = Objective(1, lambda u: u, screening_at=lambda u: np.array([np.nan, 1.0, -np.inf]))
    assert np.array_equal(objective.screening(np.array([[0.1], [0.2], [0.3]])), [np.inf, 1.0, np.inf])


def test_a_single_evaluation_without_a_value_is_not_the_best():
    objective = Objective(1, lambda u: np.where(u > 0.5, np.nan, u))
    objective.residuals(np.array([0.9]))
    assert objective.result().value == np.inf
    objective.residuals(np.array([0.2]))
    assert objective.result().value == pytest.approx(0.04)


@pytest.mark.parametrize("u", [[0.4, 0.6], [0.0, 1.0], [1.0, 0.0], [1e-6, 1 - 1e-6]])
def test_differences_are_counted_as_points_and_agree_with_the_derivatives(u):
    bowl = Bowl()
    objective = Objective(2, bowl.residuals)
    found = objective.jacobian(np.array(u))
    # central differences of a quadratic are exact up to rounding 1e-16 / 1e-5; at a bound they are one-sided, and
    # wrong by half the step times the second derivative, 1e-5
    assert np.allclose(found, bowl.jacobian(np.array(u)), rtol=0, atol=1.1e-5)
    if 1e-5 <= min(u) and max(u) <= 1 - 1e-5:
        assert np.allclose(found, bowl.jacobian(np.array(u)), rtol=0, atol=1e-9)
    assert objective.evaluations == len(bowl.points) == 4 and objective.jacobians == 0
    assert np.min(bowl.points) >= 0 and np.max(bowl.points) <= 1


def test_differences_stay_within_the_budget():
    bowl = Bowl()
    objective = Objective(2, bowl.residuals, budget=3)
    with pytest.raises(BudgetSpent):
        objective.jacobian(LOWEST)
    assert objective.evaluations == len(bowl.points) == 3


def test_rounding_outside_the_cube_is_moved_back_inside():
    bowl = Bowl()
    Objective(2, bowl.residuals)(np.array([[-1e-12, 1 + 1e-12]]))
    assert bowl.points == [[0.0, 1.0]]


def test_points_of_another_dimension_are_refused():
    with pytest.raises(ValueError, match=r"expected points of shape \(k, 2\), got \(4, 3\)"):
        Objective(2, Bowl().residuals)(np.zeros((4, 3)))


def test_before_any_value_the_result_is_the_middle_without_one():
    minimum = Objective(2, Bowl().residuals).result()
    assert np.array_equal(minimum.u, [0.5, 0.5]) and minimum.value == np.inf and minimum.evaluations == 0


@pytest.mark.parametrize(
    ("point", "line"),
    [
        ([0.5 + 0.1j, 0.5], "expected real points, got complex ones"),
        ([1.1, 0.5], "expected coordinates from 0 to 1, got one that is 0.1 outside"),
        ([0.5, -np.inf], "expected coordinates from 0 to 1, got one that is inf outside"),
    ],
)
def test_points_that_are_none_of_the_cube_are_refused(point, line):
    """In a sweep as in the exam: what was clipped in silence was computed at another point than the optimiser knew."""
    objective = Objective(2, lambda u: u - 0.5)
    with pytest.raises(ValueError, match=line):
        objective(np.array([point]))
    assert objective(np.array([[1 + 1e-12, 0.5]])) == pytest.approx(0.25)
