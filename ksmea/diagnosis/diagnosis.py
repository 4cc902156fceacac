"""Diagnosis: test a model, name the cause of its misfit, extend it, measure the predictive gain.

1. The baseline model is fitted from the whole range of its unknowns, and its residuals are tested for lack of fit.
2. Every effect, at every location where it may occur, is fitted jointly with all unknowns from the baseline fit.
   Fits whose rotor is unstable at a measured speed are bounded to where it is stable.
3. If the test rejects or any effect is significant, the trials are refined: effects that move sharp resonances are
   scanned over their whole range, at little effort first, and at full effort if the residuals of the best one are more than noise.
   If noise is nearly as large as the deviance drop of the best trial, first scans are skipped.
4. Second effects are fitted together with the best one: one that is as significant as a first one must be is added. If the
   residuals of the best effect are more than noise, second effects are scanned, also with the next best ones (`second_effects`).
5. The verdict:
   - `adequate`: no evidence against the baseline model, and the data would show effects if they were there;
   - `not observable`: no evidence, but most effects would not show in these data even at their physical limits;
   - `named`: one effect, or one pair, explains the data, none of the others comes near;
   - `ambiguous`: several explain it about as well, with their average (`model_averaging`) and the further measurement that
     would separate them;
   - `unknown`: the model is wrong, and the residuals of every effect and pair are more than noise. A study turns it into
     `located` if an unknown force at a few places explains the data (`location`).

`level` is the chance of rejecting a right model. Half of it goes to the lack-of-fit test, half to the effects, whose
p-values are corrected for their number.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ksmea.diagnosis.equivalents import alone_in_place_of, pairs_in_place_of
from ksmea.diagnosis.exchange import exchanged, exchanged_once, lifted
from ksmea.diagnosis.explained import Explained, by_weight, led_by, with_near
from ksmea.diagnosis.further_measurement import Split, best_split
from ksmea.diagnosis.kin import with_kin
from ksmea.diagnosis.model_averaging import Averaged, averaged, heaviest
from ksmea.diagnosis.observability import Detectable, smallest_by_name
from ksmea.diagnosis.predictive_gain import PredictiveGain, predictive_gain
from ksmea.diagnosis.rivals import Cosines, collinearities, cosines_with, tested
from ksmea.diagnosis.second_effects import acting_where, alternatives, distinct_firsts, each_alone, pairs_beside
from ksmea.diagnosis.trials import (
    BETTER,
    NEAR,
    Candidate,
    Explanation,
    Trial,
    best_of_names,
    candidates_and_left_out,
    fitted,
    none_located,
    ranked_explanations,
    refined,
    trial_of,
)
from ksmea.errors import SettingError
from ksmea.fits.fitting import BaselineFits, Fit, fit_baseline, polished, settled
from ksmea.fits.joint_fit import joint_baseline
from ksmea.fits.lack_of_fit import (
    FitQuality,
    as_left,
    fit_quality,
    is_noise_as_stated,
    is_size_alone,
    with_noise_as_left,
)
from ksmea.fits.search import Search
from ksmea.fits.stable_fits import settled_stable
from ksmea.inference.intervals import LOWER, Estimate
from ksmea.inference.maximisation import maximise, with_best_noise
from ksmea.location.location import Location
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.case import Case
from ksmea.records.diagnosis import MAX_SPLIT

Locate = Callable[[Case], Location]

MAX_TESTED = 3  # of the best pairs, those that are asked whether they leave noise behind
NEARBY = 100.0  # deviance drop of the best trial up to which scans find nothing better than fits from nearby
MIN_OBSERVABLE = 0.5  # part of the effects that must be observable for a model to be called adequate


@dataclass(frozen=True)
class Diagnosis:
    """Findings of a diagnosis.

    `trials` are ranked, `named` and `ambiguity_group` are names of effects, `best` is the extended fit of the verdict
    (None without one) with its effects in `applied`.

    `explanations` are the best one and all that fit about as well, effects or pairs at all their locations: ΔBIC ≤ 6, or a
    deviance as low, whatever the BIC penalty of their unknowns. The ambiguity group holds the names of their effects, the named
    ones first. `locations` are the locations at which the best one explains the data about as well. `collinearity` is the cosine
    between the change of the data by the best effect and the nearest change that each other one can make.
    """

    verdict: str
    named: tuple[str, ...]
    ambiguity_group: tuple[str, ...]
    locations: tuple[str, ...]
    baseline: Fit
    baseline_estimate: Estimate
    baseline_quality: FitQuality
    trials: tuple[Trial, ...]
    best: Fit | None
    applied: tuple[Candidate, ...]
    best_estimate: Estimate | None
    best_quality: FitQuality | None
    predictive_gain: PredictiveGain | None
    split: Split | None
    collinearity: Mapping[str, float]
    detectable: Mapping[str, tuple[str, tuple[Detectable, ...]]]  # by effect: its most promising location, its unknowns
    level: float
    interval_level: float
    left_out: Mapping[str, str] = field(default_factory=dict)  # effects that do not fit the problem, and why
    explanations: tuple[Explanation, ...] = ()
    averaged: Averaged | None = None  # over the explanations, where there are several


@dataclass(frozen=True)
class Criteria:
    """Chance of rejecting a right model, confidence of intervals, and blocks of speeds left out in turn."""

    level: float = 0.01
    interval_level: float = 0.95
    n_block: int = 6

    @property
    def half(self) -> float:
        """The level of the lack-of-fit test, and the level shared by all effects."""
        return self.level / 2


def diagnose(
    case: Case,
    effects: Mapping[str, AnyEffect],
    search: Search,
    criteria: Criteria = Criteria(),
    baseline: BaselineFits | None = None,
    locate: Locate | None = None,
) -> Diagnosis:
    """Diagnose a measurement with a library of effects; without any, only test the fit.

    The baseline model's fits may be given, and what locates the cause without the library: if it finds a place, no
    pairs of effects elsewhere are sought.

    Stated noise is kept unless its size is the only evidence against a model (`ksmea.fits.lack_of_fit`): then the fits use noise
    as large as the residuals of that model.
    """
    found, left_out = candidates_and_left_out(case.problem.joint, effects)
    if effects and not found:
        raise SettingError(none_located(effects))
    baseline = baseline or joint_baseline(fit_baseline(case, search))
    search.workers.progress()

    def by(fits: BaselineFits) -> Diagnosis:
        return _concluded(_last_state(fits, found, search, criteria, locate), left_out, search)

    half, rng = criteria.half, search.rng
    other_noise = with_noise_as_left(baseline, half, rng.spawn(1)[0])
    first = by(other_noise)
    if other_noise is not baseline:
        explains = (
            first.named and first.best and is_noise_as_stated(first.best, case.measurement, half, rng.spawn(1)[0])
        )
        return by(baseline) if explains else first
    quality = first.best_quality or first.baseline_quality
    if first.verdict == "unknown" and is_size_alone(quality, half):
        return by(baseline.refitted(as_left(case.measurement, quality)))
    return first


@dataclass(frozen=True)
class _State:
    """Results up to a step: fits of the baseline model, trials and explanations."""

    criteria: Criteria
    candidates: tuple[Candidate, ...]
    baseline: BaselineFits
    quality: FitQuality
    trials: tuple[Trial, ...]
    locate: Locate | None = None
    settled: tuple[Fit, Estimate] | None = None
    cosines: Cosines = field(default_factory=dict)
    led_by: Trial | None = None
    explained: Explained | None = None
    is_explained: bool = False  # the residuals of the best effect look like noise

    @property
    def level(self) -> float:
        return self.criteria.half

    @property
    def significant(self) -> list[Trial]:
        """Trials that are evidence for their effect, by p and by BIC."""
        return [trial for trial in self.trials if trial.p < self.level and trial.delta_bic > 0]

    @property
    def lead(self) -> Trial | None:
        return next(iter(self.significant), None)

    @property
    def is_evident(self) -> bool:
        """Whether there is evidence against the baseline model."""
        return self.quality.p < self.level or bool(self.significant)


def _last_state(
    baseline: BaselineFits, found: Sequence[Candidate], search: Search, criteria: Criteria, locate: Locate | None
) -> _State:
    """State after all steps, which start again from better fits of the baseline model if these are needed."""
    quality, trials = fit_quality(baseline.best, search.rng), fitted(baseline.best, found, search)
    state = _State(criteria, tuple(found), baseline, quality, tuple(trials), locate)
    for step in (_moved, _refined, _moved, _settled, _collinear, _rivals_tested, _explained, _collinear):
        state = step(state, search)
        if state.baseline is not baseline and not state.is_explained:
            return _last_state(state.baseline, found, search, criteria, locate)
        if state.baseline is not baseline:
            state, baseline = _rebased(state, search), state.baseline
    return state


def _rebased(state: _State, search: Search) -> _State:
    """Trials compared with a better fit of the baseline model, and also fitted from the best effect."""
    without, n = state.baseline.best, len(state.trials)
    trials = [trial_of(trial.candidate, trial.fit, without, n) for trial in state.trials]
    trials = exchanged_once(trials, trials[:1], state.baseline, search, is_first=False)
    return dataclasses.replace(state, quality=fit_quality(without, search.rng), trials=tuple(trials))


def _moved(state: _State, search: Search) -> _State:
    """The baseline model fitted from where the best effects put its unknowns, if that is better."""
    fits = state.baseline
    for trial in state.trials[:3] if state.is_evident else ():
        likelihood, limit = fits.best.likelihood, fits.best.deviance - BETTER
        point = maximise(likelihood, likelihood.start(trial.fit.u[: likelihood.d]), ceiling=limit)
        if point.deviance < limit:
            fits = fits.under(Fit(likelihood, with_best_noise(likelihood, point)))
    return dataclasses.replace(state, baseline=fits)


def _refined(state: _State, search: Search) -> _State:
    """Trials refined at little effort, without scans near the baseline model or if the first leaves noise.

    The effort is full if the best one then leaves more than noise. Trials also start from each other's unknowns while that leads to
    better ones: such data have many maxima, and no trial may end in a worse one than its neighbour.
    """
    if not state.is_evident:
        return state
    is_scanned = any(trial.deviance_drop > NEARBY for trial in state.trials)
    first = search.with_effort(search.effort.of_first_scans, is_scanned=is_scanned)
    enough = partial(_leaves_noise, rng=search.rng.spawn(1)[0], level=state.level)
    found = refined(state.trials, state.baseline, first, enough)
    found = lifted(found, state.baseline, first) if found and is_scanned else found
    is_explained = bool(found) and _leaves_noise(found[0].fit, search.rng, state.level)
    if found and not is_explained:
        found = refined(found, state.baseline, search.with_effort(search.effort, from_force=False))
        found = exchanged(found, state.baseline, search)
    trials = with_kin(found, state.level, state.baseline.best, search)
    return dataclasses.replace(state, trials=tuple(trials), is_explained=is_explained)


def _leaves_noise(fit: Fit, rng: np.random.Generator, level: float) -> bool:
    """Whether the residuals of a fit look like noise of any size."""
    quality = fit_quality(polished(fit), rng)
    return quality.p >= level or is_size_alone(quality, level)


def _settled(state: _State, search: Search) -> _State:
    """The baseline fit with its intervals; the better one that profiles meet, if they meet any."""
    fit, estimated = settled(state.baseline.best, state.criteria.interval_level, search.workers)
    if fit.deviance < state.baseline.best.deviance - LOWER:
        return dataclasses.replace(state, baseline=state.baseline.under(fit), settled=(fit, estimated))
    return dataclasses.replace(state, settled=(fit, estimated))


def _collinear(state: _State, search: Search) -> _State:
    """The cosines of all candidates with the lead."""
    if state.lead is None or state.lead is state.led_by:
        return state
    cosines = cosines_with(Explanation.of(state.lead), state.trials, search.workers)
    return dataclasses.replace(state, cosines=cosines, led_by=state.lead)


def _rivals_tested(state: _State, search: Search) -> _State:
    """The trials, refitted if their cosine with the lead predicts a better fit."""
    if state.lead is None:
        return state
    lead = Explanation.of(state.lead)
    trials = tested(lead, state.trials, state.cosines, state.baseline.best, search.workers)
    return dataclasses.replace(state, trials=tuple(trials))


def _explained(state: _State, search: Search) -> _State:
    """Explanations, found again if one effect alone turns out to fit as well as a pair."""
    if state.lead is None:
        return state
    explained, baseline = _best_explanation(state, state.lead, search), state.baseline.best
    if len(explained.best.applied) > 1:
        better = each_alone(explained.best, state.trials, baseline)
        better = better or alone_in_place_of(explained.best, state.trials, baseline, search)
        if better:
            return _explained(dataclasses.replace(state, trials=tuple(better)), search)
    return dataclasses.replace(state, explained=by_weight(explained, state.level, search.rng))


def _best_explanation(state: _State, lead: Trial, search: Search) -> Explained:
    """Best pair if its second effect is significant or only its residuals are noise, else the best effect."""
    level, trials, significant = state.level, state.trials, state.significant
    alone = with_near(Explanation.of(lead), map(Explanation.of, trials), search.rng)
    leaves_noise = alone.quality.p >= level
    if not leaves_noise and state.locate is not None:
        where = state.locate(state.baseline.best.case)
        trials = acting_where(where, trials, state.baseline.best)
        significant = [trial for trial in trials if trial.p < level and trial.delta_bic > 0]
    firsts = distinct_firsts(significant, 1 if leaves_noise else search.effort.firsts)
    seconds = [
        trial for trial in trials if trial.candidate in state.candidates
    ]  # without kin, which are pairs of their own
    pairs = pairs_beside(firsts, seconds, state.baseline, search, is_scanned=not leaves_noise)

    def best_of(pairs: Sequence[Explanation]) -> list[Explanation]:
        limit = alone.best.delta_bic + NEAR
        able = [pair for pair in pairs if pair.p < level and pair.delta_bic > limit and pair.has_sizes]
        return able[:MAX_TESTED]

    if best := best_of(pairs):
        others = alternatives(best[0], significant, search, len(significant) * (len(trials) - 1))
        others += pairs_in_place_of(best[0], trials, [*pairs, *others], state.baseline.best, search)
        pairs = ranked_explanations([*pairs, *others])
    for pair in best_of(pairs):
        found = with_near(pair, pairs, search.rng)
        if found.quality.p >= level:
            return found
    return alone


def _concluded(state: _State, left_out: Mapping[str, str], search: Search, *, is_first: bool = True) -> Diagnosis:
    """Diagnosis of a last state, with another explanation in the lead if intervals give it most weight."""
    explained, workers = state.explained, search.workers
    assert state.settled is not None, "a state that is not the last one"
    baseline, baseline_estimate = state.settled
    best = best_estimate = best_quality = None
    if explained is not None:
        best, best_estimate = settled_stable(explained.best.fit, state.criteria.interval_level, workers)
        is_better = best.deviance < explained.best.fit.deviance - LOWER
        best_quality = fit_quality(best, search.rng) if is_better else explained.quality
    detectable = smallest_by_name(state.trials, baseline, state.level / max(1, len(state.candidates)), workers)
    verdict = _verdict(state, best_quality, detectable)
    accepted = explained.near if explained is not None and verdict in ("named", "ambiguous") else ()
    named = tuple(candidate.name for candidate in accepted[0].applied) if accepted else ()
    d = baseline.likelihood.d
    mean = split = gain = None
    if best is not None and best_estimate is not None and len(accepted) > 1 and search.effort.average:
        mean = averaged(accepted, best, best_estimate, d, state.criteria.interval_level, workers)
        if is_first and (index := heaviest([each.names for each in mean.explanations], mean.weights)):
            other = dataclasses.replace(state, explained=led_by(index, accepted, search.rng))
            return _concluded(other, left_out, search, is_first=False)
    if best is not None:
        gain = predictive_gain(baseline, best, state.criteria.n_block, workers)
    if verdict == "ambiguous" and search.effort.split:  # of each explanation the best location
        split = best_split({each.label: each.fit for each in best_of_names(accepted)[:MAX_SPLIT]}, d, workers)
    return Diagnosis(
        verdict=verdict,
        named=named,
        ambiguity_group=tuple(dict.fromkeys([*named, *(name for each in accepted for name in each.names)])),
        locations=tuple(each.location for each in accepted if each.names == accepted[0].names),
        baseline=baseline,
        baseline_estimate=baseline_estimate,
        baseline_quality=state.quality,
        trials=state.trials,
        best=best,
        applied=() if explained is None else explained.best.applied,
        best_estimate=best_estimate,
        best_quality=best_quality,
        predictive_gain=gain,
        split=split,
        collinearity={}
        if state.lead is None
        else collinearities(Explanation.of(state.lead), state.trials, state.cosines),
        detectable=detectable,
        level=state.criteria.level,
        interval_level=state.criteria.interval_level,
        left_out=left_out,
        explanations=accepted,
        averaged=mean,
    )


def _verdict(
    state: _State, best_quality: FitQuality | None, detectable: Mapping[str, tuple[str, Sequence[Detectable]]]
) -> str:
    if state.explained is not None and best_quality is not None:
        if best_quality.p < state.level:
            return "unknown"
        return "ambiguous" if state.explained.is_ambiguous else "named"
    if state.quality.p < state.level:
        return "unknown"
    observable = [any(each.is_observable for each in parts) for _, parts in detectable.values()]
    return "not observable" if observable and np.mean(observable) < MIN_OBSERVABLE else "adequate"
