"""Properties of every problem, also with an effect.

Units, shapes, batches, sensitivity, other speeds, stability.
"""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.problem.parameters import PHASE_ORIGIN, Parameter
from ksmea.problem.problem import Problem
from ksmea.testing.exam import Case, require
from ksmea.units import SI_PER_UNIT

SI_SIZES = {name: size for sizes in SI_PER_UNIT.values() for name, size in sizes.items()}
SAME = 1e-8  # of the largest response: solvers may sum in another order, and needles magnify rounding
BY_ROUTE = 1e-6  # the same, between two ways to solve
STEP = 1e-4  # of the value, for differences of sixth order: their error is that of rounding
STEPS, WEIGHTS = (-3, -2, -1, 1, 2, 3), (-1 / 60, 3 / 20, -3 / 4, 3 / 4, -3 / 20, 1 / 60)
SENSITIVITY = 5e-3  # of the largest entry of a column: responses with contacts have corners
ROUNDING = 1e-9  # of a response, which a step divides


@dataclass(frozen=True)
class Seen:
    """A problem that a plugin makes, and points (n, d) SI at which it is looked at.

    `label` ends messages with where an effect sits: '' or ' at 0.5 m'.
    """

    label: str
    problem: Problem
    x: Array

    @cached_property
    def response(self) -> ComplexArray:
        return self.problem.response(_fixed(self.x))

    def difference(self, found: Array | ComplexArray, expected: Array | ComplexArray) -> float:
        """Largest difference over the largest response."""
        return float(np.max(np.abs(found - expected)) / np.max(np.abs(self.response)))


@dataclass(frozen=True)
class ProblemCase(Case):
    """A plugin that makes problems."""

    @property
    @abstractmethod
    def seen(self) -> Sequence[Seen]: ...

    @property
    def can_be_seen(self) -> bool:
        try:
            return bool(self.seen)
        except Exception:
            return False


def gives_a_problem(case: ProblemCase) -> None:
    """The plugin gives a problem, with which all else is tried."""
    require(case.seen, "a problem", "none", "look at what it raises")


def unknowns_have_units(case: ProblemCase) -> None:
    """Unknowns have names that are words, each its own, and units whose size in SI is right."""
    for seen in case.seen:
        items = seen.problem.parameters.items
        names = [item.name for item in items]
        require(len(set(names)) == len(names), "a name of its own for each unknown", names, "name them apart")
        for item in items:
            _require_unit(item)


def _require_unit(item: Parameter) -> None:
    require(
        re.fullmatch(r"\w+", item.name), "names of letters, digits and _", repr(item.name), "settings are given by them"
    )
    require(item.unit.strip(), f"a unit of {item.name}", "none", "say in which it is shown; a ratio is in %")
    size = SI_SIZES.get(item.unit, item.si_per_unit)
    require(
        item.si_per_unit > 0 and np.isclose(item.si_per_unit, size, rtol=1e-9),
        f"si_per_unit = {size:g} of {item.name}, which is in {item.unit}",
        f"{item.si_per_unit:g}",
        "take it from ksmea.units; limits are in SI",
    )


def responds_in_shape(case: ProblemCase) -> None:
    """Points (n, d) give finite complex responses (n, n_speed, n_channel), and are not written into."""
    for seen in case.seen:
        expected = (len(seen.x), len(seen.problem.speed), len(seen.problem.channels))
        found = seen.response
        require(
            found.shape == expected,
            f"responses {expected}{seen.label}",
            found.shape,
            "treat x as (n, d), one set a row",
        )
        require(np.iscomplexobj(found), f"complex responses{seen.label}", found.dtype, "keep the phase: Re(q e^{iΩt})")
        require(
            np.all(np.isfinite(found)) and np.any(found != 0),
            f"finite responses, not all 0{seen.label}",
            "others",
            "look where it divides; x is in SI",
        )


def batch_equals_single(case: ProblemCase) -> None:
    """Several points at once give what each gives alone."""
    for seen in case.seen:
        alone = np.concatenate([seen.problem.response(_fixed(x[None])) for x in seen.x])
        error = seen.difference(alone, seen.response)
        require(
            error < SAME, f"the same responses one by one{seen.label}", f"others by {error:.2g}", "treat rows apart"
        )


def sensitivity_is_right(case: ProblemCase) -> None:
    """The sensitivity agrees with differences of the response, and `linearised` returns both."""
    for seen in case.seen:
        problem, x = seen.problem, _fixed(seen.x[0])
        found = problem.sensitivity(x)
        shape = (*seen.response.shape[1:], len(x))
        require(found.shape == shape, f"a sensitivity {shape}{seen.label}", found.shape, "put the unknowns last")
        response, also = problem.linearised(x)
        error = max(seen.difference(response, seen.response[0]), _worst_column(also, found, 0.0)[0])
        require(error < SAME, "linearised as response and sensitivity", f"others by {error:.2g}", "leave it out")
        steps = STEP * np.where(x == 0, problem.parameters.width, np.minimum(np.abs(x), problem.parameters.width))
        rounding = ROUNDING * np.max(np.abs(seen.response)) / steps
        error, column = _worst_column(found, _differences(problem, x, steps), rounding)
        name = problem.parameters.names[column]
        require(
            error < SENSITIVITY,
            f"∂response/∂{name} as differences have it{seen.label}",
            f"one that is off by {error:.2g} of its largest",
            "look at its sign, its factor and its unit: m per SI unit; or leave sensitivity out",
        )


