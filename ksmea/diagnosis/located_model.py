"""The model with a law that was located as part of it, fitted by its likelihood.

A location compares laws beside a free force, with weights of its own; here the law is an effect like any other, and noise
and unknowns are those of the likelihood. It is fitted from where the free force leaves the unknowns, and from where the plain
model has them: an unknown that acts at the very site shows in the data only once the force follows a law.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ksmea.contracts import Problem
from ksmea.diagnosis.fitting import Fit, fit_from_values, start_nearby
from ksmea.diagnosis.force_law import LawFit
from ksmea.diagnosis.stable_fits import stable_fit
from ksmea.diagnosis.unknown_force import SiteFit


def located_fit(extended: Problem, law: LawFit, plain: SiteFit, before: Fit) -> Fit:
    """A problem whose last unknowns are the coefficients of a fitted law, fitted; `before` is the fit without them.

    Raises LinAlgError where no start has a steady motion under the law."""
    measurement = plain.likelihood.measurement
    found = []
    for fit in (law.site, plain):
        x = np.concatenate([before.problem.parameters.to_si(fit.point.theta), law.values])
        with suppress(np.linalg.LinAlgError):
            found.append(fit_from_values(extended, x, measurement))
    if not found:
        raise np.linalg.LinAlgError("no steady motion was found where the law was fitted")
    return stable_fit(min(found, key=lambda fit: fit.deviance), start_nearby(extended, before))
