"""Maxima of a likelihood: by a second route, on search limits, with unknown noise, and the best of many."""

import numpy as np
import pytest
from scipy.optimize import minimize

from ksmea.inference.intervals import estimate
from ksmea.inference.maximisation import (
    PATIENCE,
    SETTLED,
    best_maxima,
    distinct,
    is_in_valley,
    maximise,
    nearest_maximum,
    with_best_noise,
)
from ksmea.likelihood.fisher import Point
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.counted import CountedProblem, Model
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem
from likelihood_cases import CASES, likelihood_of, measured
from problems.rk4_two_disk import RK4TwoDisk
from problems.three_disk import ThreeDisk


@pytest.fixture(scope="module")
def rotor():
    return ThreeDisk(n_speed=21).build()


@pytest.fixture(scope="module")
def truth(rotor):
    return rotor.parameters.to_cube(np.array(list(ThreeDisk().reference().values())))


@CASES
def test_the_maximum_is_that_of_a_general_optimiser(rotor, truth, kind, noise_known):
    likelihood = likelihood_of(rotor, truth, kind, noise_known=noise_known, seed=3)
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
    limits = {"cxx": [0.6, 1.0]}  # the true 0.5 kN s/m is outside
    outside = ThreeDisk(n_speed=21, limits=limits).build()
    measurement = measured(rotor, truth, "complex")
    u = outside.parameters.to_cube(rotor.parameters.to_si(truth))
    found = maximise(Likelihood(Model(outside), measurement), np.clip(u, 0, 1))
    assert found.theta[2] == 0.0


@pytest.mark.parametrize("noise", [Noise(0.1, 0.0), Noise(0.0, 3e-6), Noise(0.05, 1e-6)])
def test_unknown_noise_is_estimated(truth, noise):
    problem = ThreeDisk(n_speed=200).build()
    likelihood = likelihood_of(problem, truth, "complex", noise=noise, noise_known=False)
    found = likelihood.noise(maximise(likelihood, likelihood.start(truth)).theta)
    # 400 complex data: a standard deviation is known to 1/√800 = 3.5 %, each of two parts to a few times that
    amplitude = np.abs(problem.response(problem.parameters.to_si(truth)[None])[0])
    assert np.median(found.sd(amplitude) / noise.sd(amplitude)) == pytest.approx(1, abs=0.15)


def test_a_spent_budget_ends_the_search_with_the_best_so_far(rotor, truth):
    measurement = measured(rotor, truth, "complex")
    start = np.clip(truth + np.array([2e-3, 0, 0, 0, 0.05]), 0, 1)
    whole = maximise(Likelihood(Model(rotor), measurement), start)
    model = Model(rotor, budget=2)
    short = maximise(Likelihood(model, measurement), start)
    assert model.evaluations <= 2
    assert whole.deviance < short.deviance <= Likelihood(Model(rotor), measurement).deviance(start)


def test_a_problem_without_sensitivity_has_the_same_maximum(rotor, truth):
    class Plain(Problem):
        parameters, speed, channels = rotor.parameters, rotor.speed, rotor.channels

        def response(self, x):
            return rotor.response(x)

    measurement = measured(rotor, truth, "complex")
    model = Model(Plain())
    found = maximise(Likelihood(model, measurement), truth)
    expected = maximise(Likelihood(Model(rotor), measurement), truth)
    assert model.jacobians == 0 and model.evaluations > 11
    sd = 1 / np.sqrt(np.diag(expected.information))
    assert (found.theta - expected.theta) / sd == pytest.approx(0, abs=1e-3)


class Wave(Problem):
    """A response 3 + sin 2πx/10 that has the same value at many x: one maximum of the likelihood for each."""

    speed, channels = np.arange(1.0, 41.0), (Channel(0.0, "x"),)
    parameters = Parameters((Parameter("p", "", 1.0, 0.0, 30.0),))

    def response(self, x):
        wave = 3 + np.sin(2 * np.pi * x / 10) + 0.02 * x  # a little higher from one to the next
        return np.repeat(wave[:, :, None], 40, axis=1).astype(complex)


