"""The diagnosis of a measurement: test the model, name the cause of its misfit, extend it, measure the predictive gain.

1. The baseline model is fitted from the whole range of its unknowns, and its residuals are tested for lack of fit.
2. Every effect, at every location where it may occur, is fitted jointly with all unknowns from the baseline fit.
   Fits whose rotor is unstable at a measured speed are bounded to where it is stable.
3. If the test rejects or any effect is significant, the trials are refined: effects that move sharp resonances are
   scanned over their whole range, at little effort first, and at all of it where the best one then leaves more than noise.
   Where the best trial is that near the baseline model that noise is nearly as large, first scans are left out.
4. Second effects are fitted beside the best one: one that is as significant as a first one must be is added. If the best
   effect does not leave noise behind, second effects are scanned, and beside the next best ones too (`second_effects`).
5. The verdict:
   - `adequate`: no evidence against the baseline model, and the data would show effects if they were there;
   - `not observable`: no evidence, but most effects would not show in these data even at their physical limits;
   - `named`: one effect, or one pair, explains the data, none of the others comes near;
   - `ambiguous`: several explain it about as well, what they say together (`averaging`), and what further measurement would
     split them;
   - `unknown`: the model is wrong, and no effect or pair of effects leaves noise behind. A study makes `located` of it
     where an unknown force at a few places does (`location`).

`level` is the chance of rejecting a right model. Half of it goes to the lack-of-fit test, half to the effects, whose
p-values are corrected for their number.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ksmea.diagnosis.further_measurement import Split, best_split
from ksmea.diagnosis.model_averaging import Averaged, averaged
from ksmea.diagnosis.observability import Detectable, smallest_detectable
from ksmea.diagnosis.predictive_gain import PredictiveGain, predictive_gain
from ksmea.diagnosis.rivals import Cosines, collinearities, cosines_with, tested
from ksmea.diagnosis.second_effects import alternatives, distinct_firsts, each_alone, pairs_beside
from ksmea.diagnosis.trials import (
    BETTER,
    NEAR,
    Candidate,
    Explanation,
    Trial,
    best_by_name,
    best_of_names,
    candidates_and_left_out,
    fitted,
    none_located,
    ranked_explanations,
    refined,
)
from ksmea.fits.fitting import BaselineFits, Effort, Fit, fit_baseline, polished, settled
from ksmea.fits.lack_of_fit import (
    FitQuality,
    as_left,
    fit_quality,
    is_noise_as_stated,
    is_size_alone,
    with_noise_as_left,
)
from ksmea.fits.stable_fits import settled_stable, stable_fit
from ksmea.inference.intervals import LOWER, Estimate
from ksmea.inference.maximisation import maximise, with_best_noise
from ksmea.measurement.measurement import Measurement
from ksmea.numerics.parallel import for_each
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.problem import Problem

MAX_TESTED = 3  # of the best pairs, those that are asked whether they leave noise behind
NEARBY = 100.0  # deviance drop of the best trial up to which scans find nothing better than fits from nearby
MAX_SPLIT = 6  # explanations that a further measurement is sought for
MIN_OBSERVABLE = 0.5  # part of the effects that must be observable for a model to be called adequate


@dataclass(frozen=True)
class Diagnosis:
    """What was found; `trials` are ranked, `named` and `ambiguity_group` are names of effects, `best` is the extended fit
    that the verdict speaks of (None without one) with its effects in `applied`.

    `explanations` are the best one and those that explain the data about as well, effects or pairs at all their locations:
    ΔBIC ≤ 6, or a deviance as low, whatever BIC charges for their unknowns. The ambiguity group holds the names of their
    effects, the named ones first. `locations` are those where the best one explains the data about as well.
    `collinearity` is the cosine between what the best effect does to the data and what each other one can do.
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
    # by effect: its most promising location, and its unknowns there
    detectable: Mapping[str, tuple[str, tuple[Detectable, ...]]]
    level: float
    left_out: Mapping[str, str] = field(default_factory=dict)  # effects that do not fit the problem, and why
    explanations: tuple[Explanation, ...] = ()
    averaged: Averaged | None = None  # over the explanations, where there are several


