"""Bounded least squares from one start."""

import numpy as np
import pytest

from ksmea.errors import BudgetSpent
from ksmea.numerics.least_squares import descend
from ksmea.numerics.objective import Objective


def valley(u):
    """Rosenbrock's function with its minimum at (0.6, 0.36), (k, 2) → (k, 2)."""
    return np.stack([10 * (u[:, 1] - u[:, 0] ** 2), 0.6 - u[:, 0]], axis=1)


def valley_jacobian(u):
    return np.array([[-20 * u[0], 10.0], [-1.0, 0.0]])


@pytest.mark.parametrize("jacobian_at", [valley_jacobian, None], ids=["derivatives", "differences"])
@pytest.mark.parametrize("start", [[0.1, 0.9], [0.0, 0.0], [1.0, 1.0], [0.6, 0.36]])
def test_it_finds_the_minimum(jacobian_at, start):
    objective = Objective(2, valley, jacobian_at=jacobian_at)
    descend(objective, np.array(start), max_iterations=100)
    # zero residuals: quadratic convergence down to xtol = 1e-12; differences are exact for a quadratic
    assert np.allclose(objective.result().u, [0.6, 0.36], rtol=0, atol=1e-8)
    assert objective.result().value < 1e-15


@pytest.mark.parametrize(
    "target, expected", [([-0.5, 0.4], [0.0, 0.4]), ([1.7, 0.4], [1.0, 0.4]), ([-1.0, 2.0], [0.0, 1.0])]
)
def test_it_finds_a_minimum_on_a_bound(target, expected):
    asked = []

    def residuals(u):
        asked.append(u)
        return u - np.array(target)

    objective = Objective(2, residuals, jacobian_at=lambda u: np.eye(2))
    descend(objective, np.array([0.5, 0.5]), max_iterations=100)
    # the reflective method stays inside and closes in; 1e-3 of the range is what counts as on the bound
    assert np.allclose(objective.result().u, expected, rtol=0, atol=1e-4)
    assert np.min(asked) >= 0 and np.max(asked) <= 1


@pytest.mark.parametrize("max_iterations", [1, 2, 5])
def test_it_evaluates_no_more_than_it_may(max_iterations):
    objective = Objective(2, valley, jacobian_at=valley_jacobian)
    descend(objective, np.array([0.1, 0.9]), max_iterations=max_iterations)
    assert objective.evaluations == max_iterations  # the valley takes more than 5, so that all are used
    assert 1 <= objective.jacobians <= max_iterations


def test_a_start_is_moved_off_the_bounds_by_the_margin():
    asked = []

    def residuals(u):
        asked.append(u[0])
        return u - 0.5

    descend(
        Objective(2, residuals, jacobian_at=lambda u: np.eye(2)), np.array([0.0, 1.0]), max_iterations=5, margin=0.1
    )
    assert np.allclose(asked[0], [0.1, 0.9])


def test_a_derivative_that_cannot_be_computed_does_not_end_the_others():
    def jacobian_at(u):
        jacobian = valley_jacobian(u)
        return np.column_stack([jacobian, [np.nan, np.inf]])

    objective = Objective(3, lambda u: valley(u[:, :2]), jacobian_at=jacobian_at)
    descend(objective, np.array([0.1, 0.9, 0.25]), max_iterations=100)
    assert np.allclose(objective.result().u, [0.6, 0.36, 0.25], rtol=0, atol=1e-8)


def test_without_any_derivative_it_ends_where_it_started():
    objective = Objective(2, valley, jacobian_at=lambda u: np.full((2, 2), np.nan))
    descend(objective, np.array([0.1, 0.9]), max_iterations=100)
    assert np.allclose(objective.result().u, [0.1, 0.9])


def test_a_spent_budget_passes():
    objective = Objective(2, valley, jacobian_at=valley_jacobian, budget=3)
    with pytest.raises(BudgetSpent):
        descend(objective, np.array([0.1, 0.9]), max_iterations=100)
    assert objective.evaluations == 3 and objective.result().value < np.inf
