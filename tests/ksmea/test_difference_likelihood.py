"""Differences between runs: by brute force from their covariance, whatever the reference, and free of what is alike."""

import dataclasses

import numpy as np
import pytest

import ksmea
from campaigns import TRIAL, TRUTH, layout_of, measured
from ksmea.errors import SettingError
from ksmea.fits.fitting import Fit
from ksmea.fits.lack_of_fit import fit_quality
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.difference_likelihood import DifferenceLikelihood, likelihood_of
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.campaign import Weight
from ksmea.measurement.noise import Noise
from ksmea.problem.alignment import aligned
from ksmea.problem.case import Case
from ksmea.problem.counted import Model
from optimizers.lm import LM
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.5]).build()
SPEED = np.linspace(200, 1500, 9)
RUNS = [("bare", ()), ("one", (TRIAL,)), ("two", (Weight(0.2, 1e-4, 2.0),))]
LAYOUT = layout_of(PROBLEM, [SPEED, SPEED * (1 + 2e-4), SPEED], RUNS)
NOISE = Noise(0.03, 5e-8)
DATA = measured(PROBLEM, LAYOUT, noise=NOISE)


def _by_differences(data, reference="bare"):
    return dataclasses.replace(data, campaign=dataclasses.replace(data.campaign, reference=reference))


def _likelihood(data):
    return likelihood_of(Case(aligned(PROBLEM, data), data))