def diagnose(
    problem: Problem,
    measurement: Measurement,
    effects: Mapping[str, AnyEffect],
    rng: np.random.Generator,
    *,
    level: float = 0.01,
    effort: Effort | None = None,
    n_block: int = 6,
    interval_level: float = 0.95,
    progress: Callable[[], None] = lambda: None,
) -> Diagnosis:
    """The diagnosis of a measurement by a problem and the effects that are known, which may be none: then it is whether the
    model fits. `progress` is called at each step.

    Noise that is stated is believed unless its size is all that speaks against a model (`ksmea.fits.lack_of_fit`): the
    measurement of the fits then has noise as large as that model leaves it.
    """
    effort = effort or Effort()
    found, left_out = candidates_and_left_out(problem, effects)
    if effects and not found:
        raise ValueError(f"diagnosis: {none_located(effects)}")
    baseline = fit_baseline(problem, measurement, rng, effort)
    progress()

    def by(fits: BaselineFits) -> Diagnosis:
        diagnosed = _diagnosed(fits, found, rng, level, effort, n_block, interval_level, progress)
        return dataclasses.replace(diagnosed, left_out=left_out)

    half = level / 2
    other_noise = with_noise_as_left(baseline, half, rng.spawn(1)[0])
    first = by(other_noise)
    if other_noise is not baseline:
        explains = first.named and first.best and is_noise_as_stated(first.best, measurement, half, rng.spawn(1)[0])
        return by(baseline) if explains else first
    quality = first.best_quality or first.baseline_quality
    if first.verdict == "unknown" and is_size_alone(quality, half):
        return by(baseline.refitted(as_left(measurement, quality)))
    return first


def _diagnosed(
    baseline: BaselineFits,
    found: Sequence[Candidate],
    rng: np.random.Generator,
    level: float,
    effort: Effort,
    n_block: int,
    interval_level: float,
    progress: Callable[[], None],
) -> Diagnosis:
    """The same from the fits of the baseline model, with the noise that they have."""
    problem, measurement = baseline.best.problem, baseline.best.likelihood.measurement
    half = level / 2
    baseline, quality, trials = _ranked_trials(baseline, found, half, rng, effort, progress)
    baseline_fit, baseline_estimate = settled(baseline.best, interval_level, progress, effort.workers)
    if baseline_fit.deviance < baseline.best.deviance - LOWER:
        moved = BaselineFits(baseline_fit, (baseline.best, *baseline.others), baseline.screened)
        baseline, quality, trials = _ranked_trials(moved, found, half, rng, effort, progress)
        baseline_fit, baseline_estimate = settled(baseline.best, interval_level, progress, effort.workers)
    significant = _significant(trials, half)
    first = next(iter(significant), None)
    cosines: Cosines = {}
    if first is not None:
        cosines = cosines_with(first, trials, effort.workers)
        trials = tested(first, trials, cosines, baseline.best, progress, effort.workers)
        significant = _significant(trials, half)
    lead = significant[0] if significant else None
    if lead is not None and lead is not first:
        cosines = cosines_with(lead, trials, effort.workers)
    explained = (
        None if lead is None else _explained(significant, trials, baseline, measurement, half, effort, rng, progress)
    )
    if explained is not None and (better := each_alone(explained.best, trials, baseline.best)):
        trials, significant = better, _significant(better, half)
        lead = significant[0]
        cosines = cosines_with(lead, trials, effort.workers)
        explained = _explained(significant, trials, baseline, measurement, half, effort, rng, progress)
    best = best_estimate = best_quality = None
    if explained is not None:
        best, best_estimate = settled_stable(explained.best.fit, interval_level, progress, effort.workers)
        best_quality = explained.quality
        if best.deviance < explained.best.fit.deviance - LOWER:
            best_quality = fit_quality(best, rng)
    by_name = best_by_name(trials)
    smallest = partial(smallest_detectable, baseline_fit, level=half / max(1, len(found)))
    sizes = for_each(smallest, [trial.candidate for trial in by_name.values()], effort.workers)
    detectable = {name: (trial.location, tuple(size)) for (name, trial), size in zip(by_name.items(), sizes)}
    verdict = _verdict(quality.p < half, best_quality, explained, half, detectable)
    accepted = explained.near if explained is not None and verdict in ("named", "ambiguous") else ()
    named = tuple(candidate.name for candidate in accepted[0].applied) if accepted else ()
    return Diagnosis(
        verdict=verdict,
        named=named,
        ambiguity_group=tuple(dict.fromkeys([*named, *(name for each in accepted for name in each.names)])),
        locations=tuple(each.location for each in accepted if each.names == accepted[0].names),
        explanations=accepted,
        averaged=_averaged(accepted, best, best_estimate, len(problem.parameters), interval_level, progress, effort)
        if effort.average
        else None,
        baseline=baseline_fit,
        baseline_estimate=baseline_estimate,
        baseline_quality=quality,
        trials=tuple(trials),
        best=best,
        applied=() if explained is None else explained.best.applied,
        best_estimate=best_estimate,
        best_quality=best_quality,
        predictive_gain=None if best is None else predictive_gain(baseline_fit, best, n_block, progress),
        split=_split(accepted, len(problem.parameters), progress, effort)
        if effort.split and verdict == "ambiguous"
        else None,
        collinearity={} if lead is None else collinearities(lead, trials, cosines),
        detectable=detectable,
        level=level,
    )


