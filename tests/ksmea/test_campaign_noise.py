"""Runs with noise of their own: the joint likelihood is that of the runs side by side, and each level is found."""

import dataclasses

import numpy as np
import pytest

import ksmea
from campaigns import TRIAL, TRUTH, layout_of, measured
from ksmea.diagnosis.predictive_gain import predictive_gain
from ksmea.fits.fitting import Fit
from ksmea.inference.cramer_rao import identifiability
from ksmea.inference.intervals import estimate
from ksmea.inference.maximisation import nearest_maximum
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.noise import Noise
from ksmea.plugins.registry import create
from ksmea.problem.alignment import aligned
from ksmea.problem.counted import Model
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.5]).build()
SPEEDS = [np.linspace(200, 1500, 27), np.linspace(300, 1400, 40)]
LAYOUT = layout_of(PROBLEM, SPEEDS, [("bare", ()), ("trial", (TRIAL,))])
OWN = dataclasses.replace(LAYOUT, campaign=dataclasses.replace(LAYOUT.campaign, own_noise=True))
LEVELS = ((0.01, 1e-8), (0.10, 3e-8))
NOISE = Noise.of_runs(LEVELS, LAYOUT.rows)
DATA = measured(PROBLEM, OWN, noise=NOISE)
SEEN = aligned(PROBLEM, OWN)
X = np.array([TRUTH[name] for name in SEEN.parameters.names])
U = SEEN.parameters.to_cube(X)
THETA = np.concatenate([U + 1e-4, np.log(LEVELS).ravel()])


def _alone(rows, problem):
    part = dataclasses.replace(DATA.part(np.arange(rows.start, rows.stop)), campaign=None)
    return Likelihood(Model(problem), part)


def _runs():
    return [_alone(rows, run) for rows, (_, _, run) in zip(LAYOUT.rows, SEEN._seen)]


def test_the_joint_deviance_is_the_sum_of_those_of_the_runs_each_with_its_own_noise():
    joint, alone = Likelihood(Model(SEEN), DATA), _runs()
    parts = [THETA[: len(U)], *np.log(LEVELS)]
    point = joint.at(THETA)
    points = [run.at(np.concatenate([parts[0], own])) for run, own in zip(alone, parts[1:])]
    assert joint.deviance(THETA) == pytest.approx(sum(each.deviance for each in points), rel=1e-10)
    gradient = np.concatenate(
        [sum(each.gradient[: len(U)] for each in points), *(each.gradient[-2:] for each in points)]
    )
    np.testing.assert_allclose(point.gradient, gradient, rtol=1e-8, atol=1e-6)
    d, information = len(U), np.zeros((len(THETA), len(THETA)))
    for index, each in enumerate(points):
        where = [*range(d), d + 2 * index, d + 2 * index + 1]
        information[np.ix_(where, where)] += each.information
    np.testing.assert_allclose(point.information, information, rtol=1e-8, atol=1e-8 * np.abs(information).max())


def test_each_level_is_found():
    found = estimate(Likelihood(Model(SEEN), DATA), nearest_maximum(Likelihood(Model(SEEN), DATA), U), level=0.95)
    # the larger part of n data of a run is known within 1/√(2 n) of itself: 7 % and 6 % here; 4 standard errors
    np.testing.assert_allclose([found.noise.levels[0][0], found.noise.levels[1][0]], [0.01, 0.10], rtol=0.3)


def test_a_noisy_run_costs_the_clean_one_nothing():
    """With one level for both, the clean run would count as little as the noisy one, and intervals be wider."""
    shared = dataclasses.replace(DATA, campaign=LAYOUT.campaign)
    both = []
    for data in (DATA, shared):
        seen = aligned(PROBLEM, data)
        likelihood = Likelihood(Model(seen), data)
        both.append(estimate(likelihood, nearest_maximum(likelihood, U), level=0.95).intervals)
    own, together = ([each.high - each.low for each in intervals] for intervals in both)
    assert np.all(np.array(own)[:2] < 0.5 * np.array(together)[:2])  # of the stiffnesses


def test_the_bound_of_runs_with_known_noise_is_that_of_their_information_added():
    crlb = identifiability(SEEN, X, NOISE, "complex").crlb
    alone = [
        identifiability(run, X, Noise(*level), "complex").information for (_, _, run), level in zip(SEEN._seen, LEVELS)
    ]
    np.testing.assert_allclose(crlb, np.sqrt(np.diag(np.linalg.inv(sum(alone)))), rtol=1e-6)


def test_left_out_blocks_have_the_noise_of_their_runs():
    """A block leaves out other numbers of speeds of each run than are kept; a model is not better than itself."""
    likelihood = Likelihood(Model(SEEN), DATA)
    fit = Fit(likelihood, nearest_maximum(likelihood, U))
    gain = predictive_gain(fit, fit, 5)
    assert gain.elpd.total == 0 and np.isfinite(gain.rmse_after)


def test_a_diagnosis_says_the_noise_of_each_run():
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.5])
    found = ksmea.diagnose(rotor, DATA, effects=["none"])
    (bare, *bare_level), (trial, *trial_level) = found.record.noise.before.by_run
    assert (bare, trial) == ("bare", "trial")
    np.testing.assert_allclose([bare_level[0], trial_level[0]], [0.01, 0.10], rtol=0.3)  # as above
    assert found.verdict == "adequate" and "run bare " in str(found) and "noise of its own for each" in str(found)


@pytest.mark.slow
def test_an_unknown_force_is_located_beside_the_noise_of_each_run():
    """Unbalance on the first disk, that the model has not: where it acts is found, in the noise that each run has."""
    hidden = create("effect", "unbalance", {"position": 0.2}).added_to(SEEN)
    x = np.append(X, [4e-5, 2e-5])
    data = dataclasses.replace(DATA, values=DATA.values + (hidden.response(x[None]) - SEEN.response(X[None]))[0])
    found = ksmea.locate(PROBLEM, data, positions=[0.2, 1.2], kinds=["force"])
    assert found.sites == (0.2,)
    levels = [relative for _, relative, _ in found.record.noise.by_run]
    assert levels[0] < 0.3 * levels[1]