def of_wave(noise, seed=0):
    values = np.abs(3 + 0.8 + np.random.default_rng(seed).standard_normal((40, 1)) * 0.2)
    return Likelihood(Model(Wave()), Measurement(Wave.speed, Wave.channels, values, noise, "test"))


def test_best_maxima_are_different_ones_the_highest_first():
    likelihood = of_wave(Noise(0.0, 0.2))
    starts = [np.array([x / 30]) for x in np.linspace(0.5, 29.5, 40)]
    found = best_maxima(likelihood, starts, first_iterations=6, survivors=40)
    deviances = [point.deviance for point in found]
    assert deviances == sorted(deviances)
    places = np.sort([30 * point.theta[0] for point in found])
    assert np.all(np.diff(places) > 0.5)  # many are as high, all lie apart
    # by a grid, none is higher
    values = np.array([likelihood.deviance(np.array([u])) for u in np.linspace(0, 1, 1001)])
    assert deviances[0] <= values.min() + 1e-6
    assert len(best_maxima(likelihood, starts, first_iterations=6, survivors=1)) == 1


def test_a_floor_that_does_not_show_stops_no_search():
    """Of a floor far below the residuals there is next to no information: a step that believed it would go to the highest
    floor of all, at any damping, and no other step would be tried."""
    settings = RK4TwoDisk()
    problem = settings.build()
    response = problem.response(np.array([list(settings.reference().values())]))[0]
    values = observe(response, "amplitude", Noise(0.1, 0.0), np.random.default_rng(20))
    likelihood = Likelihood(Model(problem), Measurement(problem.speed, problem.channels, values, None, "test"))
    u = [0.05471, 0.08099, 0.08914, 0.0556, 0.06013, 0.27414, 0.05789, 0.18534]  # where a profile of u1 came by
    start = likelihood.at(np.array([*u, -2.16382, likelihood.lower[-1]]))
    found = maximise(likelihood, start.theta, fixed=4, tolerance=0.01)
    assert found.deviance < start.deviance - 1


def test_maxima_are_the_same_where_the_data_see_no_difference():
    """Two angles of which amplitudes tell the difference: turned together, or one by a whole turn, they are the same; mirrored
    they are another maximum that is as high."""

    def angle(name):
        return Parameter(name, "deg", np.pi / 180, -1.5 * np.pi, 1.5 * np.pi)

    class Angles(Problem):
        speed, channels = np.arange(1.0, 11.0), (Channel(0.0, "x"),)
        parameters = Parameters((angle("a"), angle("b")))

        def response(self, x):
            return np.abs(1 + np.exp(1j * (x[:, :1] - x[:, 1:])))[..., None] * np.ones((10, 1)) + 0j

    values = np.full((10, 1), 2 * np.cos(0.5))  # a difference of 1 or of −1
    problem = Angles()
    likelihood = Likelihood(Model(problem), Measurement(problem.speed, problem.channels, values, Noise(0, 0.1), "test"))
    angles = [(1.0, 0.0), (2.5, 1.5), (2.5 - 2 * np.pi, 1.5), (-1.0, 0.0)]
    maxima = [likelihood.at(problem.parameters.to_cube(np.array(pair))) for pair in angles]
    found = distinct(likelihood, maxima)
    assert [point.deviance for point in maxima] == pytest.approx([maxima[0].deviance] * 4)
    difference = [problem.parameters.to_si(point.theta) @ [1, -1] for point in found]
    assert sorted(np.cos(difference)) == pytest.approx([np.cos(1.0)] * 2) and np.prod(np.sin(difference)) < 0
    # neither angle is known: of two maxima with two angles each, half a turn to either side, for a Jacobian (5) and trials
    before = likelihood.model.evaluations
    told = estimate(likelihood, maxima[0], others=maxima[3:])
    assert [interval.basis for interval in told.intervals] == 2 * ["not identifiable"]
    assert likelihood.model.evaluations - before < 80


