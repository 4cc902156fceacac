"""Second effects: pairs of effects for data that one effect does not explain.

A second effect is added to a first one at every place but the first one's own, so that one effect may act at two places.
The cost is bounded, so that an unsuccessful search ends:

1. Every pair is fitted for a few iterations from the fit of its first effect. If the residuals of that fit are noise, the pair is
   fitted to convergence, and left out unless the deviance falls by more than ln n, the BIC penalty of one unknown: with a smaller
   drop it could not come near a pair that BIC prefers to the first effect.
2. The best `Effort.pairs` of them are fitted to convergence, equally many for each first effect.
3. If the residuals of the first effect are more than noise, as many of the best pairs are scanned, provided that their second effect
   is scanned as a first one: its values all over their limits, the first effect as fitted. A first effect with only noise in its
   residuals hides no second effect so large that only a scan would find it: a small one is near 0, where fits start.
4. A fit from a scan that is far worse than the one from nearby after a few iterations is not continued.
5. With a first effect that is not linear in the motion, only the few pairs with the largest deviance drop predicted by their first
   step are fitted, and no pair is scanned: a scan of one took minutes.
6. First effects that predict the same data count as one. `alternatives` tries the others in their place, in addition to the best pair.

p of a second effect is corrected for the number of all pairs that were tried.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from ksmea.diagnosis.trials import (
    BETTER,
    NEAR,
    Candidate,
    Explanation,
    Trial,
    best_by_name,
    fitted,
    ranked,
    ranked_explanations,
    searched,
    shared,
    trial_of,
)
from ksmea.fits.fitting import TRIAL_ITERATIONS, BaselineFits, Fit, finished, fit_from_values
from ksmea.fits.search import Effort, Search
from ksmea.fits.starts import screened
from ksmea.location.location import Location

PER_SCANNED = 4  # points that are screened with the first effect for each that is scanned
COSTLY = 4  # second effects, by predicted deviance drop, with a first one that is not linear in the motion
PROMISING = 25.0  # deviance by which a pair may exceed the best after a few iterations, to be fitted to convergence


def pairs_beside(
    firsts: Sequence[Trial],
    trials: Sequence[Trial],
    baseline: BaselineFits,
    search: Search,
    *,
    is_scanned: bool,
) -> list[Explanation]:
    """Pairs of one of the first effects and any other candidate, highest ΔBIC first.

    With `is_scanned` second effects are scanned. Without, the residuals of the first effects are noise, and pairs whose
    deviance falls by less than ln n are omitted.
    """
    n_candidate, n_kept = len(firsts) * (len(trials) - 1), max(1, search.effort.pairs // max(len(firsts), 1))
    found = []
    for first in firsts:
        others = [trial.candidate for trial in trials if trial.candidate != first.candidate]
        limit = np.inf if is_scanned else first.fit.deviance - np.log(first.fit.likelihood.n_residual)
        quick = _quick(first, others, search, n_candidate, limit)
        can_scan = is_scanned and not _is_costly(first)
        to_scan = [second for second in quick if can_scan and second.candidate.effect.is_scanned][:n_kept]
        scans = _scans(first, to_scan, baseline, search, n_candidate) if to_scan else []
        ended = partial(_ended, first, n_candidate)
        seconds = shared(ended, (*quick[:n_kept], *scans), search.workers.unseen)
        found += [(first, second) for second in seconds]
    return ranked_explanations(Explanation.of_pair(*pair) for pair in found)


def distinct_firsts(significant: Sequence[Trial], count: int) -> list[Trial]:
    """The best effects, each at its best location, whose predictions differ.

    Effects with the same predictions leave the same residuals to a second one.
    """
    found: list[Trial] = []
    for trial in best_by_name(significant).values():
        if len(found) < count and all(_differ(trial.fit, other.fit) for other in found):
            found.append(trial)
    return found


def _differ(fit: Fit, other: Fit) -> bool:
    likelihood = other.likelihood
    difference = likelihood.whitened_difference(fit.response(), other.response(), other.point.theta)
    return float(np.sum(difference**2)) > NEAR


def alternatives(best: Explanation, firsts: Sequence[Trial], search: Search, n_candidate: int) -> list[Explanation]:
    """Pairs that come near the best one with another effect in place of one of its two.

    The other one is fitted together with each of the first effects. `n_candidate` is the number of all pairs that p is
    corrected for.
    """
    found = []
    for first in firsts:
        kept = [candidate for candidate in best.applied if candidate != first.candidate]
        for second in _quick(first, kept, search, n_candidate):
            if second.fit.deviance < best.fit.deviance + PROMISING:
                found.append(Explanation.of_pair(first, _ended(first, n_candidate, second)))
    return found


def _quick(
    first: Trial, candidates: Sequence[Candidate], search: Search, n_candidate: int, limit: float = np.inf
) -> list[Trial]:
    """Second effects added to a first one, fitted for a few iterations.

    If a limit of the deviance is given, up to TRIAL_ITERATIONS iterations are made, and only effects that come below
    the limit are kept.
    """
    return fitted(
        first.fit,
        candidates,
        search,
        n_candidate=n_candidate,
        max_iterations=search.effort.first_iterations if np.isinf(limit) else TRIAL_ITERATIONS,
        limit=limit,
        most=COSTLY if _is_costly(first) else None,
    )


def _is_costly(first: Trial) -> bool:
    """Whether a first effect is not linear in the motion: with it a response takes a tenth of a second."""
    return first.fit.problem.parameters.makes_jumps


def _scans(
    first: Trial, to_scan: Sequence[Trial], baseline: BaselineFits, search: Search, n_candidate: int
) -> list[Trial]:
    around = _around(first.fit, baseline, search.effort)

    def scanned(second: Trial) -> Trial:
        ceiling = second.fit.deviance + PROMISING
        return searched(second, around, search.effort, n_candidate, ceiling=ceiling)

    return shared(scanned, to_scan, search.workers)


def _ended(first: Trial, n_candidate: int, second: Trial) -> Trial:
    """A second effect's trial, with its fit continued to convergence."""
    return trial_of(second.candidate, finished(second.fit), first.fit, n_candidate)


