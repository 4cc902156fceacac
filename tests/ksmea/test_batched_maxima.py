"""Likelihoods of many data sets as one batch: a second route to `ksmea.likelihood.likelihood` and `ksmea.inference.maximisation`."""

import dataclasses

import numpy as np
import pytest

from ksmea.inference.batched_maxima import LEAST_GAIN, BatchedLikelihood, Fits, batched_maxima
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.campaign import Campaign, Run
from ksmea.problem.alignment import aligned
from ksmea.problem.counted import Model
from likelihood_cases import CASES, measured
from problems.three_disk import ThreeDisk

N_SET = 4


@pytest.fixture(scope="module")
def rotor():
    return ThreeDisk(n_speed=21).build()


@pytest.fixture(scope="module")
def truth(rotor):
    return rotor.parameters.to_cube(np.array(list(ThreeDisk().reference().values())))


def likelihoods(rotor, truth, kind, noise_known):
    """Of each data set by itself, and of all as one batch."""
    data = [measured(rotor, truth, kind, noise_known=noise_known, seed=seed) for seed in range(N_SET)]
    single = [Likelihood(Model(rotor), each) for each in data]
    return single, BatchedLikelihood(single[0], np.stack([each.values for each in data]))


@CASES
def test_a_batch_has_gradient_information_and_deviance_of_each(rotor, truth, kind, noise_known):
    single, batch = likelihoods(rotor, truth, kind, noise_known)
    near = truth + np.random.default_rng(1).uniform(-1e-3, 1e-3, (N_SET, len(truth)))
    theta = np.stack([each.start(u) for each, u in zip(single, near)])
    there = [each.at(row) for each, row in zip(single, theta)]
    gradient, information = batch.scoring(theta, np.arange(N_SET))
    scale = np.stack([np.sqrt(np.diag(point.information)) for point in there])
    # differences to one side, by a step of 1e-6 of the box, miss sharp resonances by some 1e-4
    assert gradient / scale == pytest.approx(np.stack([point.gradient for point in there]) / scale, abs=1e-2)
    for own, point, size in zip(information, there, scale):
        assert own / np.outer(size, size) == pytest.approx(point.information / np.outer(size, size), abs=1e-3)
    # up to a constant of the data: as differences between two points
    other = np.stack([each.start(u) for each, u in zip(single, near[::-1])])
    change = batch.deviance(other, np.arange(N_SET)) - batch.deviance(theta, np.arange(N_SET))
    expected = [each.deviance(to) - each.deviance(row) for each, to, row in zip(single, other, theta)]
    assert change == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_noise_of_its_own_for_each_run_is_that_of_its_speeds(rotor, truth):
    campaign = Campaign((Run("first", 10), Run("second", 11)), own_noise=True)
    data = dataclasses.replace(measured(rotor, truth, "complex", noise_known=False), campaign=campaign)
    single = Likelihood(Model(aligned(rotor, data)), data)
    theta = np.concatenate([truth, np.log([0.1, 1e-7, 0.3, 1e-8])])
    gradient, information = BatchedLikelihood(single, data.values[None]).scoring(theta[None], np.zeros(1, dtype=int))
    point = single.at(theta)
    scale = np.sqrt(np.diag(point.information))
    assert gradient[0] / scale == pytest.approx(point.gradient / scale, abs=1e-2)
    assert information[0] / np.outer(scale, scale) == pytest.approx(
        point.information / np.outer(scale, scale), abs=1e-3
    )


@CASES
@pytest.mark.parametrize("fixed", [None, 0, 3])
def test_fits_of_a_batch_end_where_single_ones_do(rotor, truth, kind, noise_known, fixed):
    single, batch = likelihoods(rotor, truth, kind, noise_known)
    theta = np.stack([each.start(truth) for each in single])
    index = None if fixed is None else np.full(N_SET, fixed)
    found = batched_maxima(batch, theta, np.arange(N_SET), index)
    for each, start, end in zip(single, theta, found.theta):
        # a fit ends with an expected gain below LEAST_GAIN; where a floor of the noise hardly shows, some such steps are left
        left = (10 if each.noise_is_estimated else 2) * LEAST_GAIN
        assert each.deviance(end) == pytest.approx(maximise(each, start, fixed=fixed).deviance, abs=left)
        assert fixed is None or end[fixed] == start[fixed]


def test_fits_stay_within_the_limits(rotor, truth):
    narrow = ThreeDisk(n_speed=21, limits={"cxx": [0.6, 1.0]}).build()  # the true 0.5 kN s/m is outside
    data = measured(rotor, truth, "complex")
    likelihood = Likelihood(Model(narrow), data)
    u = np.clip(narrow.parameters.to_cube(rotor.parameters.to_si(truth)), 0, 1)
    found = batched_maxima(BatchedLikelihood(likelihood, data.values[None]), u[None], np.zeros(1, dtype=int))
    assert found.theta[0, 2] == 0.0
    assert likelihood.deviance(found.theta[0]) == pytest.approx(maximise(likelihood, u).deviance, abs=2 * LEAST_GAIN)


def test_of_fits_with_like_deviances_one_is_kept():
    fits = Fits(
        np.arange(5.0)[:, None], np.array([1, 0, 1, 0, 1]), np.array([3.0, 2.0, 3.01, 1.0, 7.0]), np.ones((5, 1, 1))
    )
    assert fits.distinct(0.02).theta[:, 0].tolist() == [3.0, 1.0, 0.0, 4.0]
    assert fits.distinct(np.inf).theta[:, 0].tolist() == [3.0, 0.0]


def test_a_tangent_is_what_the_information_has():
    fits = Fits(np.zeros((1, 2)), np.zeros(1, dtype=int), np.zeros(1), np.array([[[4.0, 2.0], [2.0, 25.0]]]))
    # the second follows the first by −2/25 of it, the first the second by −2/4
    assert fits.tangents(np.array([0])) == pytest.approx(np.array([[1.0, -2 / 25]]), rel=1e-5)
    assert fits.tangents(np.array([1])) == pytest.approx(np.array([[-2 / 4, 1.0]]), rel=1e-5)