def _differences(problem: Problem, x: Array, steps: Array) -> ComplexArray:
    """∂response/∂x (n_speed, n_channel, d) by central differences of sixth order."""
    points = x + np.concatenate([step * np.diag(steps) for step in STEPS])
    values = problem.response(points).reshape(len(STEPS), len(x), len(problem.speed), -1)
    return np.moveaxis(np.tensordot(WEIGHTS, values, (0, 0)) / steps[:, None, None], 0, -1)


def _worst_column(found: ComplexArray, expected: ComplexArray, rounding: Array | float) -> tuple[float, int]:
    """Largest error of a column over its largest entry, less rounding, and the index of the column."""
    error = np.max(np.abs(found - expected), axis=(0, 1)) - rounding
    largest = np.max(np.abs(expected), axis=(0, 1))
    relative = np.maximum(error, 0) / np.where(largest > 0, largest, 1.0)
    return float(np.max(relative)), int(np.argmax(relative))


def is_the_same_elsewhere(case: ProblemCase) -> None:
    """At some of its speeds and channels (`at`) it responds as it does there among all."""
    for seen in case.seen:
        problem = seen.problem
        few = problem.at(problem.speed[::2], problem.channels[-1:])
        require(
            few.parameters == problem.parameters and np.array_equal(few.speed, problem.speed[::2]),
            f"the same unknowns at the given speeds{seen.label}",
            "others",
            "change speed and channels alone",
        )
        error = seen.difference(few.response(_fixed(seen.x)), seen.response[:, ::2, -1:])
        require(
            error < SAME,
            f"the same responses at fewer speeds and channels{seen.label}",
            f"others by {error:.2g}",
            "let no speed or channel depend on which others there are",
        )


def routes_agree(case: ProblemCase) -> None:
    """The dense route gives the response by another way."""
    for seen in case.seen:
        error = seen.difference(seen.problem.dense_response(_fixed(seen.x)), seen.response)
        require(error < BY_ROUTE, f"the same by both routes{seen.label}", f"others by {error:.2g}", "mend one of them")


def phase_origin_zero_is_known(case: ProblemCase) -> None:
    """With an unknown phase origin, one more unknown, the response at 0 of it is what it was."""
    for seen in case.seen:
        turned = seen.problem.with_phase_origin()
        names = turned.parameters.names
        require(
            turned.has_free_phase and set(names) == {*seen.problem.parameters.names, PHASE_ORIGIN},
            f"{PHASE_ORIGIN} as one more unknown{seen.label}",
            ", ".join(names),
            "name it as ksmea.problem.parameters.PHASE_ORIGIN",
        )
        error = seen.difference(
            turned.response(np.insert(seen.x, names.index(PHASE_ORIGIN), 0.0, axis=1)), seen.response
        )
        require(error < SAME, f"the same responses at 0{seen.label}", f"others by {error:.2g}", "let 0 turn nothing")


def growth_rates_are_in_shape(case: ProblemCase) -> None:
    """Growth rates are one finite number for each spin speed requested."""
    for seen in case.seen:
        speed = seen.problem.speed[:3]
        found = np.asarray(seen.problem.growth_rate(_fixed(seen.x[0]), speed))
        require(
            found.shape == speed.shape and np.all(np.isfinite(found)),
            f"{len(speed)} growth rates, 1/s{seen.label}",
            f"{found!r:.60}",
            "take the largest real part at each speed",
        )


def properties_of_problems(case: ProblemCase) -> Sequence[Callable[[ProblemCase], None]]:
    """Properties that apply to the abilities of a problem."""
    problem = case.seen[0].problem
    optional = (
        (problem.has_sensitivity, sensitivity_is_right),
        (type(problem).at is not Problem.at, is_the_same_elsewhere),
        (problem.has_dense_route, routes_agree),
        (problem.can_leave_phase_open and not problem.has_free_phase, phase_origin_zero_is_known),
        (problem.knows_stability, growth_rates_are_in_shape),
    )
    applying = (kept for applies, kept in optional if applies)
    return (gives_a_problem, unknowns_have_units, responds_in_shape, batch_equals_single, *applying)


def _fixed(x: Array) -> Array:
    """A copy of points that cannot be written into."""
    copy = x.copy()
    copy.flags.writeable = False
    return copy
