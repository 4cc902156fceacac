"""The true model as methods and surrogates see it: every evaluation is counted and timed here, never by plugins."""

from __future__ import annotations

import time

from ksmea.contracts import ComplexArray, Problem
from ksmea.parameters import Array
from ksmea.transforms import Transform


class Model:
    """A problem over the unit cube, counting points (`evaluations`), sensitivities (`jacobians`) and `seconds`."""

    def __init__(self, problem: Problem, transform: Transform) -> None:
        self.problem = problem
        self.transform = transform
        self.evaluations = 0
        self.jacobians = 0
        self.seconds = 0.0

    def response(self, u: Array) -> ComplexArray:
        """(k, d) in the unit cube → complex response (k, n_speed, n_channel), m."""
        started = time.perf_counter()
        response = self.problem.response(self.problem.parameters.to_si(u))
        self.seconds += time.perf_counter() - started
        self.evaluations += len(u)
        return response

    def sensitivity(self, u: Array) -> ComplexArray:
        """(d,) in the unit cube → ∂response/∂u (n_speed, n_channel, d), m."""
        started = time.perf_counter()
        parameters = self.problem.parameters
        sensitivity = self.problem.sensitivity(parameters.to_si(u)) * parameters.width
        self.seconds += time.perf_counter() - started
        self.jacobians += 1
        return sensitivity

    def outputs(self, u: Array) -> Array:
        """(k, d) → real outputs (k, q) as surrogates model them."""
        return self.transform.encode(self.response(u))
