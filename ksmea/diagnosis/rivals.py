"""Rivals: effects that fit about as well as the best one, or pair, and their collinearity with it.

Sensitivities predict the deviance drop of a collinear effect: cos² times the drop of the best one. The prediction holds as far as the
model is linear, which it is not if sharp resonances move. Therefore each rival is fitted first to the predictions of the best
effect, which leads it to its nearest point, and from there to the data. The drop of that fit counts.

The best effect is also exchanged for its rivals. If resonances are sharp, the fit of a rival may be far from any start: on the
way from values without an effect, or from the best fit, resonances would have to cross the measured ones. Along the
valley between the two effects they stay. So the best effect is taken back step by step in a model that has both. Each step goes
along the tangent on which predictions do not change to first order (Euler–Newton continuation: Allgower & Georg, Introduction to
Numerical Continuation Methods, 2003, ch. 2, doi 10.1137/1.9780898719154), and a few iterations of a fit follow.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from ksmea.arrays import Array, Indices
from ksmea.diagnosis.observability import Led, change_of, cosine, reach
from ksmea.diagnosis.trials import FAR, NEAR, Explanation, Trial, ranked, shared, trial_of
from ksmea.fits.fitting import Fit, start_nearby, without_effects
from ksmea.fits.path_fits import PATH_ITERATIONS
from ksmea.fits.stable_fits import stable_fit
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.difference_likelihood import likelihood_of
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.likelihood import Likelihood
from ksmea.numerics.parallel import ALONE, Workers
from ksmea.problem.counted import Model

EXPECTED_GAIN = 0.1  # of the deviance, below which a fit to a prediction is at its end
MAX_ITERATIONS = 50  # of such a fit


Cosines = Mapping[tuple[str, str], float]  # by effect and location


def cosines_with(lead: Explanation, trials: Sequence[Trial], workers: Workers = ALONE) -> Cosines:
    """Collinearity of all other candidates with the best explanation, by sensitivities.

    Processes share them.
    """
    others = _others(lead, trials)
    reached = workers.unseen.each(partial(reach, lead), [trial.candidate for trial in others])
    change = change_of(lead)
    return {
        (trial.name, trial.location): 0.0 if each is None else cosine(change, each)
        for trial, each in zip(others, reached)
    }


def _others(lead: Explanation, trials: Sequence[Trial]) -> list[Trial]:
    """Trials of other effects than a single one; of a pair also its effects at other places."""
    if len(lead.applied) == 1:
        return [trial for trial in trials if trial.name not in lead.names]
    return [trial for trial in trials if trial.candidate not in lead.applied]


def collinearities(lead: Explanation, trials: Sequence[Trial], cosines: Cosines) -> dict[str, float]:
    """Collinearity of the other effects with the best one, each at its most collinear location."""
    found: dict[str, float] = {}
    for trial in _others(lead, trials):
        found[trial.name] = max(found.get(trial.name, 0.0), _collinearity(lead, trial, cosines))
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def tested(
    lead: Explanation, trials: Sequence[Trial], cosines: Cosines, baseline: Fit, workers: Workers = ALONE
) -> list[Trial]:
    """Trials, with new fits of those whose collinearity with the best one predicts better.

    They are in order of ΔBIC, highest first. Processes share them.
    """

    def again(trial: Trial) -> Trial:
        is_promising = (trial.name, trial.location) in cosines and _promises(trial, lead, cosines)
        return _led(trial, lead, baseline, len(trials)) if is_promising else trial

    return ranked(shared(again, trials, workers))


def _promises(trial: Trial, lead: Explanation, cosines: Cosines) -> bool:
    return not Explanation.of(trial).is_near(lead) and promises(
        lead, _collinearity(lead, trial, cosines), trial.n_unknown
    )


def promises(lead: Explanation, collinearity: float, n_unknown: int) -> bool:
    """Whether effects of a collinearity and so many unknowns are to come near an explanation."""
    charge = (n_unknown - lead.n_unknown) * np.log(lead.fit.likelihood.n_residual)
    return bool(lead.deviance_drop * (1 - collinearity**2) + charge < NEAR)


def _collinearity(lead: Explanation, trial: Trial, cosines: Cosines) -> float:
    """Collinearity by sensitivities, or for a curved effect by its fit.

    Its deviance drop is cos² of the best one's.
    """
    reached = np.sqrt(min(trial.deviance_drop / lead.deviance_drop, 1.0))
    return float(max(reached, cosines[trial.name, trial.location]))


def _led(trial: Trial, lead: Explanation, baseline: Fit, n_candidate: int) -> Trial:
    """A trial with the better of its fit and further ones.

    Further fits start from the end of the valley in which the best explanation is exchanged for it, and, if that is not
    near, from the point at which its effect comes nearest to the prediction of the best one.
    """
    d = baseline.likelihood.d

    def tried(fits: Sequence[Fit]) -> Trial:
        return trial_of(trial.candidate, min(fits, key=lambda each: each.deviance), baseline, n_candidate)

    fits = [trial.fit]
    if (start := in_place_of(lead, trial, d)) is not None:
        fits.append(_fit_from(start, trial.fit, baseline))
        exchanged = tried(fits)
        if Explanation.of(exchanged).is_near(lead):
            return exchanged
    return tried([*fits, *fits_towards(lead, min(fits, key=lambda fit: fit.deviance), baseline)])


def _fit_from(u: Array, fit: Fit, baseline: Fit) -> Fit:
    """The fit of a problem from values u (d,) in the unit cube."""
    found = Fit(fit.likelihood, maximise(fit.likelihood, fit.likelihood.start(u), tolerance=1e-4))
    return stable_fit(found, start_nearby(fit.problem, baseline))


def fits_towards(lead: Explanation, fit: Fit, baseline: Fit) -> list[Fit]:
    """Fits of a problem from its point nearest to the prediction of an explanation.

    That point is sought from the unknowns of the explanation without any effect, and from a fit.
    """
    problem, measurement, d = fit.problem, fit.likelihood.measurement, baseline.likelihood.d
    predicted = dataclasses.replace(measurement, values=measurement.seen(lead.fit.response()), noise=lead.fit.noise)
    to_predicted = Likelihood(Model(problem), predicted)
    found = []
    for start in (np.concatenate([lead.fit.u[:d], without_effects(problem, d)]), fit.u):
        nearest = maximise(to_predicted, start, max_iterations=MAX_ITERATIONS, tolerance=EXPECTED_GAIN)
        found.append(_fit_from(nearest.theta, fit, baseline))
    return found


N_STEP = 16  # in which an effect is taken back
TOLERANCE = 1e-2  # of the deviance, at which the fit of a step ends


def in_place_of(lead: Led, trial: Trial, d: int) -> Array | None:
    """Point of the unit cube at which a trial's effect has the influence of the lead's effect.

    The model without effects has d unknowns. None where no valley leads there: the deviance rises far above the lead's,
    or the two cannot act together.
    """
    both = trial.candidate.beside(lead.fit.problem)
    if both is None or both.parameters.makes_jumps:
        return None
    likelihood = likelihood_of(lead.fit.case.by(both))
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
