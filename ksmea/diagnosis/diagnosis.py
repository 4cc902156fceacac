"""The diagnosis of a measurement: test the model, name the cause of its misfit, extend it, measure the predictive gain.

1. The baseline model is fitted from the whole range of its unknowns, and its residuals are tested for lack of fit.
2. Every effect, at every location where it may occur, is fitted jointly with all unknowns from the baseline fit.
   Fits whose rotor is unstable at a measured speed are bounded to where it is stable.
3. If the test rejects or any effect is significant, the trials are refined: effects that move sharp resonances are
   scanned over their whole range.
4. Second effects are fitted beside the best one: one that is as significant as a first one must be is added. If the best
   effect does not leave noise behind, second effects are fitted beside the next best ones too.
5. The verdict:
   - `adequate`: no evidence against the baseline model, and the data would show effects if they were there;
   - `not observable`: no evidence, but most effects would not show in these data even at their physical limits;
   - `named`: one effect explains the data, none of the others comes near;
   - `ambiguous`: several explain it about as well, and what further measurement would split them;
   - `unknown`: the model is wrong, and no effect or pair of effects leaves noise behind. A study makes `located` of it
     where an unknown force at a few places does (`location`).

`level` is the chance of rejecting a right model. Half of it goes to the lack-of-fit test, half to the effects, whose
p-values are corrected for their number.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ksmea.contracts import AnyEffect, Problem
from ksmea.diagnosis.fit_quality import FitQuality, fit_quality
from ksmea.diagnosis.fitting import BaselineFits, Effort, Fit, fit_baseline, polished, settled
from ksmea.diagnosis.observability import Detectable, collinearity, smallest_detectable
from ksmea.diagnosis.predictive_gain import PredictiveGain, predictive_gain
from ksmea.diagnosis.split import Split, best_split
from ksmea.diagnosis.stable_fits import settled_stable, stable_fit
from ksmea.diagnosis.trials import (
    Candidate,
    Trial,
    best_by_name,
    candidates_and_left_out,
    fitted,
    none_located,
    refined,
)
from ksmea.intervals import LOWER, Estimate
from ksmea.maximisation import maximise, with_best_noise
from ksmea.measurement import Measurement

NEAR = 6.0  # ΔBIC within which effects cannot be told apart (Kass & Raftery 1995: strong evidence begins there)
MAX_PAIRED = 3  # effects that a second one is fitted beside
MIN_OBSERVABLE = 0.5  # part of the effects that must be observable for a model to be called adequate


@dataclass(frozen=True)
class Diagnosis:
    """What was found; `trials` are ranked, `named` and `ambiguity_group` are names of effects, `best` is the extended fit
    that the verdict speaks of (None without one) with its effects in `applied`.

    The ambiguity group holds the named effects and those that explain the data about as well: by their own fits (ΔBIC ≤ 6,
    or a deviance as low, whatever BIC charges for their unknowns), or because they are collinear with the best one, as
    projected sensitivities have it. `locations` are those where the best effect explains the data about as well.
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
    model fits. `progress` is called at each step."""
    effort = effort or Effort()
    half = level / 2
    found, left_out = candidates_and_left_out(problem, effects)
    if effects and not found:
        raise ValueError(f"diagnosis: {none_located(effects)}")
    baseline = fit_baseline(problem, measurement, rng, effort)
    progress()
    baseline, quality, trials = _ranked_trials(baseline, found, half, rng, effort, progress)
    baseline_fit, baseline_estimate = settled(baseline.best, interval_level)
    if baseline_fit.deviance < baseline.best.deviance - LOWER:
        moved = BaselineFits(baseline_fit, (baseline.best, *baseline.others), baseline.screened)
        baseline, quality, trials = _ranked_trials(moved, found, half, rng, effort, progress)
        baseline_fit, baseline_estimate = settled(baseline.best, interval_level)
    significant = _significant(trials, half)
    lead = significant[0] if significant else None
    collinearities = {} if lead is None else _collinearities(lead, trials)
    explained = (
        None
        if lead is None
        else _explained(lead, significant, trials, collinearities, measurement, half, rng, progress)
    )
    best = best_estimate = best_quality = None
    if explained is not None:
        best, best_estimate = settled_stable(explained.fit, interval_level)
        best_quality = explained.quality
        if best.deviance < explained.fit.deviance - LOWER:
            best_quality = fit_quality(best, rng)
    detectable = {
        name: (trial.location, tuple(smallest_detectable(baseline_fit, trial.candidate, half / len(found))))
        for name, trial in best_by_name(trials).items()
    }
    verdict = _verdict(quality.p < half, best_quality, explained, half, detectable)
    accepted = explained if verdict in ("named", "ambiguous") else None
    named = () if accepted is None else tuple(candidate.name for candidate in accepted.applied)
    return Diagnosis(
        verdict=verdict,
        named=named,
        ambiguity_group=named if accepted is None else tuple(dict.fromkeys([*named, *accepted.rivals])),
        locations=() if accepted is None else accepted.locations,
        baseline=baseline_fit,
        baseline_estimate=baseline_estimate,
        baseline_quality=quality,
        trials=tuple(trials),
        best=best,
        applied=() if explained is None else explained.applied,
        best_estimate=best_estimate,
        best_quality=best_quality,
        predictive_gain=None if best is None else predictive_gain(baseline_fit, best, n_block, progress),
        split=_split(explained, len(problem.parameters), progress) if verdict == "ambiguous" else None,
        collinearity=collinearities,
        detectable=detectable,
        level=level,
        left_out=left_out,
    )


def _ranked_trials(
    baseline: BaselineFits,
    found: Sequence[Candidate],
    level: float,
    rng: np.random.Generator,
    effort: Effort,
    progress: Callable[[], None],
) -> tuple[BaselineFits, FitQuality, list[Trial]]:
    """The baseline model's fits, their quality, and every candidate fitted; refined if there is evidence of anything."""
    problem, measurement = baseline.best.problem, baseline.best.likelihood.measurement
    quality = fit_quality(baseline.best, rng)
    trials = fitted(problem, measurement, baseline.best, found, progress)
    if quality.p >= level and not _significant(trials, level):
        return baseline, quality, trials
    trials = refined(trials, measurement, baseline, effort, progress)
    better = _baseline_from(trials, baseline)
    if better is not baseline:
        baseline, quality = better, fit_quality(better.best, rng)
        trials = fitted(problem, measurement, baseline.best, found, progress)
        trials = refined(trials, measurement, baseline, effort, progress)
    return baseline, quality, trials


