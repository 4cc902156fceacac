"""Rivals: effects that explain the data about as well as the best one, and how collinear all others are with it.

Sensitivities say what the best fit of a collinear effect must reach: a deviance drop of cos² times that of the best. That
holds as far as the model is linear, which it is not where sharp resonances move. So a promise is put to the test: the effect
is fitted to what the best one predicts, which leads it to where it comes nearest, and from there to the data. What that fit
reaches counts.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from ksmea.arrays import Array
from ksmea.diagnosis.exchange import in_place_of
from ksmea.diagnosis.explanations import NEAR, Explanation
from ksmea.diagnosis.fitting import Fit, start_nearby, without_effects
from ksmea.diagnosis.observability import collinearity
from ksmea.diagnosis.stable_fits import stable_fit
from ksmea.diagnosis.trials import Trial, ranked, shared_searches, trial_of
from ksmea.likelihood import Likelihood
from ksmea.maximisation import maximise
from ksmea.model import Model
from ksmea.processes import for_each

EXPECTED_GAIN = 0.1  # of the deviance, below which a fit to a prediction is at its end
MAX_ITERATIONS = 50  # of such a fit


Cosines = Mapping[tuple[str, str], float]  # by effect and location


def cosines_with(lead: Trial, trials: Sequence[Trial], workers: int = 1) -> Cosines:
    """Collinearity of all candidates of other effects with the best one, by sensitivities; processes share them."""
    others = [trial for trial in trials if trial.name != lead.name]
    found = for_each(partial(collinearity, lead), [trial.candidate for trial in others], workers)
    return {(trial.name, trial.location): cosine for trial, cosine in zip(others, found)}


def collinearities(lead: Trial, trials: Sequence[Trial], cosines: Cosines) -> dict[str, float]:
    """Collinearity of the other effects with the best one, each at its most collinear location."""
    found: dict[str, float] = {}
    for trial in trials:
        if trial.name != lead.name:
            found[trial.name] = max(found.get(trial.name, 0.0), _collinearity(lead, trial, cosines))
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def tested(
    lead: Trial,
    trials: Sequence[Trial],
    cosines: Cosines,
    baseline: Fit,
    progress: Callable[[], None],
    workers: int = 1,
) -> list[Trial]:
    """The trials, those again whose collinearity with the best one promises a better fit than they have, highest ΔBIC
    first. `progress` is called at each trial; processes share them."""

    def again(trial: Trial) -> Trial:
        return _led(trial, lead, baseline, len(trials)) if _promises(trial, lead, cosines) else trial

    return ranked(shared_searches(again, trials, workers, progress))


def _promises(trial: Trial, lead: Trial, cosines: Cosines) -> bool:
    if trial.name == lead.name or Explanation.of(trial).is_near(Explanation.of(lead)):
        return False
    charge = (trial.n_unknown - lead.n_unknown) * np.log(lead.fit.likelihood.n_residual)
    return bool(lead.deviance_drop * (1 - _collinearity(lead, trial, cosines) ** 2) + charge < NEAR)


def _collinearity(lead: Trial, trial: Trial, cosines: Cosines) -> float:
    """By sensitivities, or where an effect is curved by what its fit has reached, since its deviance drop is cos² of that of
    the best."""
    reached = np.sqrt(min(trial.deviance_drop / lead.deviance_drop, 1.0))
    return float(max(reached, cosines[trial.name, trial.location]))


def _led(trial: Trial, lead: Trial, baseline: Fit, n_candidate: int) -> Trial:
    """A trial with the better of its fit and further ones: from where the valley leads in which the best effect is exchanged for it,
    and if that does not come near from where its effect comes nearest to what the best one predicts."""
    problem, likelihood, d = trial.fit.problem, trial.fit.likelihood, baseline.likelihood.d

    def tried(fits: Sequence[Fit]) -> Trial:
        return trial_of(trial.candidate, min(fits, key=lambda each: each.deviance), baseline, n_candidate)

    def fit_from(u: Array) -> Fit:
        fit = Fit(problem, likelihood, maximise(likelihood, likelihood.start(u), tolerance=1e-4))
        return stable_fit(fit, start_nearby(problem, baseline))

    fits = [trial.fit]
    if (start := in_place_of(lead, trial, d)) is not None:
        fits.append(fit_from(start))
        exchanged = tried(fits)
        if Explanation.of(exchanged).is_near(Explanation.of(lead)):
            return exchanged
    measurement = likelihood.measurement
    predicted = dataclasses.replace(measurement, values=measurement.seen(lead.fit.response()), noise=lead.fit.noise)
    to_predicted = Likelihood(Model(problem), predicted)
    for start in (
        np.concatenate([lead.fit.u[:d], without_effects(problem, d)]),
        min(fits, key=lambda fit: fit.deviance).u,
    ):
        nearest = maximise(to_predicted, start, max_iterations=MAX_ITERATIONS, tolerance=EXPECTED_GAIN)
        fits.append(fit_from(nearest.theta))
    return tried(fits)
