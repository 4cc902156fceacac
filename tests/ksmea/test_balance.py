"""Balancing without a rotor model: closed forms, exactness, coverage, and what is refused."""

import dataclasses

import numpy as np
import pytest

import ksmea
from balancing_cases import PLANES, UNKNOWN, campaign, corrections, machine, polar
from ksmea.balancing.correction import least_squares
from ksmea.balancing.estimation import polar_interval
from ksmea.balancing.fit import Asked, fitted
from ksmea.balancing.influence import Influence
from ksmea.balancing.misfits import misfits_beside_speeds, predicted, run_p
from ksmea.balancing.readings import readings
from ksmea.balancing.variance import Components, RestrictedLikelihood, _factors, _packed
from ksmea.errors import SettingError
from ksmea.measurement.campaign import Campaign, UnknownWeight
from ksmea.measurement.noise import Noise
from ksmea.studies.balance import BalanceOptions, balance
from ksmea.units import RPM

SPEED = [1000.0, 1200.0]
TRIALS = [("bare", {}), ("one", {PLANES[0]: 30.0}), ("two", {PLANES[1]: 20j})]


def made(bare, planes, weights, noise=0.0, rng=None, repeats=1):
    """Responses of a run at two speeds and two channels, µm."""
    own = bare + sum(value * planes[PLANES.index(place)] for place, value in weights.items())
    values = np.repeat(own.reshape(2, -1), repeats, axis=0)
    if rng is not None:
        values = values + noise * (rng.standard_normal((*values.shape, 2)) @ np.array([1, 1j])) / np.sqrt(2)
    return values


def job(rng, runs=TRIALS, noise=0.0, repeats=1, truth=None):
    bare, planes = truth or machine(rng)
    actual = [(name, on, made(bare, planes, on, noise, rng, repeats)) for name, on in runs]
    return campaign(actual, SPEED, repeats=repeats), bare, planes


def two_runs(known):
    """Campaign with two trial weights, the second unknown."""
    bare, one, two = known.runs
    lost = dataclasses.replace(two, weights=(), unknown_weights=(UnknownWeight(two.weights[0].position),))
    return dataclasses.replace(known, runs=(bare, one, lost))


def test_two_planes_by_hand():
    """Cramer's rule on two complex equations: C w = -y0."""
    a, b, c, d, y1, y2 = 1 + 1j, 2j, -1.0, 3 - 1j, 4.0, 2 + 5j
    found = least_squares(np.array([[y1, y2], [a, b], [c, d]]))
    determinant = a * d - c * b
    np.testing.assert_allclose(found, [(-y1 * d + y2 * c) / determinant, (-y2 * a + y1 * b) / determinant], rtol=1e-12)


def test_linear_data_without_noise_give_the_truth():
    rng = np.random.default_rng(1)
    bare, planes = machine(rng)
    unknown = {PLANES[0]: 12 - 5j, PLANES[1]: 3j}
    runs = [(name, on, made(bare, planes, on)) for name, on in TRIALS]
    runs.append(("lost", dict.fromkeys(PLANES, UNKNOWN), made(bare, planes, unknown)))
    found = ksmea.balance(campaign(runs, SPEED))
    told = [each.weight.size * np.exp(1j * np.radians(each.weight.angle)) for each in found.record.weights]
    np.testing.assert_allclose(told, list(unknown.values()), rtol=1e-6)
    np.testing.assert_allclose(corrections(found), np.linalg.lstsq(planes.T, -bare, rcond=None)[0], rtol=1e-9)
    sizes = [each.size for plane in found.record.planes for each in plane.coefficients]
    np.testing.assert_allclose(sizes, np.abs(planes).ravel(), rtol=1e-9)


def test_a_bare_response_of_unbalance_in_the_planes_is_taken_away():
    rng = np.random.default_rng(2)
    _, planes = machine(rng)
    own = np.array([15 + 3j, -7j])
    measurement, _, _ = job(rng, truth=(own @ planes, planes))
    found = ksmea.balance(measurement)
    np.testing.assert_allclose(corrections(found), -own, rtol=1e-9)
    assert max(each.size for each in found.record.correction.left) < 1e-9


def test_without_a_run_to_spare_repeats_or_sigma_there_is_no_interval():
    measurement, _, _ = job(np.random.default_rng(3))
    found = ksmea.balance(measurement).record
    assert found.method == "none" and found.dof == 0
    assert all(each.low is None for plane in found.planes for each in plane.coefficients)
    stated = dataclasses.replace(measurement, noise=Noise(0.0, np.full(measurement.values.shape, 1e-7)))
    assert ksmea.balance(stated).record.method == "stated"


