"""The model with something unknown at each speed: what is eliminated leaves no trace, and the rest is as without it."""

import numpy as np
import pytest

from ksmea.inference.maximisation import maximise
from ksmea.location.restricted_noise import restricted_noise
from ksmea.location.unknown_force import LATERAL, QUANTITIES, READING, ProjectedLikelihood, Unmodelled
from ksmea.measurement.campaign import Campaign, Run, Weight
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.campaign_problem import CampaignProblem
from ksmea.problem.case import Case
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.5, 1.0], n_speed=30).build()
TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
U = PROBLEM.parameters.to_cube(TRUTH)
NOISE = Noise(0.05, 1e-7)
RESPONSE = PROBLEM.response(TRUTH[None])[0]
SD = NOISE.sd(np.abs(RESPONSE))


def likelihood_of(unmodelled, values, problem=PROBLEM, sd=SD):
    measurement = Measurement(problem.speed, problem.channels, values, NOISE, "test", campaign=problem.campaign)
    return ProjectedLikelihood(Case(problem, measurement), unmodelled, sd)


def acting(unmodelled, rng):
    """Anything at all at a place, about as large as the response, and what it does to the data."""
    columns = unmodelled.columns(PROBLEM, TRUTH[None])[0]
    free = rng.standard_normal((2, len(columns), columns.shape[2])) / np.abs(columns).max(axis=(0, 1))
    free = 1e-5 * (free[0] + 1j * free[1])
    return free, (columns @ free[..., None])[..., 0]


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_whatever_acts_is_found_and_leaves_nothing(quantity):
    unmodelled = Unmodelled(quantity, 0.5)
    free, added = acting(unmodelled, np.random.default_rng(1))
    point = likelihood_of(unmodelled, RESPONSE + added).at(U)
    # without noise all is exact but for rounding, which grows with the ratio of what acts to the noise, below 1e5
    assert np.sqrt(point.deviance) < 1e-6
    np.testing.assert_allclose(point.free, free, rtol=0, atol=1e-6 * np.abs(free).max())
    np.testing.assert_allclose(point.mean, RESPONSE + added, rtol=0, atol=1e-9 * np.abs(RESPONSE).max())


def test_the_gradient_is_that_of_the_deviance_away_from_the_best_point():
    """Kaufman's Jacobian leaves out a term whose product with the residual is zero: the gradient is exact."""
    values = observe(RESPONSE, "complex", NOISE, np.random.default_rng(2))
    likelihood = likelihood_of(Unmodelled("force", 0.3), values)
    u = U + 0.03
    gradient = likelihood.at(u).gradient
    step = 1e-6 * np.eye(len(u))
    differences = [(likelihood.deviance(u + each) - likelihood.deviance(u - each)) / 2e-6 for each in step]
    np.testing.assert_allclose(gradient, differences, rtol=1e-4)  # of second-order differences twice over


def problems():
    """The rotor, with effects of all that is linearised in ways of its own, and in two runs."""
    yield "plain", PROBLEM
    for name in ("runout", "youngs_modulus", "shaft_asymmetry"):
        yield name, registry.create("effect", name, {}).locations(PROBLEM)[0].added_to(PROBLEM)
    twice = PROBLEM.at(np.tile(PROBLEM.speed, 2), PROBLEM.channels)
    weight = Weight(0.5, 2e-4, 0.0)
    yield "two runs", CampaignProblem(twice, Campaign((Run("bare", 30), Run("weight", 30, (weight,)))))


FREE = (Unmodelled(), Unmodelled(READING, 0.5), Unmodelled("force", 0.3))
LINEARISED = {
    f"{name}, {unmodelled}": (problem, unmodelled)
    for name, problem in problems()
    for unmodelled in FREE
    if not (name == "shaft_asymmetry" and unmodelled.loads)  # unit loads are refused beside what turns
}


