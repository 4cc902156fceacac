"""Shared parts of tests of the likelihood and of its maximisation.

They are data of a known vector, and kinds × known noise or not.
"""

import numpy as np
import pytest

from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.counted import Model

NOISE = Noise(0.1, 1e-7)


def measured(problem, u, kind, noise=NOISE, *, noise_known=True, seed=0):
    response = problem.response(problem.parameters.to_si(u)[None])[0]
    values = observe(response, kind, noise, np.random.default_rng(seed))
    return Measurement(problem.speed, problem.channels, values, noise if noise_known else None, "test")


def likelihood_of(problem, u, kind, **keys):
    return Likelihood(Model(problem), measured(problem, u, kind, **keys))


CASES = pytest.mark.parametrize(
    ("kind", "noise_known"), [(kind, noise_known) for kind in ("amplitude", "complex") for noise_known in (True, False)]
)
