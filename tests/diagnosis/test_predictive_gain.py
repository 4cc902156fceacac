"""The predictive gain on left-out blocks: a log density that a direct computation confirms, and nothing for nothing."""

import numpy as np
import pytest

from ksmea.diagnosis.predictive_gain import predictive_gain
from ksmea.fits.fitting import Fit
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.problem.counted import Model
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem


class Powers(Problem):
    """Σ p_i s^i over scaled speed, one channel."""

    channels = (Channel(0.0, "x"),)

    def __init__(self, n_unknown, speed):
        self.speed = speed
        self.parameters = Parameters(tuple(Parameter(f"p{i}", "", 1.0, -50.0, 50.0) for i in range(n_unknown)))

    def at(self, speed, channels):
        return Powers(len(self.parameters), speed)

    def response(self, x):
        powers = (self.speed / 100)[None] ** np.arange(x.shape[1])[:, None]
        return (x @ powers)[..., None].astype(complex)


SPEED = np.linspace(50.0, 150.0, 60)
NOISE = Noise(0.0, 0.3)


def fitted(n_unknown, values):
    problem = Powers(n_unknown, SPEED)
    likelihood = Likelihood(Model(problem), Measurement(SPEED, problem.channels, values, NOISE, "test"))
    return Fit(likelihood, maximise(likelihood, likelihood.start(np.full(n_unknown, 0.6))))


def curved(curvature, seed):
    rng = np.random.default_rng(seed)
    mean = 10 + 2 * SPEED / 100 + curvature * (SPEED / 100 - 1) ** 2
    return np.abs(mean + NOISE.floor * rng.standard_normal(60))[:, None]


def test_the_elpd_difference_is_of_the_log_density_of_left_out_data():
    values = curved(3.0, 1)
    found = predictive_gain(fitted(2, values), fitted(3, values), 6).elpd
    expected = []
    for block in np.array_split(np.arange(60), 6):
        kept = np.setdiff1d(np.arange(60), block)
        scores = []
        for n in (2, 3):
            coefficients = np.polynomial.polynomial.polyfit(SPEED[kept] / 100, values[kept, 0], n - 1)
            residual = values[block, 0] - np.polynomial.polynomial.polyval(SPEED[block] / 100, coefficients)
            scores.append(-0.5 * np.sum(residual**2) / NOISE.floor**2)
        expected.append(scores[1] - scores[0])
    assert found.by_block == pytest.approx(expected, abs=0.02)
    assert found.total == pytest.approx(sum(expected), abs=0.1)
    assert found.standard_error == pytest.approx(np.std(expected, ddof=1) * np.sqrt(6), rel=0.01)


def test_a_true_extension_pays_and_a_superfluous_one_does_not():
    paid = predictive_gain(fitted(2, curved(8.0, 2)), fitted(3, curved(8.0, 2)), 6)
    assert paid.elpd.is_supported and paid.rmse_after < paid.rmse_before
    superfluous = [predictive_gain(fitted(2, curved(0.0, seed)), fitted(3, curved(0.0, seed)), 6) for seed in range(8)]
    assert np.mean([each.elpd.total for each in superfluous]) < 0  # one more unknown costs on data it has not seen
    assert sum(each.elpd.is_supported for each in superfluous) <= 1


def test_parts_of_a_measurement_keep_their_own_noise():
    whole = Measurement(SPEED[:4], (Channel(0.0, "x"),), np.ones((4, 1)), NOISE, "test")
    part = whole.part(np.array([1, 3]))
    assert part.speed == pytest.approx(SPEED[[1, 3]]) and part.values.shape == (2, 1)
