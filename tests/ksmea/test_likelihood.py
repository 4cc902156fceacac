"""The likelihood with known and unknown noise: derivatives by differences, its maximum by a second route."""

import dataclasses

import numpy as np
import pytest
from scipy.optimize import minimize

from ksmea.likelihood import Likelihood
from ksmea.maximisation import maximise
from ksmea.measurement import Measurement, Noise, observe
from ksmea.model import Model
from problems.three_disk import ThreeDisk

NOISE = Noise(0.1, 1e-7)


@pytest.fixture(scope="module")
def rotor():
    return ThreeDisk(n_speed=21).build()


@pytest.fixture(scope="module")
def truth(rotor):
    return rotor.parameters.to_cube(np.array(list(ThreeDisk().reference().values())))


def measured(problem, u, kind, noise=NOISE, *, told=True, seed=0):
    response = problem.response(problem.parameters.to_si(u)[None])[0]
    values = observe(response, kind, noise, np.random.default_rng(seed))
    return Measurement(problem.speed, problem.channels, values, noise if told else None, "test")


def likelihood_of(problem, u, kind, **keys):
    return Likelihood(Model(problem), measured(problem, u, kind, **keys))


CASES = pytest.mark.parametrize(
    ("kind", "told"), [(kind, told) for kind in ("amplitude", "complex") for told in (True, False)]
)


@CASES
def test_the_gradient_is_that_of_the_deviance(rotor, truth, kind, told):
    likelihood = likelihood_of(rotor, truth, kind, told=told)
    theta = likelihood.start(truth + 1e-3)
    if not told:
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
        likelihood = likelihood_of(rotor, truth, kind, noise=noise, told=False, seed=seed)
        point = likelihood.at(np.concatenate([truth, np.log([noise.relative, noise.floor])]))
        scores.append(point.gradient / 2)
        information = point.information
    scale = np.sqrt(np.diag(information))
    found = np.cov(np.array(scores).T, bias=True) / np.outer(scale, scale)
    # a covariance of 2000 draws is good to √(2/2000) = 3 % of the variances; 4 standard errors
    assert found == pytest.approx(information / np.outer(scale, scale), abs=0.13)
    # and the mean is zero
    assert np.mean(scores, axis=0) / scale == pytest.approx(0, abs=4 / np.sqrt(2000))


@CASES
def test_the_maximum_is_that_of_a_general_optimiser(rotor, truth, kind, told):
    likelihood = likelihood_of(rotor, truth, kind, told=told, seed=3)
    start = likelihood.start(truth)
    found = maximise(likelihood, start)
    scale = 1 / np.sqrt(np.diag(likelihood.at(start).information))

    def scaled(steps):
        return likelihood.deviance(np.clip(start + steps * scale, likelihood.lower, likelihood.upper))

    other = minimize(scaled, np.zeros(len(start)), method="Nelder-Mead", options={"maxiter": 6000, "fatol": 1e-9})
    assert found.deviance <= other.fun + 1e-5
    assert found.deviance == pytest.approx(other.fun, abs=0.05)  # where a simplex gives up


def test_a_fixed_unknown_stays_and_the_limits_hold(rotor, truth):
    likelihood = likelihood_of(rotor, truth, "amplitude")
    theta = truth.copy()
    theta[0] += 2e-3
    found = maximise(likelihood, theta, fixed=0)
    assert found.theta[0] == theta[0]
    assert np.all((found.theta >= 0) & (found.theta <= 1))
    assert found.deviance > maximise(likelihood, truth).deviance


def test_a_maximum_on_a_search_limit_is_reached(rotor, truth):
    """Damping that the data would have below its lower limit ends there."""
    bounds = {"cxx": [0.6, 1.0]}  # the true 0.5 kN s/m is outside
    outside = ThreeDisk(n_speed=21, bounds=bounds).build()
    measurement = measured(rotor, truth, "complex")
    u = outside.parameters.to_cube(rotor.parameters.to_si(truth))
    found = maximise(Likelihood(Model(outside), measurement), np.clip(u, 0, 1))
    assert found.theta[2] == 0.0


@pytest.mark.parametrize("noise", [Noise(0.1, 0.0), Noise(0.0, 3e-6), Noise(0.05, 1e-6)])
def test_unknown_noise_is_estimated(truth, noise):
    problem = ThreeDisk(n_speed=200).build()
    likelihood = likelihood_of(problem, truth, "complex", noise=noise, told=False)
    found = likelihood.noise(maximise(likelihood, likelihood.start(truth)).theta)
    # 400 complex data: a standard deviation is known to 1/√800 = 3.5 %, each of two parts to a few times that
    amplitude = np.abs(problem.response(problem.parameters.to_si(truth)[None])[0])
    assert np.median(found.sd(amplitude) / noise.sd(amplitude)) == pytest.approx(1, abs=0.15)


def test_without_noise_there_is_no_likelihood(rotor, truth):
    measurement = measured(rotor, truth, "complex", Noise(0.0, 0.0))
    with pytest.raises(ValueError, match="noise"):
        Likelihood(Model(rotor), measurement)


def test_a_spent_budget_ends_the_search_with_the_best_so_far(rotor, truth):
    measurement = measured(rotor, truth, "complex")
    start = np.clip(truth + np.array([2e-3, 0, 0, 0, 0.05]), 0, 1)
    whole = maximise(Likelihood(Model(rotor), measurement), start)
    model = Model(rotor, budget=2)
    short = maximise(Likelihood(model, measurement), start)
    assert model.evaluations <= 2
    assert whole.deviance < short.deviance <= Likelihood(Model(rotor), measurement).deviance(start)


def test_a_problem_without_sensitivity_has_the_same_maximum(rotor, truth):
    class Plain:
        def __init__(self, problem):
            self.parameters, self.response = problem.parameters, problem.response

    measurement = measured(rotor, truth, "complex")
    model = Model(Plain(rotor))
    found = maximise(Likelihood(model, measurement), truth)
    expected = maximise(Likelihood(Model(rotor), measurement), truth)
    assert model.jacobians == 0 and model.evaluations > 11
    sd = 1 / np.sqrt(np.diag(expected.information))
    assert (found.theta - expected.theta) / sd == pytest.approx(0, abs=1e-3)


def test_scaling_of_all_lengths_changes_nothing(rotor, truth):
    """The deviance has no unit: data and noise in other units give another constant only."""
    measurement = measured(rotor, truth, "amplitude")
    likelihood = Likelihood(Model(rotor), measurement)
    larger = dataclasses.replace(
        measurement, values=measurement.values * 10, noise=Noise(NOISE.relative, NOISE.floor * 10)
    )

    class Larger:
        parameters = rotor.parameters

        def response(self, x):
            return rotor.response(x) * 10

    assert Likelihood(Model(Larger()), larger).deviance(truth) == pytest.approx(likelihood.deviance(truth), rel=1e-12)


def test_the_curvature_of_a_mean_along_a_step_is_its_second_derivative(rotor, truth):
    """Against second differences of the response itself; the noise does not bend."""
    likelihood = likelihood_of(rotor, truth, "complex", told=False)
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
