"""Trials: one effect at one location, fitted with all unknowns; explanations ranked by evidence.

Two explanations cannot be distinguished if one is within ΔBIC ≤ 6 of the other (Kass & Raftery 1995), or if its deviance is as
low: the penalty of BIC for further unknowns is not evidence in the data.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
import scipy

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.fits.fitting import (
    TRIAL_ITERATIONS,
    BaselineFits,
    Fit,
    fit_by_elimination,
    fit_from,
    fit_from_points,
    fit_from_scan,
    fit_on,
    least_deviance,
    nearby,
    promised_from,
    start_nearby,
    without_effects,
)
from ksmea.fits.path_fits import fit_along
from ksmea.fits.search import Effort, Search
from ksmea.fits.stable_fits import better_stable, stable_fit
from ksmea.location.force_start import can_recover, starts_from_force
from ksmea.numerics.parallel import Workers
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.problem import Problem

MOST_LISTED = 10  # effects that an error names
TIE = 0.1  # of ΔBIC: trials that are as near as this go by name, so that rounding chooses no first one
FAR = 50.0  # above the deviance of the most promising trial: fits that end there are no rivals, and need no end


@dataclass(frozen=True)
class Candidate:
    """A registered effect at one location."""

    name: str
    effect: AnyEffect

    def beside(self, problem: Problem) -> Problem | None:
        """The problem with the effect; None if it cannot act together with the effects that the problem has."""
        try:
            return self.effect.added_to(problem)
        except SettingError:
            return None


@dataclass(frozen=True)
class Trial:
    """A candidate's fit compared with the model without it.

    `deviance_drop` is how much lower its deviance is; `p` is the chance of as large a drop if the effect is absent,
    corrected for the number of candidates; `delta_bic` > 0 is evidence for the effect.
    """

    candidate: Candidate
    fit: Fit
    deviance_drop: float
    delta_bic: float
    p: float

    @property
    def name(self) -> str:
        return self.candidate.name

    @property
    def location(self) -> str:
        return str(self.candidate.effect)

    @property
    def n_unknown(self) -> int:
        """Unknowns that the effect brought along, the last of the fit's."""
        return len(self.candidate.effect.parameters(self.fit.problem.machine))


def candidates(problem: Problem, effects: Mapping[str, AnyEffect]) -> list[Candidate]:
    """Every effect at every location that the problem offers.

    Effects that the problem has already, and effects that do not fit it, are left out.
    """
    return candidates_and_left_out(problem, effects)[0]


def candidates_and_left_out(
    problem: Problem, effects: Mapping[str, AnyEffect]
) -> tuple[list[Candidate], Mapping[str, str]]:
    """The candidates, and why an effect is not among them that raises on this problem, by its name.

    One that fits other problems must not take the diagnosis of this one away.
    """
    found: list[Candidate] = []
    left_out = {}
    for name, effect in effects.items():
        try:
            found += _located(name, effect, problem)
        except Exception as error:  # whatever an effect for other problems does with it
            left_out[name] = " ".join(f"does not fit this problem: {type(error).__name__}: {error}".split())
    return found, left_out


def none_located(effects: Mapping[str, AnyEffect]) -> str:
    """Error text for effects without any location."""
    if len(effects) > MOST_LISTED:
        return (
            f"expected a problem that effects can act on, got one on which none of {len(effects)} can; take one that is made of a rotor,"
            " or give effects of its own"
        )
    advice = "; ".join(dict.fromkeys(effect.if_nowhere for effect in effects.values()))
    return f"expected effects that this problem has a location for and does not have already, got {', '.join(effects)}; {advice}"


def _located(name: str, effect: AnyEffect, problem: Problem) -> list[Candidate]:
    """One effect at every location at which the problem does not have it, tried by adding it."""
    known = set(problem.parameters.names)
    found = []
    for located in effect.locations(problem.machine):
        try:
            located.added_to(problem)
        except SettingError:
            if known.isdisjoint(parameter.name for parameter in located.parameters(problem.machine)):
                raise
        else:
            found.append(Candidate(name, located))
    return found


