"""Shared parts of tests of the KSMEA loop.

They are seeded streams, measurements of a known vector, and a problem that counts.
"""

import numpy as np

from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins.identification import Streams
from ksmea.problem.problem import Problem


def streams(seed=0):
    return Streams(*(np.random.default_rng([seed, part]) for part in range(3)))


def measured(problem, x, kind="complex", noise=Noise(0.0, 0.0), seed=0):  # noqa: B008, a frozen value
    values = observe(problem.response(np.array([x]))[0], kind, noise, np.random.default_rng(seed))
    return Measurement(problem.speed, problem.channels, values, noise, "test")


class Counted(Problem):
    """A problem that counts what it is asked, apart from any counter of the framework."""

    has_sensitivity = True

    def __init__(self, problem):
        self._problem = problem
        self.parameters, self.speed, self.channels = problem.parameters, problem.speed, problem.channels
        self.points = self.sensitivities = 0
        self.has_sensitivity = problem.has_sensitivity

    def response(self, x):
        self.points += len(x)
        return self._problem.response(x)

    def sensitivity(self, x):
        self.sensitivities += 1
        return self._problem.sensitivity(x)

    def agrees_with(self, found):
        """A Jacobian takes the response at its point too, and counts as one Jacobian."""
        return (self.points - self.sensitivities, self.sensitivities) == (
            found.model_evaluations,
            found.model_jacobians,
        )