@pytest.fixture
def few_draws(monkeypatch):
    """A fifth of the draws of each correction, which nothing is asserted of."""
    monkeypatch.setattr("ksmea.balancing.correction.N_DRAW", 200)


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_intervals_of_repeats_hold_the_truth_as_often_as_they_say():
    """Repeats of 0.3 µm noise: 95 % regions of unknown weights and corrections, 150 draws. Three standard deviations of a
    binomial share are 0.053; intervals of corrections are linearised, which costs less than that at this noise."""
    rng = np.random.default_rng(4)
    truth, own = machine(rng), {PLANES[0]: 9 + 4j, PLANES[1]: -6j}
    inside = []
    for _ in range(150):
        runs = [(name, on, made(*truth, on, 0.3, rng, 3)) for name, on in TRIALS]
        runs.append(("lost", dict.fromkeys(PLANES, UNKNOWN), made(*truth, own, 0.3, rng, 3)))
        found = balance(campaign(runs, SPEED, time=np.arange(24.0), repeats=3), np.random.default_rng(0))
        inside += [each.weight.low <= abs(own[each.position]) <= each.weight.high for each in found.weights]
    # a region of two dimensions seen from one: its size is inside more often than the 95 % of the region
    assert 0.95 - 0.04 <= np.mean(inside) <= 1.0


def test_a_wrong_mark_is_found_and_told():
    """40 runs, one of them without the weight that its mark says: it is named, and what it carried is told."""
    rng = np.random.default_rng(5)
    truth = machine(rng)
    runs = []
    for number in range(40):
        on = {place: 20 * np.exp(2j * np.pi * rng.random()) for place in PLANES}
        carried = {PLANES[0]: on[PLANES[0]]} if number == 7 else on
        runs.append((f"r{number}", on, made(*truth, carried, 0.1, rng)))
    found = ksmea.balance(campaign(runs, SPEED)).record
    assert [each.run for each in found.run_misfits] == ["r7"]
    told = {each.position: each.weight.size for each in found.run_misfits[0].weights}
    assert told[PLANES[1]] < 1.0 and told[PLANES[0]] == pytest.approx(20, abs=1)
    assert found.method == "free" and found.n_used == 39


def test_right_marks_are_seldom_called_wrong():
    """20 campaigns of 40 runs without a misfit at a level of 0.01 over all tests: more than 2 false alarms have p < 1e-3."""
    rng = np.random.default_rng(6)
    truth, alarms = machine(rng), 0
    for _ in range(20):
        weights = [{place: 20 * np.exp(2j * np.pi * rng.random()) for place in PLANES} for _ in range(40)]
        runs = [(f"r{number}", on, made(*truth, on, 0.1, rng)) for number, on in enumerate(weights)]
        alarms += bool(ksmea.balance(campaign(runs, SPEED), growth="no").record.run_misfits)
    assert alarms <= 2


def test_each_run_from_all_others_is_as_if_it_had_been_left_out():
    """The identity against a fit without the run."""
    rng = np.random.default_rng(7)
    truth = machine(rng)
    weights = [{place: 20 * np.exp(2j * np.pi * rng.random()) for place in PLANES} for _ in range(30)]
    runs = [(f"r{number}", on, made(*truth, on, 0.1, rng)) for number, on in enumerate(weights)]
    fit = fitted(readings(campaign(runs, SPEED), 0.01), np.arange(30), Asked("no", "no", "no"))
    without = fit.without(np.array([3]))
    np.testing.assert_allclose(predicted(fit).residual[3], without.residual(np.array([3]))[0], rtol=1e-6)


def test_the_gradient_of_the_restricted_likelihood_is_its_derivative():
    """Central differences of 1e-5 in logarithms and units of the residuals."""
    rng = np.random.default_rng(8)
    residual = rng.standard_normal((12, 4, 2)) @ np.array([1, 1j])
    columns = np.kron(rng.standard_normal((12, 2))[:, None, :], np.eye(4)).astype(complex)
    time, load = np.sort(rng.random(12)) * 3600, rng.random(12)
    likelihood = RestrictedLikelihood(residual, columns, time, load, 2)
    spread = residual.T @ residual.conj() / 12
    start, unit = Components(spread, spread / 2, 900.0, 0.7), np.ones(4)
    theta, rotated = _packed(start, unit, 2), likelihood._rotated(start)
    gradient = rotated.value_and_gradient(theta, unit, 2)[1]
    for index in range(len(theta)):
        step = np.zeros(len(theta))
        step[index] = 1e-5
        up, down = (rotated.value_and_gradient(theta + sign * step, unit, 2)[0] for sign in (1, -1))
        assert gradient[index] == pytest.approx((up - down) / 2e-5, rel=1e-4, abs=1e-5)
    assert len(_factors(theta, unit, 2)) == 2