def _ranked_trials(
    baseline: BaselineFits,
    found: Sequence[Candidate],
    level: float,
    rng: np.random.Generator,
    effort: Effort,
    progress: Callable[[], None],
) -> tuple[BaselineFits, FitQuality, list[Trial]]:
    """The baseline model's fits, their quality, and every candidate fitted; refined if there is evidence of anything. Where
    a trial shows that the baseline model fits better elsewhere, all is done again from there, before costly scans if it can."""
    problem, measurement = baseline.best.problem, baseline.best.likelihood.measurement
    quality = fit_quality(baseline.best, rng)
    trials = fitted(problem, measurement, baseline.best, found, progress, workers=effort.workers)
    if quality.p >= level and not _significant(trials, level):
        return baseline, quality, trials
    better = _baseline_from(trials, baseline)
    if better is baseline:
        trials = _refined(trials, baseline, level, rng, effort, progress)
        better = _baseline_from(trials, baseline)
    if better is not baseline:
        return _ranked_trials(better, found, level, rng, effort, progress)
    return baseline, quality, trials


def _refined(
    trials: Sequence[Trial],
    baseline: BaselineFits,
    level: float,
    rng: np.random.Generator,
    effort: Effort,
    progress: Callable[[], None],
) -> list[Trial]:
    """The trials refined at little effort, without scans where the data are near the baseline model, and where the best one then
    leaves more than noise, at all of it."""
    measurement = baseline.best.likelihood.measurement
    is_scanned = any(trial.deviance_drop > NEARBY for trial in trials)
    found = refined(trials, measurement, baseline, effort.of_first_scans, progress, is_scanned=is_scanned)
    if not found or _leaves_noise(fit_quality(polished(found[0].fit), rng), level):
        return found
    return refined(found, measurement, baseline, effort, progress, by_force=False)


def _leaves_noise(quality: FitQuality, level: float) -> bool:
    """Whether a fit leaves noise, of whatever size."""
    return quality.p >= level or is_size_alone(quality, level)


@dataclass(frozen=True)
class _Explained:
    """What the data are explained with: the best effect, or pair of effects, then all that explain them about as well."""

    quality: FitQuality
    near: tuple[Explanation, ...]

    @property
    def best(self) -> Explanation:
        return self.near[0]

    @property
    def is_ambiguous(self) -> bool:
        return any(each.names != self.best.names for each in self.near)