def test_the_nearest_maximum_is_that_of_the_start_s_own_valley():
    likelihood = of_wave(Noise(0.0, 0.2))
    mean = likelihood.measurement.values.mean()
    for start in (1.0, 11.0, 21.0):
        x = 30 * nearest_maximum(likelihood, np.array([start / 30])).theta[0]
        assert abs(x - start) < 2.0
        assert 3 + np.sin(2 * np.pi * x / 10) + 0.02 * x == pytest.approx(mean, abs=1e-4)


@pytest.mark.parametrize("noise", [Noise(0.0, 0.2), None])
def test_the_deviance_rises_all_the_way_to_what_lies_in_the_valley_of_a_maximum(noise):
    likelihood = of_wave(noise)
    maxima = [nearest_maximum(likelihood, np.array([start / 30])) for start in (1.0, 11.0, 21.0)]
    inside = 0
    for point in maxima:
        for u in np.linspace(0.01, 0.99, 60):
            theta = np.concatenate([[u], point.theta[1:]])
            if is_in_valley(likelihood, point, theta):
                inside += 1
                way = point.theta + np.linspace(0, 1, 50)[:, None] * (theta - point.theta)
                assert np.all(np.diff([likelihood.deviance(each) for each in way]) > 0)
    assert inside >= 3  # the valleys are 10 of 30 wide, of which some tenths are a parabola


def test_nothing_lower_than_a_maximum_lies_in_its_valley():
    """Points that a search was given up at are judged too."""
    given_up = Bowl()
    point = given_up.at(np.array([0.9]))
    assert not is_in_valley(given_up, point, np.array([0.6]))


def test_the_noise_at_the_nearest_maximum_is_the_best_of_its_own_grid():
    """A constant response: how much of its noise is relative cannot be estimated, their sum is the rms residual."""
    likelihood = of_wave(None)
    found = nearest_maximum(likelihood, np.array([1.0 / 30]))
    values = likelihood.measurement.values
    rms = np.sqrt(np.mean((values - values.mean()) ** 2))
    assert likelihood.noise(found.theta).sd(values.mean()) == pytest.approx(rms, rel=0.01)


@pytest.mark.parametrize("seed", range(3))
def test_no_other_start_of_the_noise_leads_higher(rotor, truth, seed):
    likelihood = likelihood_of(rotor, truth, "complex", noise=Noise(0.05, 1e-6), noise_known=False, seed=seed)
    first = maximise(likelihood, likelihood.start(truth))
    best = with_best_noise(likelihood, first)
    assert best.deviance <= first.deviance
    for noise in likelihood.noise_starts(best.theta[:5]):
        again = maximise(likelihood, np.concatenate([best.theta[:5], noise]))
        assert again.deviance >= best.deviance - 1e-5  # twice the tolerance of a maximum, and more


def test_another_level_of_the_noise_leads_to_other_unknowns():
    """Few data: with more of a floor the unknowns move, and the maximum there is the higher one."""
    settings = ThreeDisk(sensors=[0.1], n_speed=13)
    problem = settings.build()
    u = problem.parameters.to_cube(np.array(list(settings.reference().values())))
    likelihood = likelihood_of(problem, u, "amplitude", noise=Noise(0.02, 5e-6), noise_known=False, seed=36)
    first = maximise(likelihood, likelihood.start(u))
    assert with_best_noise(likelihood, first).deviance < first.deviance - 1


def test_known_noise_is_left_alone(rotor, truth):
    likelihood = likelihood_of(rotor, truth, "complex")
    point = likelihood.at(truth)
    assert with_best_noise(likelihood, point) is point


class OneUnknown:
    """A likelihood of one unknown that counts its points."""

    d, least_gain, linearises_at_once = 1, 0.0, False
    lower, upper, period, longest_step = np.zeros(1), np.ones(1), np.full(1, np.inf), np.full(1, np.inf)

    def __init__(self):
        self.n_point = 0

    def at(self, theta):
        self.n_point += 1
        return Point(theta, self.deviance(theta), self.gradient(theta), np.full((1, 1), self.whitened))

    def curvature(self, point, step):
        return np.zeros(1)


