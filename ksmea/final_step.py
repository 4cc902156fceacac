"""The last step of an identification: from a point near the optimum to the maximum of the true model's likelihood."""

from __future__ import annotations

from contextlib import suppress

from ksmea.arrays import Array
from ksmea.descent import descend
from ksmea.errors import BudgetSpent
from ksmea.likelihood import Likelihood
from ksmea.measurement import Measurement
from ksmea.misfit import Misfit
from ksmea.model import Model, model_objective
from ksmea.nearest_maximum import nearest_maximum

FINAL_STEP = "final step"  # the stage's name


def most_likely(model: Model, measurement: Measurement, start: Array) -> tuple[Array, float] | None:
    """The maximum (d,) nearest to a point of the unit cube and its deviance, with the noise estimated along where its
    level is not known; None where the model's budget does not admit a step.

    Without noise there is no likelihood: least squares then, and their misfit.
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
