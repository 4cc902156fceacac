"""The diagnosis of a measurement: show what the model gets wrong, name the cause, extend the model, measure the gain.

1. The plain model is fitted from the whole box of its unknowns, and its residuals are tested for lack of fit.
2. Every effect, at every place where it may sit, is fitted jointly with all unknowns from where the plain model fits.
3. If the test or any effect speaks, effects are also sought all over their bounds, which moves sharp resonances.
4. What is left over by the best effect is tested again; if it is not noise, a second effect is tried beside it.
5. The verdict:
   - `adequate`: nothing speaks against the plain model, and the data would show effects if they were there;
   - `not observable`: nothing speaks, but most effects would not show in these data even at their physical limits;
   - `named`: one effect explains the data, none of the others comes near;
   - `ambiguous`: several explain it about as well (within ΔBIC ≤ 6), and what further measurement would split them;
   - `unknown`: the model is wrong, and no effect or pair of effects leaves noise behind.

`level` is the chance of speaking against a right model. Half of it goes to the lack-of-fit test, half to the effects,
whose p-values are corrected for their number.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.contracts import Effect, Problem
from ksmea.diagnosis.fit_quality import FitQuality, fit_quality
from ksmea.diagnosis.fitting import Effort, Fit, PlainFits, fit_plain, with_best_noise
from ksmea.diagnosis.gain import Gain, gain
from ksmea.diagnosis.observability import Detectable, Split, best_split, likeness, smallest_detectable
from ksmea.diagnosis.trials import Candidate, Trial, best_by_name, candidates, searched, tried
from ksmea.intervals import Estimate, estimate
from ksmea.likelihood import maximise
from ksmea.measurement import Measurement

VERDICTS = ("adequate", "named", "ambiguous", "unknown", "not observable")
NEAR = 6.0  # ΔBIC within which effects cannot be told apart (Kass & Raftery 1995: strong evidence begins there)
ALIKE = 0.95  # cosine from which two effects are called alike
MOST_PAIRED = 3  # effects that a second one is tried beside
LEAST_OBSERVABLE = 0.5  # part of the effects that must be observable for a model to be called adequate


@dataclass(frozen=True)
class Diagnosis:
    """What was found; `trials` are ranked, `named` and `alike` are names of effects, `best` is the extended fit that the
    verdict speaks of (None without one) with its effects in `applied`."""

    verdict: str
    named: tuple[str, ...]
    alike: tuple[str, ...]  # the class: effects that explain the data about as well as the best, it included
    plain: Fit
    plain_estimate: Estimate
    plain_quality: FitQuality
    trials: tuple[Trial, ...]
    best: Fit | None
    applied: tuple[Candidate, ...]
    best_estimate: Estimate | None
    best_quality: FitQuality | None
    gain: Gain | None
    split: Split | None
    likeness: Mapping[str, float]  # of the other effects to the best one
    detectable: Mapping[str, tuple[Detectable, ...]]  # by effect, at its best place
    level: float


def diagnose(
    problem: Problem,
    measurement: Measurement,
    effects: Mapping[str, Effect],
    rng: np.random.Generator,
    *,
    level: float = 0.01,
    effort: Effort | None = None,
    n_block: int = 6,
    interval_level: float = 0.95,
    progress: Callable[[], None] = lambda: None,
) -> Diagnosis:
    """The diagnosis of a measurement by a problem and the effects that are known. `progress` is called at each step."""
    effort = effort or Effort()
    plain = fit_plain(problem, measurement, rng, effort)
    progress()
    quality = fit_quality(plain.best, rng)
    found = candidates(problem, effects)
    trials = tried(problem, measurement, plain.best, found, progress)
    half = level / 2
    if quality.p < half or trials[0].p < half:
        trials = searched(trials, measurement, plain, effort, progress)
        better = _plain_from(trials, plain)
        if better is not plain:
            plain, quality = better, fit_quality(better.best, rng)
            trials = tried(problem, measurement, plain.best, found, progress)
            trials = searched(trials, measurement, plain, effort, progress)
    best, applied, best_quality, rivals = None, (), None, ()
    speaks = [trial for trial in trials if trial.p < half]
    if speaks:
        best, applied, best_quality, rivals = _explained(speaks, trials, measurement, half, rng, progress)
    detectable = {
        name: tuple(smallest_detectable(plain.best, trial.candidate, half / len(found)))
        for name, trial in best_by_name(trials).items()
    }
    verdict = _verdict(quality.p < half, best_quality, rivals, half, detectable)
    names = tuple(candidate.name for candidate in applied)
    explained = verdict in ("named", "ambiguous")
    lead = speaks[0] if speaks else None
    return Diagnosis(
        verdict=verdict,
        named=names if explained else (),
        alike=tuple(dict.fromkeys([*names, *rivals])) if explained else (),
        plain=plain.best,
        plain_estimate=estimate(plain.best.likelihood, plain.best.point, level=interval_level, check=False),
        plain_quality=quality,
        trials=tuple(trials),
        best=best,
        applied=applied,
        best_estimate=None if best is None else estimate(best.likelihood, best.point, level=interval_level),
        best_quality=best_quality,
        gain=None if best is None else gain(plain.best, best, n_block, progress),
        split=_split(trials, rivals) if verdict == "ambiguous" else None,
        likeness={} if lead is None else _likenesses(lead, trials),
        detectable=detectable,
        level=level,
    )


def _plain_from(trials: Sequence[Trial], plain: PlainFits) -> PlainFits:
    """The plain model fitted from where the best effects put its unknowns, if that is better."""
    likelihood = plain.best.likelihood
    d = likelihood.d
    for trial in trials[:3]:
        point = maximise(likelihood, likelihood.start(trial.fit.u[:d]))
        if point.deviance < plain.best.deviance - 0.1:
            best = Fit(plain.best.problem, likelihood, with_best_noise(likelihood, point))
            plain = PlainFits(best, (plain.best, *plain.others), plain.screened)
    return plain


def _explained(
    speaks: Sequence[Trial],
    trials: Sequence[Trial],
    measurement: Measurement,
    level: float,
    rng: np.random.Generator,
    progress: Callable[[], None],
) -> tuple[Fit, tuple[Candidate, ...], FitQuality, tuple[str, ...]]:
    """The best effect, or pair of effects, that leaves noise behind; its quality, and the names of its rivals."""
    lead = speaks[0]
    fit = _polished(lead.fit)
    quality = fit_quality(fit, rng)
    if quality.p >= level:
        rivals = [trial.name for trial in speaks if trial.delta_bic > lead.delta_bic - NEAR and trial.name != lead.name]
        return fit, (lead.candidate,), quality, tuple(dict.fromkeys(rivals))
    pairs = []
    for first in list(best_by_name(speaks).values())[:MOST_PAIRED]:
        others = [trial.candidate for trial in trials if trial.name != first.name]
        for second in tried(first.fit.problem, measurement, first.fit, others, progress):
            if second.p < level:
                pairs.append((first, second, first.delta_bic + second.delta_bic))
    pairs.sort(key=lambda pair: -pair[2])
    if pairs:
        first, second, worth = pairs[0]
        pair_fit = _polished(second.fit)
        pair_quality = fit_quality(pair_fit, rng)
        if pair_quality.p >= level:
            names = {first.name, second.name}
            near = [{one.name, two.name} for one, two, other in pairs[1:] if other > worth - NEAR]
            rivals = sorted({name for pair in near for name in pair if pair != names} - names)
            return pair_fit, (first.candidate, second.candidate), pair_quality, tuple(rivals)
    return fit, (lead.candidate,), quality, ()


def _polished(fit: Fit) -> Fit:
    """The same fit, converged, with the best noise."""
    point = maximise(fit.likelihood, fit.point.theta)
    return Fit(fit.problem, fit.likelihood, with_best_noise(fit.likelihood, point))


def _verdict(
    lacks_fit: bool,
    best_quality: FitQuality | None,
    rivals: Sequence[str],
    level: float,
    detectable: Mapping[str, Sequence[Detectable]],
) -> str:
    if best_quality is not None:
        if best_quality.p < level:
            return "unknown"
        return "ambiguous" if rivals else "named"
    if lacks_fit:
        return "unknown"
    observable = [any(each.is_observable for each in parts) for parts in detectable.values()]
    return "adequate" if np.mean(observable) >= LEAST_OBSERVABLE else "not observable"


def _split(trials: Sequence[Trial], rivals: Sequence[str]) -> Split | None:
    """What would tell the best effect from its first rival."""
    best = best_by_name(trials)
    return best_split(trials[0], best[rivals[0]]) if rivals[0] in best else None


def _likenesses(lead: Trial, trials: Sequence[Trial]) -> dict[str, float]:
    """How alike the other effects are to the best one, the most alike place of each."""
    found: dict[str, float] = {}
    for trial in trials:
        if trial.name != lead.name:
            found[trial.name] = max(found.get(trial.name, 0.0), likeness(lead, trial.candidate))
    return dict(sorted(found.items(), key=lambda item: -item[1]))
