"""One effect in place of another: along the valley of models that have parts of both and predict about the same.

Where resonances are sharp, the fit of an effect that explains the data as well as the best one does may be far from any start: from
values without an effect, or those of the best one's fit, resonances would have to cross those of the data. On the way from one
effect to the other they stay. So the best effect is taken back step by step in a model that has both. Each step goes along the
tangent on which predictions hold still as far as the model is linear (Euler–Newton continuation: Allgower & Georg,
Introduction to Numerical Continuation Methods, 2003, ch. 2, doi 10.1137/1.9780898719154), and a few steps of a fit follow.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array, Indices
from ksmea.diagnosis.fitting import PATH_ITERATIONS, without_effects
from ksmea.diagnosis.trials import FAR, Trial
from ksmea.difference_likelihood import likelihood_of
from ksmea.maximisation import maximise
from ksmea.model import Model
from ksmea.point import Point

N_STEP = 16  # in which an effect is taken back
TOLERANCE = 1e-2  # of the deviance, at which the fit of a step ends


def in_place_of(lead: Trial, trial: Trial, d: int) -> Array | None:
    """Where in the unit cube a trial's effect explains what the lead's does; the model without effects has d unknowns. None where no
    valley leads there: the deviance rises far above the lead's, or the two cannot act together."""
    measurement, both = lead.fit.likelihood.measurement, trial.candidate.beside(lead.fit.problem)
    if both is None or both.parameters.makes_jumps:
        return None
    likelihood = likelihood_of(Model(both), measurement)
    taken_back = np.arange(d, len(lead.fit.u))
    none = without_effects(both, d)
    start = np.concatenate([lead.fit.u, none[len(taken_back) :], lead.fit.point.theta[len(lead.fit.u) :]])
    try:
        point = likelihood.at(np.clip(start, likelihood.lower, likelihood.upper))
        for left in np.linspace(1, 0, N_STEP + 1)[1:]:
            towards = none[: len(taken_back)] + left * (start[taken_back] - none[: len(taken_back)])
            theta = np.clip(_on_tangent(point, taken_back, towards), likelihood.lower, likelihood.upper)
            point = maximise(likelihood, theta, fixed=taken_back, max_iterations=PATH_ITERATIONS, tolerance=TOLERANCE)
            if point.deviance > lead.fit.deviance + FAR:
                return None
    except np.linalg.LinAlgError:  # no steady motion on the way
        return None
    return np.delete(point.theta[: likelihood.d], taken_back)


def _on_tangent(point: Point, moved: Indices, towards: Array) -> Array:
    """θ (p,) with some unknowns moved to values, and the others such that predictions change least."""
    others = np.setdiff1d(np.arange(len(point.theta)), moved)
    scale = np.maximum(np.linalg.norm(point.triangle, axis=0), np.finfo(float).tiny)
    change = point.triangle[:, moved] @ (towards - point.theta[moved])
    theta = point.theta.copy()
    theta[moved] = towards
    theta[others] -= np.linalg.lstsq(point.triangle[:, others] / scale[others], change)[0] / scale[others]
    return theta
