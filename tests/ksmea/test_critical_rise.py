"""The quantile of the rise of the deviance at the truth: closed forms for one maximum, simulation for two."""

import numpy as np
import pytest
from scipy import stats

from ksmea.inference.critical_rise import critical_rise
from ksmea.inference.intervals import estimate
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.problem.counted import Model
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem

LEVEL = 1000.0  # of what is measured: so large against the noise that its amplitude is linear


class Branches(Problem):
    """Two lines of means with an unknown p: (p, 0) for p < 4, and (p - 4 + shift, apart) from there; then zeros."""

    channels = (Channel(0.0, "x"),)
    parameters = Parameters((Parameter("p", "", 1.0, -4.0, 12.0),))

    def __init__(self, apart, shift=0.0, n_speed=2):
        self.speed = np.arange(1.0, n_speed + 1)
        self._apart, self._shift = apart, shift

    def response(self, x):
        second = x[:, 0] >= 4
        mean = np.full((len(x), len(self.speed), 1), LEVEL, dtype=complex)
        mean[:, 0, 0] += np.where(second, x[:, 0] - 4 + self._shift, x[:, 0])
        mean[:, 1, 0] += self._apart * second
        return mean


def likelihood_of(problem, y, noise=Noise(0.0, 1.0)):  # noqa: B008 – frozen
    return Likelihood(Model(problem), Measurement(problem.speed, problem.channels, LEVEL + y[:, None], noise, "test"))


def at(likelihood, value):
    noise = [] if not likelihood.noise_is_estimated else [np.log(1e-4), 0.0]  # a floor of 1
    return likelihood.at(np.concatenate([likelihood.model.problem.parameters.to_cube(np.array([value])), noise]))


@pytest.mark.parametrize("noise", [Noise(0.0, 1.0), None])
def test_one_maximum_has_the_quantile_of_its_own(noise):
    likelihood = likelihood_of(Branches(1.0, n_speed=20), np.zeros(20), noise)
    # 20 residuals and one unknown: with the noise estimated along, what Student's t says of a mean
    expected = stats.chi2.ppf(0.9, 1) if noise else 20 * np.log1p(stats.t.ppf(0.95, 19) ** 2 / 19)
    assert critical_rise(likelihood, 0.9) == pytest.approx(expected, rel=1e-9)
    assert critical_rise(likelihood, 0.9, [at(likelihood, 0.0)]) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("apart", [0.0, 0.5, 2.0, 4.0, 20.0])
def test_another_maximum_raises_it_to_where_simulation_has_it(apart):
    likelihood = likelihood_of(Branches(apart), np.zeros(2))
    maxima = [at(likelihood, value) for value in (0.0, 6.0)]
    along, across = np.random.default_rng(1).standard_normal((2, 400_000))
    # the truth lies on the first line; what lies nearer to the second has its maximum there
    rise = along**2 + across**2 - np.minimum(across**2, (across - apart) ** 2)
    found = critical_rise(likelihood, 0.95, maxima)
    # 400 000 draws know a chance of 5 % to 0.0003, and 4096 normal points to 0.001
    assert np.mean(rise > found) == pytest.approx(0.05, abs=0.002)
    assert (found > 3.9) == (apart in (0.5, 2.0, 4.0))  # the same mean, or one that is never mistaken, costs nothing


def test_a_second_maximum_within_the_quantile_widens_the_interval():
    """Values near 0 and near 6 fit about as well, those between do not: the interval reaches over both."""
    likelihood = likelihood_of(Branches(apart=1.0, shift=-2.0), np.array([0.0, 0.4]))
    first, second = (at(likelihood, value) for value in (0.0, 6.0))
    assert second.deviance - first.deviance == pytest.approx(0.6**2 - 0.4**2, rel=0.01)
    alone = estimate(likelihood, first).intervals[0]
    assert (alone.low, alone.high) == pytest.approx((-1.96, 1.96), abs=0.03)
    both = estimate(likelihood, first, others=[second]).intervals[0]
    rise = critical_rise(likelihood, 0.95, [first, second])
    assert both.basis == "hull"
    # around the second what is left of the rise
    assert (both.low, both.high) == pytest.approx((-np.sqrt(rise), 6 + np.sqrt(rise - 0.2)), abs=0.05)
