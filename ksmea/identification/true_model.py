"""True model in place of a surrogate: objective for an optimiser, final step to the nearest maximum."""

from __future__ import annotations

import dataclasses
from contextlib import suppress

from ksmea.arrays import Array
from ksmea.errors import BudgetSpent
from ksmea.inference.maximisation import nearest_maximum
from ksmea.likelihood.likelihood import Likelihood
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.measurement import Measurement
from ksmea.numerics.least_squares import descend
from ksmea.numerics.objective import Objective
from ksmea.plugins.surrogate import Predictor
from ksmea.plugins.transforms import Transform
from ksmea.problem.case import Case
from ksmea.problem.counted import Model


class TrueModel(Predictor):
    """A predictor without error: each prediction is a counted evaluation of the model."""

    def __init__(self, model: Model, transform: Transform) -> None:
        self.model = model
        self.transform = transform

    def predict(self, u: Array) -> Array:
        """Points (k, d) → outputs (k, q) as surrogates model them."""
        return self.transform.encode(self.model.response(u))


def model_objective(model: Model, misfit: Misfit, budget: int | None = None) -> Objective:
    """Misfit of the true model as an objective.

    The Jacobian is from the sensitivity if the problem has one. Raises `SettingError` if the model's problem is not
    evaluated as the misfit's measurement.
    """

    def residuals(u: Array) -> Array:
        return misfit.residuals(misfit.observed(model.response(u)))

    def jacobian(u: Array) -> Array:
        return misfit.jacobian(*model.linearise(u))

    few = Case(model.problem, misfit.measurement).for_screening()
    by_few = (
        misfit if few.measurement is misfit.measurement else dataclasses.replace(misfit, measurement=few.measurement)
    )

    def screening(u: Array) -> Array:
        return by_few.screening(by_few.observed(model.response_of(few.problem, u)))

    return Objective(
        len(model.problem.parameters),
        residuals,
        jacobian_at=jacobian if model.problem.has_sensitivity else None,
        screening_at=screening,
        budget=budget,
        jacobian_cost=model.jacobian_cost,
    )


FINAL_STEP = "final step"  # the stage's name


def most_likely(model: Model, measurement: Measurement, start: Array) -> tuple[Array, float] | None:
    """Maximum (d,) of the likelihood nearest to a point of the unit cube, and its deviance.

    The noise is also estimated if its level is not known. None if the model's budget does not admit a step. Data
    without noise have no likelihood: least squares and their misfit are used.
    """
    misfit = Misfit(measurement, "likelihood")
    if model.is_spent:
        return None
    if measurement.noise is not None and measurement.noise.is_absent:
        objective = model_objective(model, misfit, model.left)
        with suppress(BudgetSpent):
            descend(objective, start, max_iterations=100)
        found = objective.result()
        return found.u, found.value
    try:
        maximum = nearest_maximum(Likelihood(model, measurement), start)
    except BudgetSpent:
        return None
    return maximum.theta[: len(start)], maximum.deviance
