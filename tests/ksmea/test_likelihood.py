"""The likelihood with known and unknown noise: derivatives by differences, and scores by simulation."""

import dataclasses

import numpy as np
import pytest

from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.noise import Noise
from ksmea.problem.counted import Model
from ksmea.problem.problem import Problem
from likelihood_cases import CASES, NOISE, likelihood_of, measured
from problems.three_disk import ThreeDisk


@pytest.fixture(scope="module")
def rotor():
    return ThreeDisk(n_speed=21).build()


@pytest.fixture(scope="module")
def truth(rotor):
    return rotor.parameters.to_cube(np.array(list(ThreeDisk().reference().values())))


@CASES
def test_the_gradient_is_that_of_the_deviance(rotor, truth, kind, noise_known):
    likelihood = likelihood_of(rotor, truth, kind, noise_known=noise_known)
    theta = likelihood.start(truth + 1e-3)
    if not noise_known:
        theta[-2:] = np.log([0.07, 2e-7])  # away from the optimum of the noise
    step = 1e-6
    by_differences = [
        (likelihood.deviance(theta + change) - likelihood.deviance(theta - change)) / (2 * step)
        for change in step * np.eye(len(theta))
    ]
    # second-order differences of a function with curvatures up to 1e9 in the cube
    assert likelihood.at(theta).gradient == pytest.approx(by_differences, rel=1e-4, abs=1e-3)


@pytest.mark.parametrize("kind", ["amplitude", "complex"])
def test_the_information_is_the_covariance_of_half_the_gradient(rotor, truth, kind):
    """Over noise draws at the true values, noise parameters included."""
    noise = Noise(0.1, 1e-8)  # a tenth of the smallest amplitude: none is folded at zero
    scores, information = [], None
    for seed in range(2000):
        likelihood = likelihood_of(rotor, truth, kind, noise=noise, noise_known=False, seed=seed)
        point = likelihood.at(np.concatenate([truth, np.log([noise.relative, noise.floor])]))
        scores.append(point.gradient / 2)
        information = point.information
    scale = np.sqrt(np.diag(information))
    found = np.cov(np.array(scores).T, bias=True) / np.outer(scale, scale)
    # a covariance of 2000 draws is good to √(2/2000) = 3 % of the variances; 4 standard errors
    assert found == pytest.approx(information / np.outer(scale, scale), abs=0.13)
    # and the mean is zero
    assert np.mean(scores, axis=0) / scale == pytest.approx(0, abs=4 / np.sqrt(2000))


def test_without_noise_there_is_no_likelihood(rotor, truth):
    measurement = measured(rotor, truth, "complex", Noise(0.0, 0.0))
    with pytest.raises(ValueError, match="noise"):
        Likelihood(Model(rotor), measurement)


def test_scaling_of_all_lengths_changes_nothing(rotor, truth):
    """The deviance has no unit: data and noise in other units give another constant only."""
    measurement = measured(rotor, truth, "amplitude")
    likelihood = Likelihood(Model(rotor), measurement)
    larger = dataclasses.replace(
        measurement, values=measurement.values * 10, noise=Noise(NOISE.relative, NOISE.floor * 10)
    )

    class Larger(Problem):
        parameters, speed, channels = rotor.parameters, rotor.speed, rotor.channels

        def response(self, x):
            return rotor.response(x) * 10

    assert Likelihood(Model(Larger()), larger).deviance(truth) == pytest.approx(likelihood.deviance(truth), rel=1e-12)


def test_the_curvature_of_a_mean_along_a_step_is_its_second_derivative(rotor, truth):
    """Against second differences of the response itself; the noise does not bend."""
    likelihood = likelihood_of(rotor, truth, "complex", noise_known=False)
    theta = likelihood.start(truth)
    point = likelihood.at(theta)
    step = np.concatenate([[1e-3, -5e-4, 1e-2, 2e-2, 1e-2], [0.1, -0.2]])  # where differences are small, and no noise
    found = likelihood.curvature(point, step)
    h = 0.05
    mean = [likelihood.model.response((theta + k * h * step)[None, :5])[0] for k in (-1, 0, 1)]
    second = (np.sqrt(2) * (mean[0] - 2 * mean[1] + mean[2]) / h**2 / likelihood.noise(theta).sd(abs(mean[1]))).ravel()
    n = second.size
    # a one-sided difference against a central one: they part by the third derivative times a tenth of the step
    assert found[: 2 * n] == pytest.approx(np.concatenate([second.real, second.imag]), abs=0.1 * abs(second).max())
    assert not found[2 * n :].any()