@pytest.mark.parametrize(("problem", "unmodelled"), list(LINEARISED.values()), ids=list(LINEARISED))
def test_all_that_is_free_is_linearised_as_differences_of_the_deviance_have_it(problem, unmodelled):
    u = np.append(U, np.full(len(problem.parameters) - len(U), 0.52)) + 0.01
    response = problem.response(problem.parameters.to_si(u)[None])[0]
    sd = NOISE.sd(np.abs(response))
    values = observe(response, "complex", NOISE, np.random.default_rng(7))
    likelihood = likelihood_of(unmodelled, values, problem, sd)
    point = likelihood.at(u + 0.003)
    step = 1e-6 * np.eye(len(u))
    differences = [
        (likelihood.deviance(point.theta + each) - likelihood.deviance(point.theta - each)) / 2e-6 for each in step
    ]
    np.testing.assert_allclose(point.deviance, likelihood.deviance(point.theta), rtol=1e-9)
    # of second-order differences, beside the largest
    np.testing.assert_allclose(point.gradient, differences, rtol=1e-4, atol=1e-5 * np.abs(differences).max())


def test_an_unbalance_at_the_very_site_cannot_be_told_and_stays_where_it_is():
    values = observe(RESPONSE, "complex", NOISE, np.random.default_rng(3))
    likelihood = likelihood_of(Unmodelled("force", 0.5), values)  # where the model has its own unbalance
    start = U + 0.02
    found = likelihood.at(maximise(likelihood, start).theta)
    assert found.n_searched == 4
    assert found.theta[4] == start[4]
    assert np.all(found.theta[:4] != start[:4])


def test_a_reading_that_is_free_is_a_plane_left_out():
    values = observe(RESPONSE, "complex", NOISE, np.random.default_rng(4))
    free = likelihood_of(Unmodelled(READING, 0.5), values).at(U + 0.01)
    kept = [index for index, channel in enumerate(PROBLEM.channels) if channel.position != 0.5]
    fewer = PROBLEM.at(PROBLEM.speed, [PROBLEM.channels[index] for index in kept])
    left = likelihood_of(Unmodelled(), values[:, kept], fewer, SD[:, kept]).at(U + 0.01)
    assert free.deviance == pytest.approx(left.deviance, rel=1e-12)
    assert free.n_left == left.n_left
    np.testing.assert_allclose(free.gradient, left.gradient, rtol=1e-9, atol=1e-9 * np.abs(left.gradient).max())


@pytest.mark.parametrize("quantity, n_free", [("force", 2), ("moment", 2), (LATERAL, 4), (READING, 2)])
def test_real_data_are_counted_that_nothing_takes(quantity, n_free):
    point = likelihood_of(Unmodelled(quantity, 0.1), RESPONSE).at(U)
    assert point.n_left == 2 * 30 * (6 - n_free) - 5


def test_chi2_of_the_true_site_is_chi2():
    """Over noise draws the mean is the number of real data left, within four standard errors of √(2 n / 40)."""
    unmodelled = Unmodelled("force", 1.0)
    _, added = acting(unmodelled, np.random.default_rng(5))
    found, sd = [], NOISE.sd(np.abs(RESPONSE + added))
    for seed in range(40):
        values = observe(RESPONSE + added, "complex", NOISE, np.random.default_rng([5, seed]))
        likelihood = likelihood_of(unmodelled, values, sd=sd)
        point = likelihood.at(maximise(likelihood, U).theta)
        found.append(point.deviance)
    assert np.mean(found) == pytest.approx(point.n_left, abs=4 * np.sqrt(2 * point.n_left / 40))


def test_the_noise_is_not_taken_for_small_where_the_force_takes_data():
    """A third of the data goes to the force: plain maximum likelihood would have √(2/3) of the noise, 18 % too little."""
    columns = Unmodelled("force", 1.0).columns(PROBLEM, TRUTH[None])[0]
    found = [
        restricted_noise(
            observe(RESPONSE, "complex", NOISE, np.random.default_rng([6, seed])) - RESPONSE,
            columns,
            RESPONSE,
            RESPONSE,
            0,
        )
        for seed in range(40)
    ]
    # one estimate scatters by about 1/√(2 · 240 / 2), half of the data telling each part; four standard errors of 40
    assert np.mean([each.relative for each in found]) == pytest.approx(NOISE.relative, rel=0.04)
    assert np.median([each.floor for each in found]) == pytest.approx(NOISE.floor, rel=0.08)
