"""The deviance: against normal densities of scipy, and the same wherever it is used."""

import numpy as np
import pytest
from scipy.stats import norm

from ksmea.likelihood.likelihood import Likelihood
from ksmea.likelihood.misfit import Misfit, deviance, log_term, reference_variance
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.problem.counted import Model
from ksmea.problem.parameters import Parameter, Parameters
from problems.three_disk import ThreeDisk

NOISE = Noise(0.1, 1e-7)


def minus_twice_log_density(residual, variance, observable):
    """By scipy, but for Σ n ln(2π), and for n ln n of complex data, whose parts have half the variance."""
    if observable is Observable.AMPLITUDE:
        return -2 * np.sum(norm.logpdf(residual, scale=np.sqrt(variance)) + 0.5 * np.log(2 * np.pi))
    scale = np.sqrt(variance / 2)
    parts = norm.logpdf(residual.real, scale=scale) + norm.logpdf(residual.imag, scale=scale) + np.log(np.pi)
    return -2 * np.sum(parts)


@pytest.mark.parametrize("observable", list(Observable))
def test_it_is_minus_twice_the_log_of_normal_densities(observable):
    rng = np.random.default_rng(0)
    residual = rng.standard_normal((5, 2)) + (
        0 if observable is Observable.AMPLITUDE else 1j * rng.standard_normal((5, 2))
    )
    variance, reference = rng.uniform(0.5, 2.0, (5, 2)), rng.uniform(0.5, 2.0, (5, 2))
    found = deviance(np.abs(residual) ** 2, variance, reference, observable)
    constant = np.sum(log_term(reference, 1.0, observable))
    assert found + constant == pytest.approx(minus_twice_log_density(residual, variance, observable), rel=1e-12)


def test_it_is_summed_over_the_axes_that_are_given():
    squared, variance = np.arange(6.0).reshape(2, 3), np.full((2, 3), 2.0)
    found = deviance(squared, variance, 1.0, Observable.COMPLEX, axis=1)
    assert found == pytest.approx([3 * 2 * np.log(2) + 3.0, 3 * 2 * np.log(2) + 12.0])


@pytest.mark.parametrize("observable", list(Observable))
def test_its_mean_is_least_at_the_true_variance(observable):
    """E|r|² = σ²: d/ds² (ln s² + σ²/s²) = 0 at s² = σ², whatever the kind."""
    sizes = np.linspace(0.5, 2.0, 1501)
    values = [float(deviance(np.array(1.21), np.array(size), 1.0, observable)) for size in sizes]
    assert sizes[np.argmin(values)] == pytest.approx(1.21, abs=1e-3)


def test_a_zero_has_the_reference_of_the_mean_square():
    values = np.array([3.0, 0.0])
    assert reference_variance(0.01 * values**2, values) == pytest.approx([0.09, 4.5])


@pytest.mark.parametrize("observable", list(Observable))
def test_misfit_and_likelihood_have_the_same(observable):
    """The misfit by way of residuals whose squares it sums, with their offset; the likelihood straight."""
    problem = ThreeDisk(n_speed=15).build()
    truth = np.array(list(ThreeDisk().reference().values()))
    values = observe(problem.response(truth[None])[0], observable, NOISE, np.random.default_rng(2))
    measurement = Measurement(problem.speed, problem.channels, values, NOISE, "test")
    likelihood, misfit = Likelihood(Model(problem), measurement), Misfit(measurement, "likelihood")
    for u in np.random.default_rng(3).uniform(size=(5, 5)):
        predicted = misfit.observed(problem.response(problem.parameters.to_si(u)[None]))
        # residuals of up to 1e7 have squares that leave the logarithms, of 10 each, 1e-9 and better
        assert likelihood.deviance(u) == pytest.approx(misfit.value(predicted)[0], rel=1e-10)


class Constant:
    """A response that is its one unknown at every speed."""

    channels = (Channel(0.0, "x"),)
    campaign = None

    def __init__(self, n_speed, *limits):
        self.speed = np.arange(1.0, n_speed + 1)
        self.parameters = Parameters((Parameter("p", "", 1.0, *limits),))

    def response(self, x):
        return np.repeat(x[:, :, None], len(self.speed), axis=1).astype(complex)


def test_log_densities_of_different_noise_can_be_compared():
    """Their difference is that of scipy's, which the deviances' is not."""
    problem = Constant(9, 0.0, 10.0)
    values = 5 + np.random.default_rng(4).standard_normal((9, 1))
    found = {}
    for sd in (0.5, 2.0):
        measurement = Measurement(problem.speed, problem.channels, values, Noise(0.0, sd), "test")
        found[sd] = Likelihood(Model(problem), measurement).log_density(np.array([0.48]))
    expected = [norm.logpdf(values, 4.8, sd).sum() for sd in (0.5, 2.0)]
    assert found[0.5] - found[2.0] == pytest.approx(expected[0] - expected[1], rel=1e-12)
