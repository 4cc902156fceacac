"""Kin of the best effect: its wider forms, and its own forms fitted again from their values.

A wider form is a bow in two shapes.

Forms of one effect share a name and may fit about as well with other values of the unknowns: then they are further explanations by
that name, and the average over them says how far the form decides the values. All are fitted from the unknowns of the best form so
far with unbalance and its own sizes solved for (`ksmea/fits/linear_start.py`); a form whose fit was left in a lower maximum is lifted out of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import partial

import numpy as np

from ksmea.diagnosis.trials import BETTER, Candidate, Trial, ranked, trial_of
from ksmea.fits.fitting import Fit, fit_from_values, start_nearby, without_effects
from ksmea.fits.linear_start import solved_start
from ksmea.fits.search import Search
from ksmea.fits.stable_fits import stable_fit


def with_kin(trials: Sequence[Trial], level: float, baseline: Fit, search: Search) -> list[Trial]:
    """Trials with the wider forms of the best effect, highest ΔBIC first.

    The trials are unchanged if none is significant at a level, or if the best effect has no wider form."""
    lead = next((trial for trial in trials if trial.p < level and trial.delta_bic > 0), None)
    if lead is None:
        return list(trials)
    forms = [trial for trial in trials if trial.name == lead.name]
    known = {str(trial.candidate.effect) for trial in forms}
    kin = [each for each in lead.candidate.effect.kin(baseline.problem.machine) if str(each) not in known]
    if not kin:
        return list(trials)
    n_candidate = len(trials) + len(kin)

    def fitted_from(values: Fit, candidate: Candidate) -> Trial | None:
        fit = _from_values(values, candidate, baseline)
        return None if fit is None else trial_of(candidate, fit, baseline, n_candidate)

    wider = [Candidate(lead.name, each) for each in kin]
    found = [each for each in search.workers.each(partial(fitted_from, lead.fit), wider, wider) if each is not None]
    best = min([lead, *found], key=lambda trial: trial.fit.deviance)
    own = [trial.candidate for trial in forms]
    again = search.workers.each(partial(fitted_from, best.fit), own, own)
    lifted = [_better(trial, other) for trial, other in zip(forms, again, strict=True)]
    return ranked([*(trial for trial in trials if trial.name != lead.name), *lifted, *found])


def _from_values(known: Fit, candidate: Candidate, baseline: Fit) -> Fit | None:
    """A candidate fitted from the values that a fit has of the baseline model's unknowns.

    None if no steady motion is found.
    """
    if (problem := candidate.beside(baseline.problem)) is None:
        return None
    with suppress(np.linalg.LinAlgError):
        case, d = baseline.case.by(problem), len(baseline.u)
        start = np.concatenate([known.u[:d], without_effects(problem, d)])
        fit = fit_from_values(case, problem.parameters.to_si(solved_start(case, start, d, known.noise)))
        return stable_fit(fit, start_nearby(problem, baseline))
    return None


def _better(trial: Trial, other: Trial | None) -> Trial:
    return trial if other is None or other.fit.deviance > trial.fit.deviance - BETTER else other