def trial_of(candidate: Candidate, fit: Fit, without: Fit, n_candidate: int) -> Trial:
    """The trial of one more effect, from the fit with it and the fit without."""
    n = fit.likelihood.n_residual
    e = fit.likelihood.d - without.likelihood.d
    drop = max(without.deviance - fit.deviance, 0.0)
    # The noise is estimated along: the drop is n ln(1 + e F/(n − d)) in a linear model, about χ² when scaled by (n − d)/n
    scaled = drop * (n - fit.likelihood.n_free) / n if fit.likelihood.noise_is_estimated else drop
    p = min(1.0, n_candidate * float(scipy.stats.chi2.sf(scaled, e)))
    evidence = drop if not len(fit.inputs) else without.marginal_deviance - fit.marginal_deviance
    return Trial(candidate, fit, drop, float(evidence - e * np.log(n)), p)


def fitted(
    without: Fit,
    found: Sequence[Candidate],
    search: Search,
    *,
    n_candidate: int | None = None,
    max_iterations: int = TRIAL_ITERATIONS,
    limit: float = np.inf,
    most: int | None = None,
) -> list[Trial]:
    """Fits of all candidates below a deviance limit, or of the `most` best ones, highest ΔBIC first.

    Candidates are ordered by their first step and fitted from the fit of the model without them. `n_candidate` is the
    number that p is corrected for; default: the number of candidates. The one with the best first step is fitted first:
    it shows which of the others, which processes share, are no rivals.
    """

    def tried(entry: tuple[Candidate, Fit], below: float) -> Trial | None:
        candidate, start = entry
        with suppress(np.linalg.LinAlgError):  # on the way an effect may leave the rotor no steady motion
            fit = fit_on(start, without, max_iterations, below)
            if fit.deviance < limit:
                fit = stable_fit(fit, start.point.theta, below)
            if fit.deviance < limit:
                return trial_of(candidate, fit, without, n_candidate or len(found))
        return None

    entries = _most_promising_first(without, found)[:most]
    trials = search.workers.each(partial(tried, below=limit), entries[:1])
    ceiling = min([limit, *(trial.fit.deviance + FAR for trial in trials if trial is not None)])
    known = [thing for candidate, start in entries for thing in (candidate, *start.known)]
    trials += search.workers.each(partial(tried, below=ceiling), entries[1:], known)
    return ranked(trial for trial in trials if trial is not None)


def _most_promising_first(without: Fit, found: Sequence[Candidate]) -> list[tuple[Candidate, Fit]]:
    """Candidates that can act in addition to a problem's effects, with starts, by their first step.

    No processes share this: whatever is solved here once, all have from then on.
    """
    promising = []
    for candidate in found:
        if (extended := candidate.beside(without.problem)) is not None:
            with suppress(np.linalg.LinAlgError):  # one without a steady motion where the model fits is no candidate
                start = nearby(extended, without)
                promising.append((promised_from(start), candidate, start))
    return [(candidate, start) for _, candidate, start in sorted(promising, key=lambda entry: -entry[0])]