def _around(first: Fit, baseline: BaselineFits, effort: Effort) -> BaselineFits:
    """Fit of a first effect, and the baseline model's screened points with that effect as fitted."""
    points = baseline.screened.thinned(PER_SCANNED * effort.scan)
    with_effect = np.hstack([points, np.tile(first.u[points.shape[1] :], (len(points), 1))])
    return BaselineFits(first, (), screened(first.case, np.vstack([first.u, with_effect])))


def each_alone(best: Explanation, trials: Sequence[Trial], baseline: Fit) -> list[Trial]:
    """All trials ranked again, if an effect of a pair fits better alone from the values of the pair.

    Otherwise empty. Any second effect lifts a first one out of a lower maximum in which it stayed, which is not
    evidence for the second one.
    """
    if len(best.applied) < 2:
        return []
    better = [_from_pair(trial, best, baseline, len(trials)) for trial in trials if trial.candidate in best.applied]
    lifted = [trial for trial in better if trial is not None]
    if not lifted:
        return []
    anew = [trial.candidate for trial in lifted]
    return ranked([*lifted, *(trial for trial in trials if trial.candidate not in anew)])


def _from_pair(trial: Trial, best: Explanation, baseline: Fit, n_candidate: int) -> Trial | None:
    """A trial fitted from the values of a pair; None unless that fit is better and stable."""
    problem, d = trial.fit.problem, len(baseline.u)
    ends = np.cumsum([d, *(len(each.effect.parameters(baseline.problem.machine)) for each in best.applied)])
    place = best.applied.index(trial.candidate)
    x = np.append(best.fit.x[:d], best.fit.x[ends[place] : ends[place + 1]])
    fit = fit_from_values(baseline.case.by(problem), x)
    if fit.deviance > trial.fit.deviance - BETTER or not problem.is_stable(fit.x):
        return None
    return trial_of(trial.candidate, fit, baseline, n_candidate)


def acting_where(found: Location, trials: tuple[Trial, ...], baseline: Fit) -> tuple[Trial, ...]:
    """The trials of effects that act at the place of a sharp location alone; all without one."""
    if not found.is_sharp:
        return trials
    machine = baseline.problem.machine
    places = [trial.candidate.effect.places(machine) for trial in trials]
    return tuple(trial for trial, at in zip(trials, places) if len(at) and all(map(found.accepts, at)))
