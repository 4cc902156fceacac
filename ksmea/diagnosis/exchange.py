"""Exchange of the unknowns of the baseline model among trials: data with many maxima leave no trial in a worse one than its neighbour.

Each trial is fitted further from where the best others have these unknowns, and at first also from a screening by variable projection,
until none of the best becomes better.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from ksmea.diagnosis.trials import BETTER, FAR, Trial, best_by_name, ranked, shared, trial_of
from ksmea.fits.fitting import BaselineFits, Fit, finished, fit_from, maxima_from, start_nearby
from ksmea.fits.path_fits import projected_starts
from ksmea.fits.search import Effort, Search
from ksmea.fits.stable_fits import stable_fit

MAX_EXCHANGES = 3
EXCHANGED = 6  # effects whose unknowns the fits of all others start from


def exchanged(trials: Sequence[Trial], baseline: BaselineFits, search: Search) -> list[Trial]:
    """The trials, each fitted from the unknowns of the best other ones, until that improves none of the best."""
    found = list(trials)
    for number in range(MAX_EXCHANGES):
        drops = {(trial.name, trial.location): trial.deviance_drop for trial in found}
        found = exchanged_once(found, baseline, search, is_first=number == 0)
        if all(trial.deviance_drop < drops[trial.name, trial.location] + BETTER for trial in found[:EXCHANGED]):
            break
    return found


def exchanged_once(
    trials: Sequence[Trial], baseline: BaselineFits, search: Search, is_first: bool = True
) -> list[Trial]:
    """The trials, each with the better of its fit and further ones to the end, from the unknowns that the best `EXCHANGED` effects
    have, and in a first exchange those of these effects from a screening by variable projection. A trial whose response may jump only if it is a rival."""
    leads = list(best_by_name(trials).values())[:EXCHANGED]
    starts = [trial.fit for trial in leads]
    ceiling = min(trial.fit.deviance for trial in trials) + FAR

    def again(trial: Trial) -> Trial:
        jumps = trial.fit.problem.parameters.makes_jumps
        if jumps and trial.fit.deviance > ceiling:
            return trial
        fit, without = finished(trial.fit), baseline.best
        with suppress(np.linalg.LinAlgError):  # within its limits an effect may leave the rotor no steady motion
            other = stable_fit(fit_from(fit, starts, baseline, search.effort), start_nearby(fit.problem, without))
            further = _by_projection(fit, without, search.effort) if is_first and trial in leads and not jumps else []
            fit = min(fit, other, *further, key=lambda each: each.deviance)
        return trial_of(trial.candidate, fit, without, len(trials))

    return ranked(shared(again, trials, search.workers))


def _by_projection(fit: Fit, without: Fit, effort: Effort) -> list[Fit]:
    """The best fit from a screening by variable projection, if its rotor is stable."""
    d = without.likelihood.d
    points = projected_starts(fit.case, without.noise, d, effort)
    if not len(points):
        return []
    effort = dataclasses.replace(effort, survivors=len(points))
    best = Fit(fit.likelihood, maxima_from(fit.likelihood, [fit.likelihood.start(u) for u in points], effort)[0])
    return [best] if best.problem.is_stable(best.x) else []