def _theta(likelihood):
    problem = likelihood.model.problem
    u = problem.parameters.to_cube(np.array([TRUTH[name] for name in problem.parameters.names])) + 2e-4
    if not likelihood.noise_is_estimated:
        return u
    return np.concatenate([u, np.tile(np.log([0.02, 8e-8]), (len(likelihood.lower) - likelihood.d) // 2)])


def _covariance(variance, reference):
    """Of the differences of three runs from one of them, and the matrix that takes them."""
    take = np.delete(np.eye(3), reference, axis=0) - np.eye(3)[reference]
    return take, take @ np.diag(variance) @ take.T


def _brute_force(likelihood, theta, reference):
    """−2 ln L of the differences from one run, datum by datum, up to what does not depend on θ."""
    data, total = likelihood.measurement, 0.0
    response = likelihood.model.response(theta[None, : likelihood.d])[0]
    variance = np.broadcast_to(likelihood.noise(theta).variance(np.abs(data.values)), data.values.shape)
    for speed in range(len(SPEED)):
        rows = speed + len(SPEED) * np.arange(3)
        for channel in range(len(data.channels)):
            take, covariance = _covariance(variance[rows, channel], reference)
            left = take @ (data.values - response)[rows, channel]
            total += 2 * (np.linalg.slogdet(covariance)[1] + np.real(np.conj(left) @ np.linalg.solve(covariance, left)))
    return total


@pytest.mark.parametrize("own_noise", [False, True])
@pytest.mark.parametrize("reference", [0, 1, 2])
def test_it_is_the_likelihood_of_the_differences_from_any_run(reference, own_noise):
    """Between two points, so that constants cancel: for the noise known, unknown, and each run its own."""
    campaign = dataclasses.replace(DATA.campaign, own_noise=own_noise)
    likelihood = _likelihood(_by_differences(dataclasses.replace(DATA, campaign=campaign)))
    one = _theta(likelihood)
    other = one + np.random.default_rng(0).normal(0, 1e-3, len(one))
    other[likelihood.d :] += np.linspace(0.2, 0.6, len(one) - likelihood.d)
    expected = _brute_force(likelihood, other, reference) - _brute_force(likelihood, one, reference)
    assert likelihood.deviance(other) - likelihood.deviance(one) == pytest.approx(expected, rel=1e-9)
    assert likelihood.at(one).deviance == pytest.approx(likelihood.deviance(one), rel=1e-12)


@pytest.mark.parametrize("noise", [NOISE, None])
def test_the_gradient_is_that_of_the_deviance(noise):
    likelihood = _likelihood(_by_differences(dataclasses.replace(DATA, noise=noise)))
    theta, step = _theta(likelihood), 1e-6
    by_differences = [
        (likelihood.deviance(theta + change) - likelihood.deviance(theta - change)) / (2 * step)
        for change in step * np.eye(len(theta))
    ]
    assert likelihood.at(theta).gradient == pytest.approx(by_differences, rel=1e-4, abs=1e-2)


LACKING = {"bare": [0, 4], "one": [2], "two": [0, 1, 2]}  # indices of speeds; two runs, one run or none lack one


def _with_gaps():
    kept = [np.delete(SPEED, gap) for gap in LACKING.values()]
    return measured(PROBLEM, layout_of(PROBLEM, kept, RUNS), noise=Noise(0.0, 2e-7))


def test_a_speed_that_a_run_lacks_is_in_the_differences_of_the_others():
    """Between two points, datum by datum: of speeds that one run has alone there is nothing."""
    data = _by_differences(dataclasses.replace(_with_gaps(), noise=NOISE))
    likelihood = _likelihood(data)
    one = _theta(likelihood)
    other = one + np.random.default_rng(0).normal(0, 1e-3, len(one))

    def brute_force(theta):
        left, total = data.values - likelihood.model.response(theta[None])[0], 0.0
        variance = NOISE.variance(np.abs(data.values))
        for speed in SPEED:
            rows = np.flatnonzero(data.speed == speed)
            take = np.eye(len(rows))[1:] - np.eye(len(rows))[0]
            for channel in range(len(data.channels)):
                covariance = take @ np.diag(variance[rows, channel]) @ take.T
                of_runs = take @ left[rows, channel]
                total += 2 * np.real(np.conj(of_runs) @ np.linalg.solve(covariance, of_runs))
        return total

    found = likelihood.deviance(other) - likelihood.deviance(one)
    assert found == pytest.approx(brute_force(other) - brute_force(one), rel=1e-9)
    n_differences = len(data.speed) - len(SPEED)
    assert likelihood.n_residual == n_differences * len(data.channels) * 2


@pytest.mark.parametrize("reference", ["bare", "two"])
def test_runs_that_lack_speeds_are_identified_by_differences(reference):
    """With a runout, from whatever run; intervals of 99.9 % each, narrower than of the speeds that all runs have."""
    data = _with_gaps()
    data = _by_differences(dataclasses.replace(data, values=data.values + 5e-6, noise=Noise(0.0, 2e-7)), reference)
    search = LM(screening=1000, starts=3)
    found = ksmea.identify(PROBLEM, data, level=0.999, optimizer=search)
    common = np.flatnonzero(np.isin(data.speed, [speed for speed in SPEED if np.sum(data.speed == speed) == len(RUNS)]))
    of_common = ksmea.identify(PROBLEM, data.part(common), level=0.999, optimizer=search)
    for name in ("kxx", "kyy"):
        truth = TRUTH[name] / 1e6
        assert found[name].low < truth < found[name].high
        assert found[name].high - found[name].low < of_common[name].high - of_common[name].low


def test_the_information_is_that_of_the_differences():
    """tr(C⁻¹ ∂C C⁻¹ ∂C) + 2 Re(∂d* C⁻¹ ∂d) from the covariance of the differences from the second run."""
    likelihood = _likelihood(_by_differences(DATA))
    theta, d = _theta(likelihood), likelihood.d
    found = likelihood.at(theta).information
    _, slope = likelihood.model.linearise(theta[:d])
    amplitude = np.abs(DATA.values)
    relative, floor = np.exp(theta[d:])
    variance = Noise(relative, floor).variance(amplitude)
    changes = [2 * (relative * amplitude) ** 2, np.full_like(amplitude, 2 * floor**2)]
    expected = np.zeros_like(found)
    for speed in range(len(SPEED)):
        rows = speed + len(SPEED) * np.arange(3)
        for channel in range(amplitude.shape[1]):
            take, covariance = _covariance(variance[rows, channel], 1)
            inverse = np.linalg.inv(covariance)
            of_mean = take @ slope[rows, channel]
            expected[:d, :d] += 2 * np.real(np.conj(of_mean).T @ inverse @ of_mean)
            moved = [inverse @ take @ np.diag(change[rows, channel]) @ take.T for change in changes]
            expected[d:, d:] += [[np.trace(one @ other) for other in moved] for one in moved]
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8 * np.abs(expected).max())


def test_what_is_alike_in_all_runs_cancels():
    """A runout ten times the response of the bare run, another at each speed, as long as it is in all runs."""
    likelihood = _likelihood(_by_differences(dataclasses.replace(DATA, noise=Noise(0.0, 2e-7))))
    rng = np.random.default_rng(1)
    alike = 1e-5 * (rng.standard_normal((len(SPEED), 4)) + 1j * rng.standard_normal((len(SPEED), 4)))
    moved = dataclasses.replace(likelihood.measurement, values=DATA.values + np.tile(alike, (3, 1)))
    theta = _theta(likelihood)
    assert _likelihood(moved).deviance(theta) == pytest.approx(likelihood.deviance(theta), rel=1e-9)
    response = likelihood.model.response(theta[None])[0]
    shown = _likelihood(moved).alike(theta, response) - likelihood.alike(theta, response)
    np.testing.assert_allclose(shown, np.tile(alike, (3, 1)), rtol=1e-9)


def test_an_unbalance_that_all_runs_have_is_not_known():
    likelihood = _likelihood(_by_differences(DATA))
    names = likelihood.model.problem.parameters.names
    information = np.diag(likelihood.at(_theta(likelihood)).information)
    both = Likelihood(Model(aligned(PROBLEM, DATA)), DATA).at(_theta(likelihood)).information
    share = information[: len(names)] / np.diag(both)[: len(names)]
    # speeds that are alike within 2 parts in 10⁴ leave next to nothing of it; all else is known
    assert share[names.index("u")] < 1e-4
    assert np.all(share[[names.index(name) for name in ("kxx", "kyy", "phase_origin")]] > 0.05)


def test_intervals_hold_the_truth_as_often_as_they_say():
    """z of the unknowns but u over 60 draws with a constant runout: mean 0 ± 0.13, spread 1 ± 0.09; 4 standard errors."""
    z = []
    for seed in range(60):
        data = measured(PROBLEM, LAYOUT, noise=Noise(0.0, 2e-7), seed=seed)
        data = _by_differences(dataclasses.replace(data, values=data.values + 5e-6, noise=Noise(0.0, 2e-7)))
        likelihood = _likelihood(data)
        assert isinstance(likelihood, DifferenceLikelihood)
        names = likelihood.model.problem.parameters.names
        known = [index for index, name in enumerate(names) if name != "u"]
        truth = likelihood.model.problem.parameters.to_cube(np.array([TRUTH[name] for name in names]))
        point = maximise(likelihood, truth)
        sd = np.sqrt(np.diag(np.linalg.inv(point.information[np.ix_(known, known)])))
        z.append((point.theta - truth)[known] / sd)
    assert np.all(np.abs(np.mean(z, axis=0)) < 4 * 0.13)
    assert np.all(np.abs(np.std(z, axis=0) - 1) < 4 * 0.09)


def test_the_lack_of_fit_test_keeps_its_level():
    """Of differences with a runout, under the right model: p < 0.2 in 20 % of draws; of 40, 8 ± 2.5."""
    p = []
    for seed in range(40):
        data = measured(PROBLEM, LAYOUT, noise=Noise(0.0, 2e-7), seed=seed)
        data = _by_differences(dataclasses.replace(data, values=data.values + 5e-6, noise=Noise(0.0, 2e-7)))
        likelihood = _likelihood(data)
        point = maximise(likelihood, _theta(likelihood))
        fit = Fit(likelihood, point)
        p.append(fit_quality(fit, np.random.default_rng(seed), n_simulated=300).p)
    assert 1 <= np.sum(np.array(p) < 0.2) <= 16


def test_differences_that_mean_nothing_are_refused():
    with pytest.raises(SettingError, match="unknown run of the reference: 'bear'; did you mean 'bare'"):
        _by_differences(DATA, "bear")
    with pytest.raises(SettingError, match="reference: expected phases for differences between runs"):
        _by_differences(dataclasses.replace(DATA, values=np.abs(DATA.values)))
