"""The exam of problems: what they build, between all their limits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.plugins.source import ProblemSettings
from ksmea.testing.exam import Exam, require
from ksmea.testing.seen import ProblemCase, Seen, gives_a_problem, properties_of_problems
from ksmea.testing.settings import OF_SETTINGS

N_POINTS = 4  # drawn between the limits


@dataclass(frozen=True)
class BuiltCase(ProblemCase):
    """Settings that build a problem."""

    contract: ClassVar = ProblemSettings
    plugin: ProblemSettings

    @cached_property
    def seen(self) -> Sequence[Seen]:
        """Seen at the published values, where all are known, and at others between the limits."""
        problem = self.plugin.build()
        drawn = problem.parameters.to_si(np.random.default_rng(1).random((N_POINTS, len(problem.parameters))))
        return (Seen("", problem, np.concatenate([self.reference, drawn])),)

    @property
    def reference(self) -> Array:
        """The published values, (1, d) SI, or (0, d) where one is missing."""
        names, known = self.plugin.build().parameters.names, self.plugin.reference()
        return np.array([[known[name] for name in names]] if set(names) <= set(known) else []).reshape(-1, len(names))


def published_values_are_between_the_limits(case: BuiltCase) -> None:
    """Published values are in SI, between the limits of unknowns of that name."""
    by_name = {item.name: item for item in case.seen[0].problem.parameters}
    for name, value in case.plugin.reference().items():
        if name in by_name:
            item = by_name[name]
            require(
                item.lower <= value <= item.upper,
                f"a reference of {name} from {item.lower:g} to {item.upper:g} SI",
                f"{value:g}",
                f"give it in SI: times {item.si_per_unit:g} if it is in {item.unit}",
            )


def responds_at_its_limits(case: BuiltCase) -> None:
    """The response is finite also where all unknowns are at a limit."""
    seen = case.seen[0]
    parameters = seen.problem.parameters
    alternating = np.arange(len(parameters)) % 2
    corners = np.array([np.zeros(len(parameters)), np.ones(len(parameters)), alternating, 1 - alternating])
    found = seen.problem.response(parameters.to_si(corners))
    require(
        np.all(np.isfinite(found)),
        "finite responses at the limits",
        "NaN or infinity",
        "narrow the limits: searches go there",
    )


def builds_the_same_again(case: BuiltCase) -> None:
    """A problem built again responds alike."""
    seen = case.seen[0]
    again = case.plugin.build().response(seen.x)
    require(np.array_equal(again, seen.response), "the same response", "another", "draw and keep nothing in build")


def published_machine_is_stable(case: BuiltCase) -> None:
    """At the published values the rotor is stable at every speed."""
    problem = case.seen[0].problem
    for x in case.reference:
        require(
            problem.is_stable(x),
            "growth rates below 0 at the published values",
            f"growth from {problem.stability_threshold(x, float(np.max(problem.speed))):.4g} rad/s on",
            "look at the sign of growth_rate, and at the damping",
        )


def built_properties(case: BuiltCase) -> Sequence[Callable[[BuiltCase], None]]:
    if not case.can_be_seen:
        return (*OF_SETTINGS, gives_a_problem)
    return (
        *OF_SETTINGS,
        *properties_of_problems(case),
        published_values_are_between_the_limits,
        responds_at_its_limits,
        builds_the_same_again,
        *([published_machine_is_stable] if case.seen[0].problem.knows_stability else []),
    )


check_problem = Exam(BuiltCase, built_properties)
