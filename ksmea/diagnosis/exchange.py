"""Exchange of the unknowns of the baseline model among trials.

Data with many maxima leave no trial in a worse one than its neighbour.

Each trial is fitted further from where the best others have these unknowns, and at first also from a screening by variable projection,
until none of the best becomes better.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from ksmea.diagnosis.trials import BETTER, FAR, Trial, best_by_name, ranked, shared, trial_of
from ksmea.fits.fitting import (
    BaselineFits,
    Fit,
    finished,
    fit_from,
    fit_from_points,
    maxima_from,
    start_nearby,
    without_effects,
)
from ksmea.fits.linear_start import solved_start
from ksmea.fits.path_fits import projected_starts
from ksmea.fits.search import Effort, Search
from ksmea.fits.stable_fits import better_stable

MAX_EXCHANGES = 3
EXCHANGED = 6  # effects whose unknowns the fits of all others start from


def exchanged(trials: Sequence[Trial], baseline: BaselineFits, search: Search) -> list[Trial]:
    """Trials fitted from the unknowns of the best other ones, until none of the best improves."""
    found, tried = list(trials), dict[tuple[str, str], float]()
    for number in range(MAX_EXCHANGES):
        leads = list(best_by_name(found).values())[:EXCHANGED]
        better = [lead for lead in leads if lead.fit.deviance < tried.get(_key(lead), np.inf) - BETTER]
        if not better:
            break
        tried |= {_key(lead): lead.fit.deviance for lead in better}
        found = exchanged_once(found, better, baseline, search, is_first=number == 0)
    return found


def _key(trial: Trial) -> tuple[str, str]:
    return trial.name, trial.location


def exchanged_once(
    trials: Sequence[Trial], leads: Sequence[Trial], baseline: BaselineFits, search: Search, is_first: bool = True
) -> list[Trial]:
    """Refit each trial from the unknowns of the leads, and keep its best fit.

    In a first exchange, leads are also fitted from a screening by variable projection, unless their response may
    jump. A fit that cannot come within `FAR` of the best one is stopped early. A trial whose response may jump is
    refitted only if it is a rival."""
    starts = [trial.fit for trial in leads]
    ceiling = min(trial.fit.deviance for trial in trials) + FAR

    def again(trial: Trial) -> Trial:
        jumps = trial.fit.problem.parameters.makes_jumps
        if jumps and trial.fit.deviance > ceiling:
            return trial
        fit, without = finished(trial.fit, ceiling), baseline.best
        with suppress(np.linalg.LinAlgError):  # within its limits an effect may leave the rotor no steady motion
            other = fit_from(fit, starts, baseline, search.effort, below=ceiling)
            further = _by_projection(fit, without, search.effort) if is_first and trial in leads and not jumps else []
            fit = better_stable(fit, other, start_nearby(fit.problem, without))
            fit = min([fit, *further], key=lambda each: each.deviance)
        return trial_of(trial.candidate, fit, without, len(trials))

    return ranked(shared(again, trials, search.workers))


def lifted(trials: Sequence[Trial], baseline: BaselineFits, search: Search) -> list[Trial]:
    """Trials fitted from the unknowns of the best one, with all vectors solved for, if that is better.

    Unbalance and the trial's own effect have vectors.

    Bows, runouts and forces that turn with the shaft enter linearly. Between a fit without them and the best one lie others
    that no search by magnitudes and angles leaves: a scan finds the best fit of one, and a worse one of its rival. Each is
    fitted to its end: stopped far above the best one, true effects stayed there.
    """
    lead, d = min((trial.fit for trial in trials), key=lambda fit: fit.deviance), len(baseline.best.u)

    def again(trial: Trial) -> Trial:
        fit, case = trial.fit, trial.fit.case
        if fit.problem.parameters.makes_jumps:
            return trial
        start = np.concatenate([lead.u[:d], without_effects(fit.problem, d)])
        with suppress(np.linalg.LinAlgError):  # within its limits an effect may leave the rotor no steady motion
            if (solved := solved_start(case, start, d, lead.noise)) is not start:
                other = fit_from_points(case, solved[None], search.effort, np.inf, fit.deviance - BETTER)
                fit = better_stable(fit, other, start_nearby(fit.problem, baseline.best))
        return trial_of(trial.candidate, fit, baseline.best, len(trials))

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