def test_a_drift_is_found_where_there_is_one_and_not_elsewhere():
    """60 runs 5 min apart: a drift of 2 µm over an hour beside 0.1 µm of spread, and none."""
    for size, expected in ((2.0, True), (0.0, False)):
        rng = np.random.default_rng(9)
        truth, drift, runs = machine(rng), np.zeros(4, dtype=complex), []
        for number in range(60):
            on = {place: 20 * np.exp(2j * np.pi * rng.random()) for place in PLANES}
            step = np.exp(-300 / 3600)
            drift = step * drift + size * np.sqrt((1 - step**2) / 2) * (rng.standard_normal((4, 2)) @ np.array([1, 1j]))
            runs.append((f"r{number}", on, made(truth[0] + drift, truth[1], on, 0.1, rng)))
        found = ksmea.balance(campaign(runs, SPEED, time=np.repeat(300.0 * np.arange(60), 2)), leave_out=True, folds=2)
        assert (found.record.time_constant is not None) is expected
        # neighbours in time take most of the drift away: plain coefficients leave about 2 µm / 0.2 µm/(g mm) / 2 entries
        assert found.record.left_out.rms_size < (2.5 if expected else 0.6)
        assert 0.85 <= found.record.left_out.coverage <= 1.0  # 120 weights: 0.95 ± three of 0.02 each way


def test_slope_and_growth_are_what_the_data_were_made_with():
    influence = Influence(np.ones((3, 2), dtype=complex), np.array([3.0 + 0j]), 0.2 + 0j, 2.0, np.array([0, 0]))
    weights = np.array([[2.0, 1j]])
    np.testing.assert_allclose(influence.marked(influence.effective(weights)), weights, rtol=1e-10)
    step = 1e-6
    changed = influence.stepped(np.r_[np.zeros(6), step, 0], True, True)
    numeric = (changed.response(weights, np.array([[0.01]])) - influence.response(weights, np.array([[0.01]]))) / step
    np.testing.assert_allclose(influence.columns(weights, np.array([[0.01]]), True, True)[:, :, 6], numeric, rtol=1e-6)


def test_an_entry_beside_its_neighbours_in_speed():
    """A smooth response over 8 speeds with one entry a fifth of what it should be."""
    speed = np.linspace(900.0, 1250.0, 8)
    smooth = 5e2 / (1 - (speed / 1600.0) ** 2 + 0.05j)
    rng = np.random.default_rng(10)
    runs = [(name, on, smooth[:, None] * (1 + 0.1 * number)) for number, (name, on) in enumerate(TRIALS)]
    noisy = [
        (name, on, values + 1.0 * (rng.standard_normal((8, 1, 2)) @ np.array([1, 1j]))) for name, on, values in runs
    ]
    assert misfits_beside_speeds(readings(campaign(noisy, speed), 0.001), 0.01) == []
    noisy[2][2][4] /= 5
    [found] = misfits_beside_speeds(readings(campaign(noisy, speed), 0.001), 0.01)
    assert (found.run, found.entry) == (2, 4)
    assert abs(found.expected) == pytest.approx(1.2e-6 * abs(smooth[4]), rel=0.05)


def test_sizes_and_angles_of_a_region():
    size, angle = polar_interval(polar("2@90"), 1.0)
    assert size == pytest.approx((1, 3))
    assert np.degrees(angle) == pytest.approx((60, 120))  # arcsin(1/2) either way
    assert polar_interval(1.0 + 0j, 2.0) == ((0.0, 3.0), None)


@pytest.mark.parametrize(
    "change, said",
    [
        (lambda m: dataclasses.replace(m, values=np.abs(m.values)), "amplitudes alone"),
        (lambda m: dataclasses.replace(m, campaign=None), "expected a campaign"),
        (lambda m: m.part(np.arange(4)), "expected speeds that the 3 runs share"),
        (lambda m: dataclasses.replace(m, campaign=two_runs(m.campaign)), "tell 2 planes and the bare rotor apart"),
    ],
)
def test_what_cannot_be_balanced_is_refused(change, said):
    measurement, _, _ = job(np.random.default_rng(11))
    with pytest.raises(SettingError, match=said):
        ksmea.balance(change(measurement))


