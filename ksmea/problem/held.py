"""A problem with some of its unknowns held at values: its unknowns are the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.problem.forwarding import ProblemProxy
from ksmea.problem.load import Load
from ksmea.problem.parameters import Parameters
from ksmea.problem.problem import Problem


class HeldProblem(ProblemProxy):
    """The problem behind with all unknowns but those at the indices `free` as they are in x (d,) SI."""

    def __init__(self, behind: Problem, free: Indices, x: Array) -> None:
        self._behind, self._free, self._x = behind, free, x

    @property
    def behind(self) -> Problem:
        return self._behind

    def around(self, behind: Problem) -> HeldProblem:
        return HeldProblem(behind, self._free, self._x)

    @cached_property
    def parameters(self) -> Parameters:
        return Parameters(tuple(self._behind.parameters.items[index] for index in self._free))

    def whole(self, x: Array) -> Array:
        """Values (…, d) of all unknowns of the problem behind, from the values of the free ones."""
        values = np.tile(self._x, (*np.shape(x)[:-1], 1))
        values[..., self._free] = x
        return values

    @property
    def costly(self) -> Indices:
        return np.flatnonzero(np.isin(self._free, self._behind.costly))

    def response(self, x: Array) -> ComplexArray:
        return self._behind.response(self.whole(x))

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        return self._behind.load_response(self.whole(x), loads)

    def response_and_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        return self._behind.response_and_per_load(self.whole(x), loads)

    def sensitivity(self, x: Array) -> ComplexArray:
        return self._behind.sensitivity(self.whole(x))[..., self._free]

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        response, sensitivity = self._behind.linearised(self.whole(x))
        return response, sensitivity[..., self._free]

    def linearised_per_load(self, x: Array, loads: Sequence[Load]) -> tuple[ComplexArray, ComplexArray]:
        columns, change = self._behind.linearised_per_load(self.whole(x), loads)
        return columns, change[..., self._free]

    def is_stable(self, x: Array) -> bool:
        return self._behind.is_stable(self.whole(x))

    def growth_rate(self, x: Array, speed: Array) -> Array:
        return self._behind.growth_rate(self.whole(x), speed)

    def unbalance(self, x: Array) -> Mapping[float, complex]:
        return self._behind.unbalance(self.whole(x))


def holding_inputs(problem: Problem, x: Array) -> Problem:
    """The problem with numbers that are known to a tolerance held at the values of a point.

    Itself if all are exact.

    Args:
        problem: problem with such numbers among its unknowns.
        x: values (d,) of all unknowns, SI.
    """
    own = problem.parameters.own
    if len(own) == len(problem.parameters):
        return problem
    return problem.holding_inputs(x) or HeldProblem(problem, own, x)