@dataclass(frozen=True)
class _Explained:
    """The best effect, or two, that the data are explained with; `rivals` do so about as well, by name of an effect that
    is not among these and with the fit that has it."""

    fit: Fit
    quality: FitQuality
    trials: tuple[Trial, ...]
    rivals: Mapping[str, Fit]
    locations: tuple[str, ...]

    @property
    def applied(self) -> tuple[Candidate, ...]:
        return tuple(trial.candidate for trial in self.trials)


def _significant(trials: Sequence[Trial], level: float) -> list[Trial]:
    """Trials that are evidence for their effect, by p and by BIC."""
    return [trial for trial in trials if trial.p < level and trial.delta_bic > 0]


def _baseline_from(trials: Sequence[Trial], baseline: BaselineFits) -> BaselineFits:
    """The baseline model fitted from where the best effects put its unknowns, if that is better."""
    likelihood = baseline.best.likelihood
    d = likelihood.d
    for trial in trials[:3]:
        point = maximise(likelihood, likelihood.start(trial.fit.u[:d]))
        if point.deviance < baseline.best.deviance - 0.1:
            best = Fit(baseline.best.problem, likelihood, with_best_noise(likelihood, point))
            baseline = BaselineFits(best, (baseline.best, *baseline.others), baseline.screened)
    return baseline


