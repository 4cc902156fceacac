"""The diagnosis of a measurement: show what the model gets wrong, name the cause, extend the model, measure the gain.

1. The plain model is fitted from the whole box of its unknowns, and its residuals are tested for lack of fit.
2. Every effect, at every place where it may sit, is fitted jointly with all unknowns from where the plain model fits.
3. If the test or any effect speaks, effects are also sought all over their bounds, which moves sharp resonances.
4. Second effects are tried beside the best one: one that speaks as clearly as a first one is taken along. If the best
   effect does not leave noise behind, they are tried beside the next best ones too.
5. The verdict:
   - `adequate`: nothing speaks against the plain model, and the data would show effects if they were there;
   - `not observable`: nothing speaks, but most effects would not show in these data even at their physical limits;
   - `named`: one effect explains the data, none of the others comes near;
   - `ambiguous`: several explain it about as well, and what further measurement would split them;
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
from ksmea.diagnosis.fitting import BaselineFits, Effort, Fit, fit_baseline
from ksmea.diagnosis.gain import Gain, gain
from ksmea.diagnosis.observability import Detectable, Split, best_split, likeness, smallest_detectable
from ksmea.diagnosis.trials import Candidate, Trial, best_by_name, candidates, searched, tried
from ksmea.intervals import Estimate, estimate
from ksmea.maximisation import maximise, with_best_noise
from ksmea.measurement import Measurement

NEAR = 6.0  # ΔBIC within which effects cannot be told apart (Kass & Raftery 1995: strong evidence begins there)
MOST_PAIRED = 3  # effects that a second one is tried beside
MOVED = 0.01  # deviance by which intervals must have found a higher maximum for a fit to move there
LEAST_OBSERVABLE = 0.5  # part of the effects that must be observable for a model to be called adequate


@dataclass(frozen=True)
class Diagnosis:
    """What was found; `trials` are ranked, `named` and `alike` are names of effects, `best` is the extended fit that the
    verdict speaks of (None without one) with its effects in `applied`.

    `alike` is the class: the named effects and those that explain the data about as well, by their own fits (ΔBIC ≤ 6, or
    a deviance as low, whatever BIC charges for their unknowns) or because what the best one does to the data they can do
    too, as projected sensitivities have it. `places` are those where the best effect explains them about as well.
    `likeness` is the cosine between what the best effect does to the data and what each other one can do.
    """

    verdict: str
    named: tuple[str, ...]
    alike: tuple[str, ...]
    places: tuple[str, ...]
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
    likeness: Mapping[str, float]
    # by effect: its most promising place, and its unknowns there
    detectable: Mapping[str, tuple[str, tuple[Detectable, ...]]]
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
    half = level / 2
    found = candidates(problem, effects)
    if not found:
        raise ValueError("diagnosis: expected effects that the problem has a place for, got none")
    plain, quality, trials = _fitted(problem, measurement, found, half, rng, effort, progress)
    speaking = _speaking(trials, half)
    lead = speaking[0] if speaking else None
    likenesses = {} if lead is None else _likenesses(lead, trials)
    explained = (
        None if lead is None else _explained(lead, speaking, trials, likenesses, measurement, half, rng, progress)
    )
    best = best_estimate = best_quality = None
    if explained is not None:
        best, best_quality = explained.fit, explained.quality
        best_estimate = estimate(best.likelihood, best.point, level=interval_level)
        if best_estimate.deviance < best.deviance - MOVED:
            best = Fit(best.problem, best.likelihood, best_estimate.point)
            best_quality = fit_quality(best, rng)
    detectable = {
        name: (trial.place, tuple(smallest_detectable(plain.best, trial.candidate, half / len(found))))
        for name, trial in best_by_name(trials).items()
    }
    verdict = _verdict(quality.p < half, best_quality, explained, half, detectable)
    is_explained = explained is not None and verdict in ("named", "ambiguous")
    names = tuple(candidate.name for candidate in explained.applied) if is_explained else ()
    return Diagnosis(
        verdict=verdict,
        named=names,
        alike=tuple(dict.fromkeys([*names, *explained.rivals])) if is_explained else (),
        places=explained.places if is_explained else (),
        plain=plain.best,
        plain_estimate=estimate(plain.best.likelihood, plain.best.point, level=interval_level, check=False),
        plain_quality=quality,
        trials=tuple(trials),
        best=best,
        applied=() if explained is None else explained.applied,
        best_estimate=best_estimate,
        best_quality=best_quality,
        gain=None if best is None else gain(plain.best, best, n_block, progress),
        split=_split(explained) if verdict == "ambiguous" else None,
        likeness=likenesses,
        detectable=detectable,
        level=level,
    )


def _fitted(
    problem: Problem,
    measurement: Measurement,
    found: Sequence[Candidate],
    level: float,
    rng: np.random.Generator,
    effort: Effort,
    progress: Callable[[], None],
) -> tuple[BaselineFits, FitQuality, list[Trial]]:
    """The plain model's fits, their quality, and every candidate fitted: all over its bounds if anything speaks."""
    plain = fit_baseline(problem, measurement, rng, effort)
    progress()
    quality = fit_quality(plain.best, rng)
    trials = tried(problem, measurement, plain.best, found, progress)
    if quality.p >= level and not _speaking(trials, level):
        return plain, quality, trials
    trials = searched(trials, measurement, plain, effort, progress)
    better = _plain_from(trials, plain)
    if better is not plain:
        plain, quality = better, fit_quality(better.best, rng)
        trials = tried(problem, measurement, plain.best, found, progress)
        trials = searched(trials, measurement, plain, effort, progress)
    return plain, quality, trials