class Slow(OneUnknown):
    """A deviance θ, of which each step takes 0.01 and promises 1."""

    whitened = 100.0

    def deviance(self, theta):
        return float(theta[0])

    def gradient(self, theta):
        return np.array([200.0])


def test_points_are_asked_for_at_once_where_no_budget_counts_and_none_is_refused(rotor, truth):
    known = likelihood_of(rotor, truth, "complex")
    assert known.linearises_at_once
    assert not Likelihood(Model(rotor), known.measurement, stable_only=True).linearises_at_once
    assert not Likelihood(Model(rotor, 100), known.measurement).linearises_at_once
    assert not Likelihood(Model(CountedProblem(rotor)), known.measurement).linearises_at_once
    assert not of_wave(None).linearises_at_once


def test_a_search_with_nothing_free_stays_without_a_word(capfd):
    found = maximise(Slow(), np.ones(1), fixed=0)
    assert found.theta == 1 and found.deviance == 1
    assert capfd.readouterr() == ("", "")


def points_of(likelihood, ceiling, max_iterations):
    maximise(likelihood, np.ones(1), max_iterations=max_iterations, tolerance=0.0, ceiling=ceiling)
    return likelihood.n_point


def test_steps_that_gain_less_than_the_likelihood_asks_for_end_a_search():
    """One point at the start, and one after the step of 0.01 that ends it."""
    slow = Slow()
    slow.least_gain = 0.05
    maximise(slow, np.ones(1))
    assert slow.n_point == 2


def test_a_search_is_given_up_that_would_not_come_below_a_ceiling_at_its_pace():
    """In 60 steps it comes down to 0.4."""
    assert points_of(Slow(), 0.45, 60) == points_of(Slow(), np.inf, 60) == 61
    assert PATIENCE < points_of(Slow(), 0.3, 60) < PATIENCE + 3


class Bowl(OneUnknown):
    """A deviance of (θ − 1/2)² with the information of one a hundred times as narrow: each step goes a hundredth of the way and
    promises a hundredth of what is left."""

    whitened = 10.0

    def deviance(self, theta):
        return float((theta[0] - 0.5) ** 2)

    def gradient(self, theta):
        return 2 * (theta - 0.5)


class Cliff(Bowl):
    """A bowl whose steps are whole, and no response beyond θ = 0.6, where the first one leads to."""

    whitened, linearises_at_once = 0.8, True

    def at(self, theta):
        if theta[0] > 0.6:
            raise np.linalg.LinAlgError
        return super().at(theta)

    def deviance(self, theta):
        return super().deviance(theta) if theta[0] <= 0.6 else np.inf


def test_where_points_are_asked_for_at_once_a_step_without_a_response_is_taken_back():
    found = maximise(Cliff(), np.array([0.1]))
    assert found.theta == pytest.approx(0.5, abs=1e-3)


def test_a_search_whose_steps_promise_too_little_is_given_up_early():
    """It begins at 0.25, and comes down to 0.20 in 10 steps; ten times what a step promises is a tenth of what is left."""
    assert points_of(Bowl(), 0.22, 10) == points_of(Bowl(), np.inf, 10) == 11
    assert points_of(Bowl(), 0.1, 10) == SETTLED + 1


def test_only_survivors_that_come_near_the_best_go_on(rotor, truth):
    likelihood = likelihood_of(rotor, truth, "complex")
    starts = [truth, np.clip(truth + 0.3, 0, 1)]
    all_of_them = best_maxima(likelihood, starts, first_iterations=2, survivors=2)
    near = best_maxima(likelihood, starts, first_iterations=2, survivors=2, reach=25.0)
    assert near[0].deviance == all_of_them[0].deviance
    assert near[-1].deviance >= all_of_them[-1].deviance