def refined(
    trials: Sequence[Trial],
    baseline: BaselineFits,
    search: Search,
    is_enough: Callable[[Fit], bool] = lambda fit: False,
) -> list[Trial]:
    """Trials, each with the better of its fit and further ones (`searched`).

    Further fits also start from the unknowns of the baseline model's other maxima and of the best trials. Processes share them,
    once it is known how far the first one comes. If its fit is enough, the others start from its unknowns and are not scanned: what
    explains the data as well has its unknowns near these, or comes to them from the baseline model as it did.
    """
    starts = [*baseline.others, *(trial.fit for trial in trials[:2])]

    def again(trial: Trial, ceiling: float, starts: Sequence[Fit], effort: Effort) -> Trial:
        jumps = trial.fit.problem.parameters.makes_jumps  # what is cheap is searched anyway
        if jumps and least_deviance(trial.fit, lead, baseline.best.likelihood.d) > ceiling:
            return trial_of(trial.candidate, trial.fit, baseline.best, len(trials))
        return searched(trial, baseline, effort, len(trials), starts, ceiling)

    effort = search.effort
    lead = min((trial.fit for trial in trials), key=lambda fit: fit.deviance, default=baseline.best)
    first = partial(again, ceiling=lead.deviance + FAR, starts=starts, effort=effort)
    better = search.workers.each(first, trials[:1])
    lead = min([lead, *(trial.fit for trial in better)], key=lambda fit: fit.deviance)
    if better and effort.is_scanned and is_enough(better[0].fit):
        effort, starts = dataclasses.replace(effort, is_scanned=False), [better[0].fit, *starts]
    rest = partial(again, ceiling=lead.deviance + FAR, starts=starts, effort=effort)
    better += shared(rest, trials[1:], search.workers)
    return ranked(better)


def shared(search: Callable[[Trial], Trial], trials: Sequence[Trial], workers: Workers) -> list[Trial]:
    """Searches for better fits of trials, shared among processes."""
    return workers.each(
        search, trials, [thing for trial in trials for thing in (trial, trial.candidate, *trial.fit.known)]
    )


def searched(
    trial: Trial,
    baseline: BaselineFits,
    effort: Effort,
    n_candidate: int,
    starts: Sequence[Fit] = (),
    ceiling: float = np.inf,
) -> Trial:
    """A trial with the better of its fit and further ones.

    Along the effect's path, from its force as that is recovered from the data, from a scan of its whole range where it
    needs that, and else, or where the effort leaves these out, from the unknowns of other fits. Searches that lead to
    deviances above `ceiling` are left early.
    """
    case, fit, best, without = trial.fit.case, trial.fit, trial.fit, baseline.best.case
    path, force = trial.candidate.effect.path(without.problem.machine), trial.candidate.effect.force_at()
    shows_force = force is not None and can_recover(without, force[0])
    with suppress(np.linalg.LinAlgError):  # within its limits an effect may leave the rotor no steady motion
        points = np.empty((0, len(fit.u)))
        if force is not None and shows_force and effort.from_force:
            points = starts_from_force(case, without, *force, ceiling, near=baseline.best.x)
        if len(path):
            fit = fit_along(case, baseline, path, effort)
        elif len(points):
            fit = fit_from_points(case, points, effort, ceiling, fit.deviance)
        elif effort.is_scanned and trial.candidate.effect.adds_readings and not case.measurement.is_amplitude:
            fit = fit_by_elimination(fit, baseline, effort, ceiling)
        elif effort.is_scanned and not shows_force and trial.candidate.effect.is_scanned:
            fit = fit_from_scan(
                fit, baseline, effort, ceiling, trial.candidate.effect.scan_further(without.problem.machine)
            )
        elif starts:
            fit = fit_from(fit, starts, baseline, effort, ceiling)
        best = better_stable(best, fit, start_nearby(case.problem, baseline.best), min(ceiling, best.deviance))
    return trial_of(trial.candidate, best, baseline.best, n_candidate)


def ranked(trials: Iterable[Trial]) -> list[Trial]:
    """Highest ΔBIC first, but for ties."""
    return sorted(trials, key=lambda trial: (-round(trial.delta_bic / TIE), trial.name, -trial.delta_bic))


def best_by_name(trials: Sequence[Trial]) -> dict[str, Trial]:
    """The best location of each effect, highest ΔBIC first."""
    best: dict[str, Trial] = {}
    for trial in ranked(trials):
        best.setdefault(trial.name, trial)
    return best


BETTER = 0.1  # of the deviance: a maximum that is as much higher is another one
AT_LIMIT = 1e-4  # of the range of an unknown, from a limit or from 0, within which it counts as being there
NEAR = 6.0  # ΔBIC within which effects cannot be told apart (Kass & Raftery 1995: strong evidence begins there)


