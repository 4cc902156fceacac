"""Objective of an optimiser: counts points, keeps the best one, ends exactly at the budget."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import BudgetSpent
from ksmea.numerics.differences import cube_differences
from ksmea.numerics.meter import SPENT_BEHIND, Meter

ROUNDING = 1e-9  # outside the unit cube, of a library's own handling of limits


@dataclass(frozen=True)
class Minimum:
    """Best point of a search.

    Args:
        u: point (d,) in the unit cube.
        value: its misfit.
        evaluations: points that were evaluated until then.
        jacobians: Jacobians that were computed until then.
    """

    u: Array
    value: float
    evaluations: int
    jacobians: int


class Objective(Meter):
    """Misfit over the unit cube, batched, counted and with a budget.

    Points are counted wherever they are evaluated, Jacobians apart. The last batch is cut to what the budget leaves; more points
    raise `BudgetSpent` after the cut batch has been evaluated and remembered.

    Args:
        dim: number of unknowns d.
        residuals_at: points (k, d) → residuals (k, m), whose sum of squares is the misfit.
        jacobian_at: point (d,) → derivatives (m, d) of the residuals. Default: central differences.
        screening_at: points (k, d) → robust misfit (k,) without narrow valleys, for choosing starts. Default: the misfit.
        budget: largest number of points. Default: no limit.
        jacobian_cost: number of points that a Jacobian counts as in the budget.

    >>> sphere = Objective(2, lambda u: u - 0.5, budget=3)
    >>> sphere(np.array([[0.5, 0.5], [0.0, 0.0]]))
    array([0. , 0.5])
    >>> sphere.result().value, sphere.result().evaluations
    (0.0, 2)
    """

    def __init__(
        self,
        dim: int,
        residuals_at: Callable[[Array], Array],
        *,
        jacobian_at: Callable[[Array], Array] | None = None,
        screening_at: Callable[[Array], Array] | None = None,
        budget: int | None = None,
        jacobian_cost: int = 0,
    ) -> None:
        super().__init__(budget, jacobian_cost)
        self.dim = dim
        self.stages: list[
            tuple[str, Minimum]
        ] = []  # parts of the search that have ended, and the best point until then
        self._residuals_at = residuals_at
        self._jacobian_at = jacobian_at
        self._screening_at = screening_at
        self._best_u = np.full(dim, 0.5)
        self._best_value = np.inf

    def __call__(self, u: Array) -> Array:
        """Misfit at points.

        Args:
            u: points (k, d) in the unit cube.

        Returns:
            Misfit (k,); infinite at a point where it cannot be computed.

        Raises:
            BudgetSpent: there were more points than the budget leaves.
            ValueError: points of another dimension, complex, or outside the unit cube.
        """
        u = self._checked(u)
        return self._within_budget(u, self._values)

    def residuals(self, u: Array) -> Array:
        """Residuals at one point; their sum of squares is the misfit there.

        Args:
            u: point (d,) in the unit cube.

        Returns:
            Residuals (m,).

        Raises:
            BudgetSpent: the budget is spent.
        """
        return np.asarray(self.all_residuals(u)[0])

    def all_residuals(self, u: Array) -> Array:
        """Residuals at points.

        Args:
            u: points (k, d) in the unit cube.

        Returns:
            Residuals (k, m).

        Raises:
            BudgetSpent: there were more points than the budget leaves.
        """
        return self._within_budget(self._checked(u), self._remembered_residuals)

    def jacobian(self, u: Array) -> Array:
        """Derivatives of the residuals at one point; central differences if none are given.

        Args:
            u: point (d,) in the unit cube.

        Returns:
            Derivatives (m, d).

        Raises:
            BudgetSpent: the budget is spent.

        >>> Objective(2, lambda u: u**2).jacobian(np.array([0.5, 0.25])).round(6)
        array([[1. , 0. ],
               [0. , 0.5]])
        """
        u = self._checked(u)[0]
        if self._jacobian_at is not None:
            self.require(self.jacobian_cost)
            self.jacobians += 1
            return self._jacobian_at(u)
        return self._differences(u)

    def screening(self, u: Array) -> Array:
        """Robust misfit at points, counted like any other point; default: the misfit itself.

        Args:
            u: points (k, d) in the unit cube.

        Returns:
            Robust misfit (k,).

        Raises:
            BudgetSpent: there were more points than the budget leaves.
        """
        screening_at = self._screening_at
        if screening_at is None:
            return self(u)
        return self._within_budget(self._checked(u), lambda points: _finite_or_inf(screening_at(points)))

    @property
    def has_jacobian(self) -> bool:
        """Whether derivatives are given, and not taken as differences."""
        return self._jacobian_at is not None

    def result(self) -> Minimum:
        """The best point evaluated so far."""
        return Minimum(self._best_u.copy(), float(self._best_value), self.evaluations, self.jacobians)

    def found(self, model: Meter) -> Minimum:
        """Best point, if it has a finite misfit.

        Args:
            model: meter of the model behind the objective.

        Raises:
            BudgetSpent: the budget of the model was spent without the objective.
            ArithmeticError: no point has a finite misfit.
        """
        best = self.result()
        if np.isfinite(best.value):
            return best
        if model.was_refused or (self.was_refused and not self.evaluations):
            raise BudgetSpent(SPENT_BEHIND)
        raise ArithmeticError(f"none of the {self.evaluations} points of the optimiser has a finite misfit")

    def end_stage(self, name: str) -> None:
        """Keep how a part of the search ended, if anything was evaluated since the last one did.

        Args:
            name: name of the part.
        """
        minimum = self.result()
        taken = [(each.evaluations, each.jacobians) for _, each in self.stages] or [(0, 0)]
        if taken[-1] != (minimum.evaluations, minimum.jacobians):
            self.stages.append((name, minimum))

    def _checked(self, u: Array) -> Array:
        if np.iscomplexobj(u):
            raise ValueError(
                "objective: expected real points, got complex ones; take their real parts if that is meant"
            )
        u = np.atleast_2d(np.asarray(u, dtype=float))
        if u.shape[1] != self.dim:
            raise ValueError(f"objective: expected points of shape (k, {self.dim}), got {u.shape}")
        worst = float(np.max(np.abs(u - 0.5), initial=0.0)) - 0.5
        if worst > ROUNDING:
            raise ValueError(
                f"objective: expected coordinates from 0 to 1, got one that is {worst:.3g} outside; clip, reflect or draw it anew"
            )
        return np.clip(u, 0.0, 1.0)

    def _within_budget(self, u: Array, evaluate: Callable[[Array], Array]) -> Array:
        if len(u) == 0:
            return np.empty((0,))
        n = self.admitted(len(u))
        values = np.empty(0)
        if n:
            self.evaluations += n  # before they are evaluated: who swallows the errors of a model ends too
            values = evaluate(u[:n])
        if n < len(u):
            self.refuse()
        return values

    def _values(self, u: Array) -> Array:
        values = _finite_or_inf(np.sum(self._residuals_at(u) ** 2, axis=1))
        self._remember(u, values)
        return values

    def _remembered_residuals(self, u: Array) -> Array:
        residuals = self._residuals_at(u)
        self._remember(u, _finite_or_inf(np.sum(residuals**2, axis=1)))
        return residuals

    def _remember(self, u: Array, values: Array) -> None:
        best = int(np.argmin(values))
        if values[best] < self._best_value:
            self._best_u, self._best_value = u[best].copy(), values[best]

    def _differences(self, u: Array) -> Array:
        differences = cube_differences(u)
        return differences.derivative(self._within_budget(differences.points, self._remembered_residuals))


def _finite_or_inf(values: Array) -> Array:
    """NaN poisons a population: a point without a value is the worst one."""
    return np.where(np.isfinite(values), values, np.inf)


class SearchPart(Objective):
    """Part of an objective: points lower + width · v for v in the unit cube (d,), with its own budget.

    A budget of None is the remaining budget of the whole objective, which also counts and remembers every point.

    >>> import numpy as np
    >>> whole = Objective(1, lambda u: u - 0.5, budget=10)
    >>> part = SearchPart(whole, np.array([0.4]), 0.2, budget=2)
    >>> part(np.array([[0.0], [0.5]])).round(3), whole.result().u, whole.evaluations
    (array([0.01, 0.  ]), array([0.5]), 2)
    """

    def __init__(self, whole: Objective, lower: Array, width: float, budget: int | None = None) -> None:
        def inside(v: Array) -> Array:
            return lower + width * v

        super().__init__(
            whole.dim,
            lambda v: whole.all_residuals(inside(v)),
            jacobian_at=(lambda v: width * whole.jacobian(inside(v))) if whole.has_jacobian else None,
            screening_at=lambda v: whole.screening(inside(v)),
            budget=whole.left if budget is None else budget,
            jacobian_cost=whole.jacobian_cost,
        )
        self._whole = whole
        self._takes_all = budget is None

    def refuse(self) -> NoReturn:
        self._whole.was_refused |= self._takes_all
        super().refuse()
