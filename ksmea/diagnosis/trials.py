"""Trials: one effect at one place, fitted jointly with all unknowns, and what that is worth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from ksmea.contracts import Effect, Problem
from ksmea.diagnosis.fitting import BaselineFits, Effort, Fit, fit_from, fit_from_scan, fit_nearby
from ksmea.measurement import Measurement


@dataclass(frozen=True)
class Candidate:
    """A registered effect at one place."""

    name: str
    effect: Effect


@dataclass(frozen=True)
class Trial:
    """A candidate's fit against that of the model without it.

    `p` is the chance of a deviance that falls as far where there is nothing, corrected for the number of candidates
    that were tried; `delta_bic` > 0 speaks for the effect.
    """

    candidate: Candidate
    fit: Fit
    fall: float  # of the deviance
    delta_bic: float
    p: float

    @property
    def name(self) -> str:
        return self.candidate.name

    @property
    def place(self) -> str:
        return str(self.candidate.effect)

    @property
    def n_unknown(self) -> int:
        """Unknowns that the effect brought along, the last of the fit's."""
        return len(self.candidate.effect.parameters(self.fit.problem))


def candidates(problem: Problem, effects: Mapping[str, Effect]) -> list[Candidate]:
    """Every effect at every place of the problem where it may sit, but for those that the problem has already."""
    known = set(problem.parameters.names)
    return [
        Candidate(name, place)
        for name, effect in effects.items()
        for place in effect.places(problem)
        if known.isdisjoint(parameter.name for parameter in place.parameters(problem))
    ]


def trial_of(candidate: Candidate, fit: Fit, without: Fit, n_candidate: int) -> Trial:
    """What a fit with one more effect is worth against one without."""
    n = fit.likelihood.n_residual
    e = fit.likelihood.d - without.likelihood.d
    fall = max(without.deviance - fit.deviance, 0.0)
    # The noise is estimated along: the fall is n ln(1 + e F/(n − d)) in a linear model, about χ² when scaled by (n − d)/n
    scaled = fall * (n - fit.likelihood.d) / n if fit.likelihood.noise_is_estimated else fall
    p = min(1.0, n_candidate * float(chi2.sf(scaled, e)))
    return Trial(candidate, fit, fall, fall - e * np.log(n), p)


def tried(
    problem: Problem,
    measurement: Measurement,
    without: Fit,
    found: Sequence[Candidate],
    progress: Callable[[], None],
    n_tried: int | None = None,
) -> list[Trial]:
    """All candidates, each fitted from where the model without it fits; most promising first. `n_tried` is the number
    that p is corrected for, that of the candidates if not given."""
    trials = []
    for candidate in found:
        fit = fit_nearby(candidate.effect.added_to(problem), measurement, without)
        trials.append(trial_of(candidate, fit, without, n_tried or len(found)))
        progress()
    return ranked(trials)


def searched(
    trials: Sequence[Trial], measurement: Measurement, plain: BaselineFits, effort: Effort, progress: Callable[[], None]
) -> list[Trial]:
    """The same trials, each with the better of its fit and a search: all over the effect's bounds where it needs that,
    and else from where the plain model's other maxima and the best trials have their unknowns."""
    better = []
    starts = [*plain.others, *(trial.fit for trial in trials[:2])]
    for trial in trials:
        if trial.candidate.effect.is_scanned:
            fit = fit_from_scan(trial.fit.problem, measurement, plain, effort)
        else:
            fit = fit_from(trial.fit.problem, measurement, starts, plain.best.likelihood.d)
        best = min(fit, trial.fit, key=lambda each: each.deviance)
        better.append(trial_of(trial.candidate, best, plain.best, len(trials)))
        progress()
    return ranked(better)


def ranked(trials: Iterable[Trial]) -> list[Trial]:
    return sorted(trials, key=lambda trial: -trial.delta_bic)


def best_by_name(trials: Sequence[Trial]) -> dict[str, Trial]:
    """The best place of each effect, most promising first."""
    best: dict[str, Trial] = {}
    for trial in ranked(trials):
        best.setdefault(trial.name, trial)
    return best