@dataclass(frozen=True)
class Explanation:
    """Effects at their locations, the fit of the model that has them, and its deviance drop.

    The drop is from the baseline model; `p` belongs to the last effect, given the others, corrected for the number of
    candidates.
    """

    applied: tuple[Candidate, ...]
    fit: Fit
    deviance_drop: float
    delta_bic: float
    n_unknown: int  # of the effects
    p: float

    @classmethod
    def of(cls, trial: Trial) -> Explanation:
        return cls((trial.candidate,), trial.fit, trial.deviance_drop, trial.delta_bic, trial.n_unknown, trial.p)

    @classmethod
    def of_pair(cls, first: Trial, second: Trial) -> Explanation:
        """A trial of a second effect combined with the trial of a first one."""
        return cls(
            (first.candidate, second.candidate),
            second.fit,
            first.deviance_drop + second.deviance_drop,
            first.delta_bic + second.delta_bic,
            first.n_unknown + second.n_unknown,
            second.p,
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its effects, in alphabetical order."""
        return tuple(sorted(candidate.name for candidate in self.applied))

    @property
    def location(self) -> str:
        """Locations of its effects, in the order of their names."""
        return " and ".join(
            str(each.effect) for each in sorted(self.applied, key=lambda each: (each.name, str(each.effect)))
        )

    @property
    def label(self) -> str:
        """Its effects for people; where they have one name, with their locations."""
        if len(set(self.names)) < len(self.names):
            return " and ".join(f"{each.name} {each.effect}" for each in self.applied)
        return " and ".join(each.name for each in self.applied)

    @property
    def has_sizes(self) -> bool:
        """Whether each of its effects has a size within its limits.

        One that ends where it does nothing, or on a limit, does not belong to an explanation. Of limits at 0, as of a
        mass or a loss factor, fewer than half may be met.
        """
        n = len(self.fit.u) - self.n_unknown
        u, zero = self.fit.u[n:], without_effects(self.fit.problem, n)
        return all(_has_size(u[own], zero[own]) for own in self.own_unknowns)

    @property
    def own_unknowns(self) -> list[slice]:
        """The place of each of its effects among the unknowns of all of them."""
        machine = self.fit.problem.machine
        ends = np.cumsum([0, *(len(each.effect.parameters(machine)) for each in self.applied)])
        return [slice(start, stop) for start, stop in pairwise(ends)]

    def is_same(self, other: Explanation) -> bool:
        """Whether it has the same effects at the same locations, in whatever order."""
        return len(self.applied) == len(other.applied) and all(each in other.applied for each in self.applied)

    def is_near(self, other: Explanation) -> bool:
        """Whether it explains the data about as well as another one, or better."""
        return max(self.delta_bic - other.delta_bic, self.deviance_drop - other.deviance_drop) > -NEAR


def _has_size(u: Array, zero: Array) -> bool:
    """Whether unknowns of an effect (e,) in the unit cube are within limits and differ from `zero`.

    At `zero` the model is as without it.
    """
    is_zero = np.abs(u - zero) < AT_LIMIT
    is_limit = (u < AT_LIMIT) | (u > 1 - AT_LIMIT)
    return not (np.all(is_zero) or np.any(is_limit & ~is_zero) or 2 * np.sum(is_limit & is_zero) >= max(len(u), 1))


def ranked_explanations(found: Iterable[Explanation]) -> list[Explanation]:
    """Different ones, highest ΔBIC first; of the same effects the best fit."""
    different: list[Explanation] = []
    for each in sorted(found, key=lambda each: -each.delta_bic):
        if not any(each.is_same(other) for other in different):
            different.append(each)
    return different


def best_of_names(found: Sequence[Explanation]) -> list[Explanation]:
    """The first location of each set of effects."""
    first: dict[tuple[str, ...], Explanation] = {}
    for each in found:
        first.setdefault(each.names, each)
    return list(first.values())
