"""The exam of methods: a Jeffcott rotor identified from synthetic data, by what they ask of it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins.identification import Identification, Method, Streams, at_limit
from ksmea.problem.counted import CountedProblem
from ksmea.testing.exam import Exam, ExamFailed, require
from ksmea.testing.jeffcott import Jeffcott, JeffcottRotor
from ksmea.testing.repeat import OF_DRAWS, Drawn
from ksmea.testing.settings import OF_SETTINGS
from ksmea.testing.surroundings import IN_A_SWEEP

ROTOR = JeffcottRotor()
NOISE = Noise(0.01, 0.0)  # small: where a method ends is its own doing
TIMES = ("model", "surrogate", "search", "total")


@dataclass(frozen=True)
class MethodCase(Drawn):
    """A method made of its parts, and what is stated of it.

    It comes within `error` of each true value (parts of the width of the limits). `budget` is given to a method that
    has a setting of that name; it is more than the samples of its design.
    """

    contract: ClassVar = Method
    plugin: Method
    budget: int = 80
    error: float = 0.1

    @property
    def truth(self) -> Array:
        return np.array([ROTOR.reference()[name] for name in Jeffcott.parameters.names])

    @property
    def measurement(self) -> Measurement:
        problem = ROTOR.build()
        values = observe(problem.response(self.truth[None])[0], "amplitude", NOISE, np.random.default_rng(1))
        return Measurement(problem.speed, problem.channels, values, NOISE, "exam")

    @cached_property
    def found(self) -> tuple[Identification, CountedProblem]:
        return self.identified()

    def identified(self, seed: int = 1, plugin: Method | None = None) -> tuple[Identification, CountedProblem]:
        """Result of the method, and the problem with its counts."""
        problem = CountedProblem(ROTOR.build())
        streams = Streams(*(np.random.default_rng([seed, part]) for part in range(3)))
        return (plugin or self.plugin).identify(problem, self.measurement, streams), problem

    def outcome(self, seed: int) -> Array:
        found, problem = self.identified(seed)
        return np.array([*found.x, found.misfit, found.updates, problem.meter.evaluations])


def works_on_the_problem(case: MethodCase) -> None:
    """The method says in `validate` that it suits a problem of five unknowns, and identifies it."""
    case.plugin.validate(ROTOR.build())
    found, _ = case.found
    require(isinstance(found, Identification), "an Identification", type(found).__name__, "return one")


def values_are_within_bounds(case: MethodCase) -> None:
    """Values are (d,) SI within their limits, and those at a limit are named."""
    found, _ = case.found
    parameters = Jeffcott.parameters
    u = parameters.to_cube(found.x) if np.shape(found.x) == (len(parameters),) else np.array([np.nan])
    require(
        np.all((u >= -1e-12) & (u <= 1 + 1e-12)),
        f"{len(parameters)} values within their limits, SI",
        f"{found.x}",
        "search in the unit cube, and end with problem.parameters.to_si(u)",
    )
    require(
        tuple(found.at_limit) == at_limit(u),
        f"at_limit = {at_limit(u)}",
        found.at_limit,
        "use ksmea.plugins.identification.at_limit",
    )


def records_what_it_used(case: MethodCase) -> None:
    """Evaluations and Jacobians equal the problem's counts; times, a misfit and a reason to stop exist."""
    found, problem = case.found
    count = problem.meter
    require(
        (found.model_evaluations, found.model_jacobians) == (count.evaluations, count.jacobians),
        f"{count.evaluations} evaluations and {count.jacobians} Jacobians, as asked of the problem",
        f"{found.model_evaluations} and {found.model_jacobians}",
        "ask by ksmea.problem.counted.Model, and record its counts",
    )
    require(np.isfinite(found.misfit), "a finite misfit", found.misfit, "take the misfit where it ends")
    require(set(found.seconds) >= set(TIMES), f"seconds of {', '.join(TIMES)}", sorted(found.seconds), "time each")
    require(found.stop, "a reason to stop", repr(found.stop), "name it: budget, optimizer, …")


def keeps_its_budget(case: MethodCase) -> None:
    """With a `budget` it evaluates the problem no more often."""
    limited: Any = {"budget": case.budget}  # a setting of this plugin, not of all
    _, problem = case.identified(plugin=dataclasses.replace(case.plugin, **limited))
    require(
        problem.meter.evaluations <= case.budget,
        f"at most {case.budget} evaluations",
        problem.meter.evaluations,
        "make the Model with its budget, Model(problem, self.budget), and ask that alone",
    )


def misaligned_problem_is_refused(case: MethodCase) -> None:
    """A problem that is not seen as the measurement is refused in one line."""
    problem = ROTOR.build()
    streams = Streams(*(np.random.default_rng(part) for part in range(3)))
    try:
        case.plugin.identify(problem.at(problem.speed + 1.0, problem.channels), case.measurement, streams)
    except SettingError as error:
        require("\n" not in str(error), "a refusal in one line", repr(str(error)), "say it in one")
        return
    except Exception as error:
        got = f"{type(error).__name__}: {error}"
    else:
        got = "an identification"
    raise ExamFailed(f"expected a SettingError at other speeds than measured, got {got}; call require_aligned first")


def finds_the_true_values(case: MethodCase) -> None:
    """With 1 % noise it ends as near to the true values as stated."""
    found, _ = case.found
    error = np.abs(found.x - case.truth) / Jeffcott.parameters.width
    require(
        np.all(error <= case.error),
        f"values within {case.error:g} of the limits' width",
        f"{Jeffcott.parameters.names[int(np.argmax(error))]} off by {np.max(error):.3g}",
        "mend it, or state what it reaches: error=…",
    )


def method_properties(case: MethodCase) -> Sequence[Callable[[MethodCase], None]]:
    has_budget = "budget" in {field.name for field in dataclasses.fields(case.plugin)}
    return (
        *OF_SETTINGS,
        *IN_A_SWEEP,
        works_on_the_problem,
        values_are_within_bounds,
        records_what_it_used,
        *([keeps_its_budget] if has_budget else []),
        misaligned_problem_is_refused,
        finds_the_true_values,
        *OF_DRAWS,
    )


check_method = Exam(MethodCase, method_properties)
