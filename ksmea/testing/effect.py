"""Contract test of effects: nothing at zero, draws within limits, a usual problem at each site."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.plugins.effect import AnyEffect, Effect
from ksmea.plugins.source import ProblemSettings
from ksmea.problem.problem import Problem
from ksmea.testing.exam import Exam, ExamFailed, require
from ksmea.testing.jeffcott import Jeffcott
from ksmea.testing.seen import SAME, ProblemCase, Seen, gives_a_problem, properties_of_problems
from ksmea.testing.settings import OF_SETTINGS

N_DRAW = 20
LEAST_CHANGE = 1e-6  # of the response, by what is drawn: less is no effect at all


@dataclass(frozen=True)
class EffectCase(ProblemCase):
    """An effect, and the problem `on` which it is tried: at its first and its last location there."""

    contract: ClassVar = Effect
    plugin: AnyEffect
    on: ProblemSettings

    @cached_property
    def baseline(self) -> Problem:
        return self.on.build()

    @property
    def x(self) -> Array:
        """Published values of the baseline model, or the middle of its limits if they are not known, (d,) SI."""
        parameters, known = self.baseline.parameters, self.on.reference()
        middle = parameters.to_si(np.full(len(parameters), 0.5))
        return np.array([known.get(name, value) for name, value in zip(parameters.names, middle)])

    @cached_property
    def sites(self) -> tuple[AnyEffect, ...]:
        located = list(self.plugin.locations(self.baseline)) or [self.plugin]
        return tuple(located[:1] + located[1:][-1:])

    @cached_property
    def seen(self) -> Sequence[Seen]:
        return tuple(
            Seen(
                f" {site}",
                site.added_to(self.baseline),
                np.array([[*self.x, *self.drawn(site, seed)] for seed in (1, 2)]),
            )
            for site in self.sites
        )

    def drawn(self, site: AnyEffect, seed: int) -> Array:
        return site.draw(self.baseline, np.random.default_rng(seed))


def sites_have_names(case: EffectCase) -> None:
    """Each location has a name of its own."""
    names = [str(site) for site in case.plugin.locations(case.baseline)]
    require(len(set(names)) == len(names), "a name of its own for each site", names, "say where in __str__")


def unknowns_follow_and_hold_zero(case: EffectCase) -> None:
    """Its unknowns come after the unknowns of the problem, and 0 lies between their limits."""
    names = case.baseline.parameters.names
    for site, seen in zip(case.sites, case.seen):
        found = seen.problem.parameters
        own = site.parameters(case.baseline)
        require(
            found.names[: len(names)] == names and len(found) == len(names) + len(own),
            f"{len(own)} unknowns after {', '.join(names)}{seen.label}",
            ", ".join(found.names),
            "add them at the end",
        )
        for item in found.items[len(names) :]:
            holds = item.lower <= 0 <= item.upper
            require(holds, f"limits of {item.name} around 0", f"[{item.lower:g}, {item.upper:g}]", "measure from none")


def zero_is_the_baseline(case: EffectCase) -> None:
    """At 0 of its unknowns the response is as without it."""
    expected = case.baseline.response(case.x[None])
    for seen in case.seen:
        zero = np.concatenate([case.x, np.zeros(seen.x.shape[1] - len(case.x))])
        error = seen.difference(seen.problem.response(zero[None]), expected)
        require(error < SAME, f"the baseline's response at 0{seen.label}", f"another by {error:.2g}", "let 0 be none")


def draws_within_its_limits(case: EffectCase) -> None:
    """Sizes drawn for hidden data are within its limits, from the given generator, and not 0."""
    for site, seen in zip(case.sites, case.seen):
        own = seen.problem.parameters.items[len(case.x) :]
        draws = np.array([case.drawn(site, seed) for seed in range(N_DRAW)])
        require(draws.shape == (N_DRAW, len(own)), f"{len(own)} values{seen.label}", draws.shape, "one an unknown")
        within = np.all([item.lower for item in own] <= draws) and np.all(draws <= [item.upper for item in own])
        require(
            within, f"draws within the limits, SI{seen.label}", f"{draws!r:.60}", "narrow them, or widen the limits"
        )
        require(np.all(np.any(draws != 0, axis=1)), f"draws that are not 0{seen.label}", "0", "draw a size")
        again = np.array_equal(draws[3], case.drawn(site, 3))
        require(again, f"the same draw by the same seed{seen.label}", "another", "draw from rng alone")


def what_is_drawn_matters(case: EffectCase) -> None:
    """The drawn size changes the response, and the baseline model stays as it was."""
    expected = case.on.build().response(case.x[None])
    for seen in case.seen:
        change = seen.difference(seen.response, expected)
        require(change > LEAST_CHANGE, f"another response{seen.label}", f"a change by {change:.2g}", "use its unknowns")
    unchanged = np.array_equal(case.baseline.response(case.x[None]), expected)
    require(unchanged, "a baseline model as before", "another", "return a new problem, and change none")


def another_problem_is_refused(case: EffectCase) -> None:
    """A kind of problem that it knows nothing of is refused in one line, or takes it."""
    try:
        case.plugin.added_to(Jeffcott())
    except SettingError as error:
        require(
            "\n" not in str(error), "a refusal in one line", repr(str(error)), "say what was expected and what came"
        )
    except Exception as error:
        raise ExamFailed(
            f"expected a SettingError for a problem of another kind, got {type(error).__name__}: {error}; check it with"
            " isinstance in added_to"
        ) from error


def effect_properties(case: EffectCase) -> Sequence[Callable[[EffectCase], None]]:
    if not case.can_be_seen:
        return (*OF_SETTINGS, gives_a_problem)
    return (
        *OF_SETTINGS,
        sites_have_names,
        unknowns_follow_and_hold_zero,
        zero_is_the_baseline,
        draws_within_its_limits,
        what_is_drawn_matters,
        another_problem_is_refused,
        *properties_of_problems(case),
    )


check_effect = Exam(EffectCase, effect_properties)