def lacking(measurement, name, speed):
    """A campaign of which one run has not been measured at a speed, rpm."""
    runs = measurement.campaign.runs
    of_row = np.repeat([run.name for run in runs], [run.n_speed for run in runs])
    is_kept = ~((of_row == name) & np.isclose(measurement.speed, speed * RPM))
    fewer = tuple(dataclasses.replace(run, n_speed=int(np.sum(is_kept[of_row == run.name]))) for run in runs)
    values, speeds = measurement.values[is_kept], measurement.speed[is_kept]
    return dataclasses.replace(measurement, speed=speeds, values=values, campaign=Campaign(fewer))


def test_a_speed_that_one_run_lacks_is_fitted_from_the_others():
    """Entries of equal spread, uncorrelated: at each speed ordinary least squares of the runs that have it."""
    rng = np.random.default_rng(13)
    runs = [*TRIALS, ("check", {PLANES[0]: 10 - 4j, PLANES[1]: 8j}), ("again", {})]
    whole, _, _ = job(rng, runs, noise=0.1)
    data = readings(lacking(whole, "check", SPEED[1]), 0.01)
    assert data.remarks == ("of 2 speeds some runs lack a few and are fitted at theirs: check lacks 1",)
    fit = fitted(data, data.is_known, Asked())
    regressors = np.column_stack([np.ones(5), data.weights])
    for entry in range(4):
        own = [0, 1, 2, 3, 4] if entry < 2 else [0, 1, 2, 4]
        expected = np.linalg.lstsq(regressors[own] / [1, 1e-5, 1e-5], data.response[own, entry], rcond=None)[0]
        found = (fit.influence.coefficients + fit.solution.step[:12].reshape(3, 4))[:, entry]
        np.testing.assert_allclose(found, expected / [1, 1e-5, 1e-5], rtol=1e-8)
    assert fit.dof == 5 * 4 - 2 - 3 * 4


def test_an_unknown_weight_is_estimated_at_the_speeds_of_its_run():
    rng = np.random.default_rng(14)
    unknown = {PLANES[0]: 12 - 5j, PLANES[1]: 3j}
    bare, planes = machine(rng)
    runs = [(name, on, made(bare, planes, on)) for name, on in TRIALS]
    runs.append(("lost", dict.fromkeys(PLANES, UNKNOWN), made(bare, planes, unknown)))
    found = ksmea.balance(lacking(campaign(runs, SPEED), "lost", SPEED[0]))
    sizes = [each.weight.size * np.exp(1j * np.radians(each.weight.angle)) for each in found.record.weights]
    np.testing.assert_allclose(sizes, list(unknown.values()), rtol=1e-6)


def test_with_many_runs_a_speed_that_one_lacks_is_kept():
    """The covariance comes from the runs with all speeds; a run with one of two adds what it has."""
    rng = np.random.default_rng(15)
    runs = [(f"r{n}", {PLANES[n % 2]: complex(*rng.standard_normal(2)) * 20}) for n in range(24)]
    whole, bare, planes = job(rng, runs, noise=0.05)
    short = lacking(lacking(whole, "r3", SPEED[1]), "r8", SPEED[0])
    one, other = (fitted(each, each.is_known, Asked()) for each in (readings(whole, 0.01), readings(short, 0.01)))
    assert other.is_free and not one.readings.remarks and len(other.readings.speed) == 2
    truth = np.vstack([bare * 1e-6, planes])
    errors = [np.abs(fit.influence.coefficients - truth) for fit in (one, other)]
    sd = np.sqrt(np.diag(other.coefficient_covariance).real).reshape(3, 4)
    assert np.all(errors[1] < 4 * sd) and np.allclose(
        sd, np.sqrt(np.diag(one.coefficient_covariance).real).reshape(3, 4), rtol=0.3
    )
    assert len(run_p(other, other.used)) == 24 and np.all(np.isfinite(predicted(other).chi2))


def test_a_drift_that_the_runs_cannot_show_is_refused():
    measurement, _, _ = job(np.random.default_rng(12))
    with pytest.raises(SettingError, match=r"study\.drift: expected"):
        ksmea.balance(measurement, drift="yes")
    with pytest.raises(SettingError, match=r"study\.leave_out: expected"):
        balance(measurement, np.random.default_rng(0), options=BalanceOptions(leave_out=True))
