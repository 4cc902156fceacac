"""The model with a law that was located as part of it: fitted by its likelihood, and worth what it predicts of left-out data.

A location compares laws beside a free force, with weights of its own; here the law is an effect like any other, and noise
and unknowns are those of the likelihood. It is fitted from where the free force leaves the unknowns, and from where the plain
model has them: an unknown that acts at the very site shows in the data only once the force follows a law.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ksmea.contracts import Problem
from ksmea.diagnosis.fitting import Fit, fit_from_values, start_nearby
from ksmea.diagnosis.force_law import LawFit
from ksmea.diagnosis.predictive_gain import PredictiveGain, predictive_gain
from ksmea.diagnosis.stable_fits import stable_fit
from ksmea.diagnosis.unknown_force import SiteFit


def located_model(
    extended: Problem, law: LawFit, plain: SiteFit, n_block: int, progress: Callable[[], None] = lambda: None
) -> tuple[Fit, PredictiveGain]:
    """A problem whose last unknowns are the coefficients of a fitted law, fitted, and its predictive gain over the model
    without them, by `n_block` blocks of speeds."""
    problem, measurement = plain.likelihood.problem, plain.likelihood.measurement
    before = fit_from_values(problem, problem.parameters.to_si(plain.point.theta), measurement)
    starts = (problem.parameters.to_si(fit.point.theta) for fit in (law.site, plain))
    fits = [fit_from_values(extended, np.concatenate([own, law.values]), measurement) for own in starts]
    best = stable_fit(min(fits, key=lambda fit: fit.deviance), start_nearby(extended, before))
    return best, predictive_gain(before, best, n_block, progress)