@dataclass(frozen=True)
class _Explained:
    """The best effect, or two, that the data are explained with; `rivals` do so about as well, by name of an effect that
    is not among these and with the fit that has it."""

    fit: Fit
    quality: FitQuality
    trials: tuple[Trial, ...]
    rivals: Mapping[str, Fit]
    places: tuple[str, ...]

    @property
    def applied(self) -> tuple[Candidate, ...]:
        return tuple(trial.candidate for trial in self.trials)


def _speaking(trials: Sequence[Trial], level: float) -> list[Trial]:
    """Trials that speak for their effect, by the chance of it and by BIC."""
    return [trial for trial in trials if trial.p < level and trial.delta_bic > 0]


def _plain_from(trials: Sequence[Trial], plain: BaselineFits) -> BaselineFits:
    """The plain model fitted from where the best effects put its unknowns, if that is better."""
    likelihood = plain.best.likelihood
    d = likelihood.d
    for trial in trials[:3]:
        point = maximise(likelihood, likelihood.start(trial.fit.u[:d]))
        if point.deviance < plain.best.deviance - 0.1:
            best = Fit(plain.best.problem, likelihood, with_best_noise(likelihood, point))
            plain = BaselineFits(best, (plain.best, *plain.others), plain.screened)
    return plain


def _explained(
    lead: Trial,
    speaking: Sequence[Trial],
    trials: Sequence[Trial],
    likenesses: Mapping[str, float],
    measurement: Measurement,
    level: float,
    rng: np.random.Generator,
    progress: Callable[[], None],
) -> _Explained:
    """The best pair of effects if the second one speaks for itself beside the first, or if the best effect alone does
    not leave noise behind and the pair does; else the best effect."""
    fit = _polished(lead.fit)
    quality = fit_quality(fit, rng)
    alone = _Explained(fit, quality, (lead,), _rivals(lead, trials, likenesses), _places(lead, trials))
    leaves_noise = quality.p >= level
    firsts = [lead] if leaves_noise else list(best_by_name(speaking).values())[:MOST_PAIRED]
    pairs = _pairs(firsts, trials, measurement, level, progress)
    for pair in [pair for pair in pairs if pair.delta_bic > lead.delta_bic + NEAR][:MOST_PAIRED]:
        fit = _polished(pair.second.fit)
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


def _rivals(lead: Trial, trials: Sequence[Trial], likenesses: Mapping[str, float]) -> dict[str, Fit]:
    """Other effects that explain the data about as well as the best: by their own fits, or by what sensitivities say
    that their best fit must reach, fall · cos², whatever their fit has found."""
    found = {}
    for name, trial in best_by_name(trials).items():
        charge = (trial.n_unknown - lead.n_unknown) * np.log(lead.fit.likelihood.n_residual)
        is_near = max(trial.delta_bic - lead.delta_bic, trial.fall - lead.fall) > -NEAR
        if name != lead.name and (is_near or lead.fall * (1 - likenesses[name] ** 2) + charge < NEAR):
            found[name] = trial.fit
    return found


def _places(lead: Trial, trials: Sequence[Trial]) -> tuple[str, ...]:
    """Where the best effect explains the data about as well, the best place first."""
    return tuple(trial.place for trial in trials if trial.name == lead.name and trial.delta_bic > lead.delta_bic - NEAR)


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
    """Pairs of which the second effect speaks beside the first one, best first."""
    n_tried = sum(trial.name != first.name for first in firsts for trial in trials)
    pairs = []
    for first in firsts:
        others = [trial.candidate for trial in trials if trial.name != first.name]
        for second in tried(first.fit.problem, measurement, first.fit, others, progress, n_tried):
            if second.p < level:
                pairs.append(_Pair(first, second))
    return sorted(pairs, key=lambda pair: -pair.delta_bic)


def _polished(fit: Fit) -> Fit:
    """The same fit, converged, with the best noise."""
    point = maximise(fit.likelihood, fit.point.theta)
    return Fit(fit.problem, fit.likelihood, with_best_noise(fit.likelihood, point))


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
    return "adequate" if np.mean(observable) >= LEAST_OBSERVABLE else "not observable"


def _split(explained: _Explained | None) -> Split | None:
    """What would tell the best effect or pair from its first rival."""
    if explained is None or not explained.rivals:
        return None
    return best_split(explained.fit, next(iter(explained.rivals.values())))


def _likenesses(lead: Trial, trials: Sequence[Trial]) -> dict[str, float]:
    """How alike the other effects are to the best one, the most alike place of each: by sensitivities, or where an effect
    bends as it grows by what its fit has reached, since a fall of the deviance is cos² of that of the best."""
    found: dict[str, float] = {}
    for trial in trials:
        if trial.name != lead.name:
            reached = np.sqrt(min(trial.fall / lead.fall, 1.0))
            found[trial.name] = float(max(found.get(trial.name, 0.0), reached, likeness(lead, trial.candidate)))
    return dict(sorted(found.items(), key=lambda item: -item[1]))