def _explained(
    lead: Trial,
    significant: Sequence[Trial],
    trials: Sequence[Trial],
    collinearities: Mapping[str, float],
    measurement: Measurement,
    level: float,
    rng: np.random.Generator,
    progress: Callable[[], None],
) -> _Explained:
    """The best pair of effects if the second one is significant beside the first, or if the best effect alone does not
    leave noise behind and the pair does; else the best effect."""
    fit = stable_fit(polished(lead.fit), lead.fit.point.theta)
    quality = fit_quality(fit, rng)
    alone = _Explained(fit, quality, (lead,), _rivals(lead, trials, collinearities), _locations(lead, trials))
    leaves_noise = quality.p >= level
    firsts = [lead] if leaves_noise else list(best_by_name(significant).values())[:MAX_PAIRED]
    pairs = _pairs(firsts, trials, measurement, level, progress)
    for pair in [pair for pair in pairs if pair.delta_bic > lead.delta_bic + NEAR][:MAX_PAIRED]:
        fit = stable_fit(polished(pair.second.fit), pair.second.fit.point.theta)
        quality = fit_quality(fit, rng)
        if quality.p >= level:
            rivals = {
                name: other.second.fit
                for other in reversed(pairs)  # the best one that has the name is kept
                if other.delta_bic > pair.delta_bic - NEAR
                for name in other.names
                if name not in pair.names
            }
            return _Explained(fit, quality, (pair.first, pair.second), rivals, ())
    return alone


def _rivals(lead: Trial, trials: Sequence[Trial], collinearities: Mapping[str, float]) -> dict[str, Fit]:
    """Other effects that explain the data about as well as the best: by their own fits, or by what sensitivities say
    that their best fit must reach, deviance drop · cos², whatever their fit has found."""
    found = {}
    for name, trial in best_by_name(trials).items():
        charge = (trial.n_unknown - lead.n_unknown) * np.log(lead.fit.likelihood.n_residual)
        is_near = max(trial.delta_bic - lead.delta_bic, trial.deviance_drop - lead.deviance_drop) > -NEAR
        if name != lead.name and (is_near or lead.deviance_drop * (1 - collinearities[name] ** 2) + charge < NEAR):
            found[name] = trial.fit
    return found


def _locations(lead: Trial, trials: Sequence[Trial]) -> tuple[str, ...]:
    """Where the best effect explains the data about as well, the best location first."""
    return tuple(
        trial.location for trial in trials if trial.name == lead.name and trial.delta_bic > lead.delta_bic - NEAR
    )


@dataclass(frozen=True)
class _Pair:
    """A first effect and a second one beside it, whose fit has both."""

    first: Trial
    second: Trial

    @property
    def delta_bic(self) -> float:
        return self.first.delta_bic + self.second.delta_bic

    @property
    def names(self) -> tuple[str, str]:
        return self.first.name, self.second.name


def _pairs(
    firsts: Sequence[Trial],
    trials: Sequence[Trial],
    measurement: Measurement,
    level: float,
    progress: Callable[[], None],
) -> list[_Pair]:
    """Pairs of which the second effect is significant beside the first one, best first."""
    n_candidate = sum(trial.name != first.name for first in firsts for trial in trials)
    pairs = []
    for first in firsts:
        others = [trial.candidate for trial in trials if trial.name != first.name]
        for second in fitted(first.fit.problem, measurement, first.fit, others, progress, n_candidate):
            if second.p < level:
                pairs.append(_Pair(first, second))
    return sorted(pairs, key=lambda pair: -pair.delta_bic)


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
        return "ambiguous" if explained.rivals else "named"
    if lacks_fit:
        return "unknown"
    observable = [any(each.is_observable for each in parts) for _, parts in detectable.values()]
    return "not observable" if observable and np.mean(observable) < MIN_OBSERVABLE else "adequate"


def _split(explained: _Explained | None, d: int, progress: Callable[[], None]) -> Split | None:
    """What would tell the best effect or pair from its rivals, and these from each other."""
    if explained is None or not explained.rivals:
        return None
    own = " and ".join(candidate.name for candidate in explained.applied)
    return best_split({own: explained.fit, **explained.rivals}, d, progress)


def _collinearities(lead: Trial, trials: Sequence[Trial]) -> dict[str, float]:
    """Collinearity of the other effects with the best one, each at its most collinear location: by sensitivities, or where
    an effect is curved by what its fit has reached, since its deviance drop is cos² of that of the best."""
    found: dict[str, float] = {}
    for trial in trials:
        if trial.name != lead.name:
            reached = np.sqrt(min(trial.deviance_drop / lead.deviance_drop, 1.0))
            found[trial.name] = float(max(found.get(trial.name, 0.0), reached, collinearity(lead, trial.candidate)))
    return dict(sorted(found.items(), key=lambda item: -item[1]))
