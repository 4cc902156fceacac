"""The rise of the deviance from simulated data: exact for linear models, as direct simulation has it for two maxima."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from ksmea.inference import critical_rise as module
from ksmea.inference.critical_rise import can_be_simulated, simulated_rise
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins.identification import Identification, Streams
from ksmea.problem.case import Case
from ksmea.problem.counted import Model
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem
from ksmea.studies import identify
from ksmea.studies.identify import identification
from problems.three_disk import ThreeDisk

LEVEL = 1000.0  # of what is measured: so large against the noise that its amplitude is linear
UNIT_NOISE = Noise(0.0, 1.0)


class Means(Problem):
    """A response of `LEVEL` and a function (n, d) → (n, n_speed) of the unknowns, each within ±50."""

    channels = (Channel(0.0, "x"),)

    def __init__(self, n_speed, of, d):
        self.speed = np.arange(1.0, n_speed + 1)
        self.parameters = Parameters(tuple(Parameter(f"p{index}", "", 1.0, -50.0, 50.0) for index in range(d)))
        self._of = of

    def response(self, x):
        return (LEVEL + self._of(x, self.speed))[..., None].astype(complex)


def line(n_speed):
    return Means(n_speed, lambda x, speed: x[:, :1] + x[:, 1:] * (speed / n_speed), 2)


def likelihood_of(problem, noise, seed=0, y=None):
    y = np.random.default_rng(seed).standard_normal(len(problem.speed)) if y is None else y
    return Likelihood(Model(problem), Measurement(problem.speed, problem.channels, LEVEL + y[:, None], noise, "test"))


def maximum(likelihood, *x):
    return maximise(likelihood, likelihood.start(likelihood.model.problem.parameters.to_cube(np.array(x))))


@pytest.mark.parametrize("level", [0.8, 0.95, 0.99])
@pytest.mark.parametrize("noise", [UNIT_NOISE, None])
def test_a_linear_model_has_its_exact_quantile(noise, level):
    likelihood = likelihood_of(line(12), noise)
    rise = simulated_rise(likelihood, level, [maximum(likelihood, 0.0, 0.0)], np.random.default_rng(1))
    # χ² or, with 12 − 2 degrees of freedom left, F. Each linear rise is its own simulated one, so that the draws cancel; fits
    # end within some hundredths
    exact = stats.chi2.ppf(level, 1) if noise else 12 * np.log1p(stats.f.ppf(level, 1, 10) / 10)
    assert rise == pytest.approx(np.full((1, 2), exact), abs=0.06)


def test_a_limit_that_cuts_rises_off_does_not_lower_the_quantile():
    """Where the maximum lies on the limit, half of the draws have theirs outside and hardly rise: 2.7 were their quantile, which
    does not hold for values inside."""
    likelihood = likelihood_of(Means(12, lambda x, speed: x + 0 * speed, 1), UNIT_NOISE, y=np.full(12, 60.0))
    rise = simulated_rise(likelihood, 0.95, [maximum(likelihood, 50.0)], np.random.default_rng(1))
    assert rise[0, 0] == pytest.approx(stats.chi2.ppf(0.95, 1))


@pytest.mark.parametrize("apart", [3.0, 20.0])
def test_another_maximum_raises_it_to_where_direct_simulation_has_it(monkeypatch, apart):
    """Two lines of means, (p, 0) for p < 4 and (p − 14, apart) from there."""
    monkeypatch.setattr(module, "N_SIMULATED", 512)

    def of(x, speed):
        second = x >= 4
        return np.where(second, x - 14, x) * (speed == 1) + apart * second * (speed == 2)

    likelihood = likelihood_of(Means(2, of, 1), UNIT_NOISE, y=np.zeros(2))
    at = [likelihood.at(likelihood.model.problem.parameters.to_cube(np.array([p]))) for p in (0.0, 14.0)]
    second = dataclasses.replace(at[1], deviance=at[0].deviance + 1)  # near enough to be simulated
    found = simulated_rise(likelihood, 0.95, [at[0], second], np.random.default_rng(2))
    along, across = np.random.default_rng(1).standard_normal((2, 400_000))
    rise = along**2 + across**2 - np.minimum(across**2, (across - apart) ** 2)
    # the factor of 512 draws has a standard error of 0.2, and the tail's is not quite that of one rise; χ² alone has 3.84. The two lines are each other's mirror images
    assert found[:, 0] == pytest.approx(np.full(2, np.quantile(rise, 0.95)), abs=0.6)


def test_the_same_seed_gives_the_same_rises():
    problem = Means(8, lambda x, speed: np.exp(x / 2) * speed, 1)
    y = problem.speed + np.random.default_rng(0).standard_normal(8)
    likelihood = likelihood_of(problem, None, y=y)
    found = [
        simulated_rise(likelihood, 0.95, [maximum(likelihood, 0.1)], np.random.default_rng(seed)) for seed in (1, 1, 2)
    ]
    assert np.array_equal(found[0], found[1]) and not np.array_equal(found[0], found[2])


def test_what_is_costly_or_has_no_datum_left_is_not_simulated():
    def stand_in(*, has_sensitivity=True, costly=(), by_differences=False, n_residual=12, with_prior=()):
        parameters = SimpleNamespace(with_prior=with_prior)
        problem = SimpleNamespace(has_sensitivity=has_sensitivity, costly=costly, parameters=parameters)
        measurement = SimpleNamespace(is_by_differences=by_differences)
        return SimpleNamespace(
            model=SimpleNamespace(problem=problem), measurement=measurement, n_residual=n_residual, d=2
        )

    assert can_be_simulated(stand_in())
    assert not can_be_simulated(stand_in(has_sensitivity=False))
    assert not can_be_simulated(stand_in(costly=(1,)))
    assert not can_be_simulated(stand_in(with_prior=(1,)))
    assert not can_be_simulated(stand_in(by_differences=True))
    assert not can_be_simulated(stand_in(n_residual=2))


class Finds:
    """A method that finds a given point."""

    def __init__(self, x):
        self.x = x

    def identify(self, problem, measurement, streams):
        seconds = {"model": 0.0, "surrogate": 0.0, "search": 0.0, "total": 0.0}
        return Identification(self.x, (False,) * len(self.x), 1.0, "optimizer", 0, 0, 0, 0, seconds)


@pytest.mark.parametrize(
    ("n_speed", "are_few"), [(18, True), (53, False)]
)  # × 2 channels; 5 unknowns and no level: few below 50
def test_data_that_are_few_alone_are_simulated(monkeypatch, n_speed, are_few):
    settings = ThreeDisk(n_speed=n_speed)
    problem, truth = settings.build(), np.array(list(settings.reference().values()))
    noise = Noise(0.1, 0.0)
    values = observe(problem.response(truth[None])[0], "amplitude", noise, np.random.default_rng(1))
    measurement = Measurement(problem.speed, problem.channels, values, noise, "test")
    widened = []

    def wide(likelihood, level, maxima, rng):
        widened.append(len(maxima))
        return np.full((1, likelihood.d), 9.0)

    monkeypatch.setattr(identify, "simulated_rise", wide)
    streams = Streams(*(np.random.default_rng(part) for part in range(3)))
    plain = identification(Case(problem, measurement), Finds(truth), streams)
    rng = np.random.default_rng(4)
    drawn = identification(Case(problem, measurement), Finds(truth), streams, rng=rng)
    assert bool(widened) == are_few
    if are_few:
        assert drawn.parameters[0].high - drawn.parameters[0].low > 1.2 * (
            plain.parameters[0].high - plain.parameters[0].low
        )
    else:
        assert drawn.parameters == plain.parameters  # to the last digit
        assert rng.bit_generator.state == np.random.default_rng(4).bit_generator.state