def _significant(trials: Sequence[Trial], level: float) -> list[Trial]:
    """Trials that are evidence for their effect, by p and by BIC."""
    return [trial for trial in trials if trial.p < level and trial.delta_bic > 0]


def _baseline_from(trials: Sequence[Trial], baseline: BaselineFits) -> BaselineFits:
    """The baseline model fitted from where the best effects put its unknowns, if that is better."""
    likelihood = baseline.best.likelihood
    d = likelihood.d
    for trial in trials[:3]:
        limit = baseline.best.deviance - BETTER
        point = maximise(likelihood, likelihood.start(trial.fit.u[:d]), ceiling=limit)
        if point.deviance < limit:
            best = Fit(baseline.best.problem, likelihood, with_best_noise(likelihood, point))
            baseline = BaselineFits(best, (baseline.best, *baseline.others), baseline.screened)
    return baseline


def _explained(
    significant: Sequence[Trial],
    trials: Sequence[Trial],
    baseline: BaselineFits,
    measurement: Measurement,
    level: float,
    effort: Effort,
    rng: np.random.Generator,
    progress: Callable[[], None],
) -> _Explained:
    """The best pair of effects if the second one is significant beside the first, or if the best effect alone does not
    leave noise behind and the pair does; else the best effect."""
    alone = _with_near(Explanation.of(significant[0]), map(Explanation.of, trials), rng)
    leaves_noise = alone.quality.p >= level
    firsts = distinct_firsts(significant, 1 if leaves_noise else effort.firsts)
    pairs = pairs_beside(firsts, trials, baseline, measurement, effort, progress, is_scanned=not leaves_noise)
    limit = alone.best.delta_bic + NEAR
    best = [pair for pair in pairs if pair.p < level and pair.delta_bic > limit][:MAX_TESTED]
    if best:
        n_pair = len(significant) * (len(trials) - 1)
        others = alternatives(best[0], significant, measurement, effort, progress, n_pair)
        pairs = ranked_explanations([*pairs, *others])
        best = [pair for pair in pairs if pair.p < level and pair.delta_bic > limit][:MAX_TESTED]
    for pair in best:
        found = _with_near(pair, pairs, rng)
        if found.quality.p >= level:
            return found
    return alone


def _with_near(best: Explanation, others: Iterable[Explanation], rng: np.random.Generator) -> _Explained:
    """An explanation, polished, and those that explain the data about as well."""
    fit = stable_fit(polished(best.fit), best.fit.point.theta)
    near = [each for each in others if each.is_near(best) and not each.is_same(best)]
    return _Explained(fit_quality(fit, rng), (dataclasses.replace(best, fit=fit), *near))


def _verdict(
    lacks_fit: bool,
    best_quality: FitQuality | None,
    explained: _Explained | None,
    level: float,
    detectable: Mapping[str, tuple[str, Sequence[Detectable]]],
) -> str:
    if explained is not None and best_quality is not None:
        if best_quality.p < level:
            return "unknown"
        return "ambiguous" if explained.is_ambiguous else "named"
    if lacks_fit:
        return "unknown"
    observable = [any(each.is_observable for each in parts) for _, parts in detectable.values()]
    return "not observable" if observable and np.mean(observable) < MIN_OBSERVABLE else "adequate"


def _averaged(
    explanations: Sequence[Explanation],
    best: Fit | None,
    estimated: Estimate | None,
    d: int,
    level: float,
    progress: Callable[[], None],
    effort: Effort,
) -> Averaged | None:
    """The average over several explanations, at all their locations."""
    if best is None or estimated is None or len(explanations) < 2:
        return None
    return averaged(explanations, best, estimated, d, level, progress, effort.workers)


def _split(explanations: Sequence[Explanation], d: int, progress: Callable[[], None], effort: Effort) -> Split | None:
    """What would tell explanations apart, each at its best location."""
    return best_split(
        {each.label: each.fit for each in best_of_names(explanations)[:MAX_SPLIT]}, d, progress, effort.workers
    )
