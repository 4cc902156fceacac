"""The exam of optimisers: bounds, budgets, points without a value, and the minimum of a sphere."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import BudgetSpent
from ksmea.numerics.objective import Minimum, Objective
from ksmea.plugins.optimizer import Optimizer
from ksmea.testing.exam import Exam, ExamFailed, require
from ksmea.testing.repeat import OF_DRAWS, Drawn
from ksmea.testing.settings import OF_SETTINGS
from ksmea.testing.surroundings import IN_A_SWEEP

BUDGETS = (1, 7, 99, 250)  # one point, less than a population, and odd numbers that end amid one
SHORT = 999  # points of those runs that need no convergence
ROUNDING = 1e-12  # outside the unit cube, of a library's own handling of limits
MOST_REFUSALS = 100  # calls after the budget is spent, of a library that swallows the first ones
LAST_WITH_VALUE = 0.6  # in the first coordinate: points beyond have no value
SLOWED = 5  # times as far from the minimum may a search end that points without a value slow down


@dataclass(frozen=True)
class OptimizerCase(Drawn):
    """An optimiser, and what is stated of it.

    In `dim` dimensions it comes within `distance` of a sphere's minimum (unit cube) with `evaluations`, or fewer if it
    ends by itself.
    """

    contract: ClassVar = Optimizer
    plugin: Optimizer
    dim: int = 5
    evaluations: int = 20_000
    distance: float = 0.02

    @property
    def lowest(self) -> Array:
        """Minimum of the sphere (dim,): inside the cube, coordinates all different, none a round number."""
        return np.asarray(0.2 + 0.6 * ((0.31 + 0.618034 * np.arange(self.dim)) % 1), dtype=float)

    def sphere(self, u: Array) -> Array:
        return np.asarray(u - self.lowest)

    def outcome(self, seed: int) -> Array:
        return self.watched(self.sphere, seed=seed).points

    def watched(self, residuals_at: Callable[[Array], Array], budget: int = SHORT, seed: int = 1) -> Watched:
        """An objective after the optimiser has worked on it, or has spent its budget."""
        objective = Watched(self.dim, residuals_at, budget)
        with suppress(BudgetSpent, _NeverEnds):
            objective.returned = self.plugin.minimize(objective, np.random.default_rng(seed))
        return objective


class _NeverEnds(BaseException):
    """Ends an optimiser that goes on asking; no `except Exception` keeps it."""


class Watched(Objective):
    """An objective that notes what it is asked, before that is cut to the limits, and what is computed."""

    def __init__(self, dim: int, residuals_at: Callable[[Array], Array], budget: int) -> None:
        self.asked: list[Array] = []
        self.computed: list[Array] = []
        self.refusals = 0
        self.returned: Minimum | None = None  # by the optimiser; None where the budget ended it

        def noted(u: Array) -> Array:
            self.computed.append(u.copy())
            return residuals_at(u)

        super().__init__(dim, noted, budget=budget)

    @property
    def points(self) -> Array:
        """All points that were computed, (n, d)."""
        return np.concatenate([np.empty((0, self.dim)), *self.computed])

    def __call__(self, u: Array) -> Array:
        return super().__call__(self._noted(u))

    def all_residuals(self, u: Array) -> Array:
        return super().all_residuals(self._noted(u))

    def jacobian(self, u: Array) -> Array:
        return super().jacobian(self._noted(u))

    def screening(self, u: Array) -> Array:
        return super().screening(self._noted(u))

    def _noted(self, u: Array) -> Array:
        self.refusals += self.was_refused
        if self.refusals > MOST_REFUSALS:
            raise _NeverEnds
        self.asked.append(np.atleast_2d(np.asarray(u, dtype=float)).copy())
        return u


def asks_within_bounds(case: OptimizerCase) -> None:
    """Points lie within the unit cube only, also if the minimum is outside."""
    beyond = np.where(np.arange(case.dim) % 2, -0.5, 1.5)
    asked = np.concatenate(case.watched(lambda u: u - beyond).asked)
    worst = float(np.max(np.abs(asked - 0.5))) - 0.5
    require(
        worst <= ROUNDING,
        "coordinates from 0 to 1",
        f"one that is {worst:.3g} outside",
        "clip, reflect or draw them anew: the objective clips them, and computes limits again and again",
    )


def returns_the_objectives_result(case: OptimizerCase) -> None:
    """The result is the best of all points, as the objective has it."""
    objective = case.watched(case.sphere, case.evaluations)
    returned, best = objective.returned, objective.result()
    if returned is None and objective.was_refused:
        return
    same = (
        isinstance(returned, Minimum)
        and np.array_equal(returned.u, best.u)
        and (returned.value, returned.evaluations) == (best.value, best.evaluations)
    )
    require(same, repr(best), repr(returned), "end with return objective.result()")


def ends_with_its_budget(case: OptimizerCase) -> None:
    """A budget is not overspent, and an optimiser ends when it is spent.

    Optimisers that swallow `BudgetSpent` must end, too.
    """
    for budget in BUDGETS:
        objective = case.watched(case.sphere, budget)
        require(
            objective.refusals <= MOST_REFUSALS,
            f"an end once {budget} evaluations are spent",
            f"{MOST_REFUSALS} more calls",
            "let BudgetSpent pass: except Exception around the objective swallows it",
        )
        computed = len(objective.points)
        require(
            computed <= budget,
            f"at most {budget} points computed",
            str(computed),
            "ask by objective(u), objective.residuals(u) or objective.jacobian(u) alone: they count",
        )


def survives_points_without_value(case: OptimizerCase) -> None:
    """Where NaN makes the misfit of many points +inf, the minimum among the others is found all the same."""

    def residuals_at(u: Array) -> Array:
        return np.where(u[:, :1] > LAST_WITH_VALUE, np.nan, case.sphere(u))

    minimum = case.watched(residuals_at, case.evaluations).result()
    distance = float(np.linalg.norm(minimum.u - case.lowest))
    require(
        distance <= SLOWED * case.distance,
        f"a point within {SLOWED * case.distance:g} of the minimum",
        f"one at {distance:.3g} with misfit {minimum.value:.3g}",
        "take +inf for worse than any number: compare, and take no differences or means of it",
    )


def survives_no_value_anywhere(case: OptimizerCase) -> None:
    """An objective of +inf everywhere is worked off without an error."""
    case.watched(lambda u: np.full_like(u, np.nan))


def survives_infinite_residuals(case: OptimizerCase) -> None:
    """Infinite residuals next to others are worked off without an error."""
    case.watched(lambda u: np.where(u[:, :1] > LAST_WITH_VALUE, np.inf, case.sphere(u)))


def survives_a_constant(case: OptimizerCase) -> None:
    """An objective that is the same everywhere is worked off without an error."""
    minimum = case.watched(lambda u: np.ones_like(u)).result()
    require(minimum.value == case.dim, "the constant", str(minimum.value), "evaluate at least one point")


def errors_of_the_model_pass(case: OptimizerCase) -> None:
    """An error of the model arrives as it was raised."""

    def residuals_at(u: Array) -> Array:
        raise _SingularModel("singular at this speed")

    try:
        case.watched(residuals_at)
    except _SingularModel:
        return
    except Exception as error:
        got = f"{type(error).__name__}: {error}"
    else:
        got = "no error"
    raise ExamFailed(f"expected the model's own ValueError, got {got}; catch nothing around the objective")


class _SingularModel(ValueError):
    """An error that a model may raise: a singular matrix is a ValueError too."""


def finds_the_minimum_of_a_sphere(case: OptimizerCase) -> None:
    """The minimum of a sphere is found as nearly, and with as few evaluations, as stated."""
    minimum = case.watched(case.sphere, case.evaluations).result()
    distance = float(np.linalg.norm(minimum.u - case.lowest))
    require(
        distance <= case.distance,
        f"a point within {case.distance:g} of the minimum by {case.evaluations} evaluations",
        f"one at {distance:.3g} after {minimum.evaluations}",
        "mend the search, or state what it reaches: evaluations=…, distance=…",
    )


def optimizer_properties(case: OptimizerCase) -> Sequence[Callable[[OptimizerCase], None]]:
    return (
        *OF_SETTINGS,
        *IN_A_SWEEP,
        asks_within_bounds,
        returns_the_objectives_result,
        ends_with_its_budget,
        *OF_DRAWS,
        survives_points_without_value,
        survives_no_value_anywhere,
        survives_infinite_residuals,
        survives_a_constant,
        errors_of_the_model_pass,
        finds_the_minimum_of_a_sphere,
    )


check_optimizer = Exam(OptimizerCase, optimizer_properties)
