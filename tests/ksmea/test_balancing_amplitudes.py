"""Balancing without phases: the four-run method beside complex influence coefficients, its error, and what it refuses."""

import dataclasses

import numpy as np
import pytest

import ksmea
from balancing_cases import UNKNOWN, campaign, corrections
from ksmea.balancing.amplitudes import fitted_amplitudes
from ksmea.balancing.correction import correction
from ksmea.balancing.readings import readings
from ksmea.errors import SettingError
from ksmea.measurement.noise import Noise

TRIALS = [10 * np.exp(2j * np.pi * turn) for turn in (0, 1 / 3, 2 / 3)]  # g mm
SPEED = [1500.0]


@pytest.fixture
def few_draws(monkeypatch):
    """A fifth of the draws of each correction: its variance is then known to 7 %, and the half-width of an interval to 3.5 %."""
    monkeypatch.setattr("ksmea.balancing.correction.N_DRAW", 200)


def amplitudes(measurement):
    return dataclasses.replace(measurement, values=np.abs(measurement.values))


def job(bare, coefficient, weights=TRIALS, noise=0.0, rng=None, speed=SPEED):
    """A campaign in one plane; with noise of the amplitudes, µm, that the file states."""
    runs = [("bare", {}, bare), *((f"t{n}", {0.2: w}, bare + coefficient * w) for n, w in enumerate(weights))]
    made = campaign([(name, on, np.reshape(values, (len(speed), -1))) for name, on, values in runs], speed)
    if rng is None:
        return made
    values = np.abs(made.values) + 1e-6 * noise * rng.standard_normal(made.values.shape)
    return dataclasses.replace(made, values=values, noise=Noise(0.0, np.full(values.shape, 1e-6 * noise)))


def test_four_amplitudes_by_hand():
    """Bare 6; 10 g mm at 0, 120, 240° make √(36 + 9 + 36 cos φ) for φ = 40°, 160°, 280°: it acts as 3 at 40°, so that
    20 g mm at 140° take 6 away. The circles of the four-run drawing give the same."""
    runs = [np.sqrt(36 + 9 + 36 * np.cos(np.radians(40 + turn))) for turn in (0, 120, 240)]
    made = campaign(
        [("bare", {}, [[6]]), *((f"t{n}", {0.2: w}, [[a]]) for n, (w, a) in enumerate(zip(TRIALS, runs)))], SPEED
    )
    found = ksmea.balance(amplitudes(made))
    np.testing.assert_allclose(corrections(found), [20 * np.exp(1j * np.radians(140))], rtol=1e-9)
    [coefficient] = found.record.planes[0].coefficients
    assert (coefficient.size, coefficient.angle) == pytest.approx((0.3, 40))
    assert found.record.is_amplitude and "Phases are not measured" in str(found)


@pytest.mark.parametrize(
    "weights",
    [TRIALS, [*TRIALS, -4j], [7.0, 12j, -5.0 - 3j], [10.0, 10j, -10.0], [3 + 1j, 3 - 1j, 6.0, -2.0, 5j]],
)
def test_amplitudes_give_what_complex_responses_give(weights):
    """The second route is that of complex influence coefficients, at two speeds and two channels, without noise."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        bare, coefficient = rng.standard_normal((2, 4, 2)) @ np.array([5, 5j])
        whole = job(bare, coefficient / 10, weights, speed=[1000.0, 1500.0])
        by_phases, found = ksmea.balance(whole), ksmea.balance(amplitudes(whole))
        np.testing.assert_allclose(corrections(found), corrections(by_phases), rtol=1e-6)
        for one, two in zip(found.record.correction.left, by_phases.record.correction.left):
            assert one.size == pytest.approx(two.size, rel=1e-6)


@pytest.mark.parametrize("effect", [0.3, 1.0, 2.0])
@pytest.mark.usefixtures("few_draws")
def test_the_error_of_the_correction_is_that_of_the_formula(effect):
    """2 (σ / y0) √(4/3 + 1/(3 T²)) is that of the linear equation, here w = -3 W y0² / Σ a² e^{-iθ}; least squares are no worse,
    and what they state is right: 200 draws, whose rms is known to 3.5 % (three standard deviations are 10.6 %)."""
    rng, y0, sigma = np.random.default_rng(2), 8.0, 0.02
    coefficient = effect * y0 / 10 * np.exp(0.7j)
    true = -y0 / coefficient
    linear, least, stated, draws = [], [], [], np.random.default_rng(0)
    for _ in range(200):
        made = job(np.array([y0]), np.array([coefficient]), noise=sigma, rng=rng)
        bare, *runs = made.values[:, 0] * 1e6
        linear.append(-300 * bare**2 / np.sum(np.square(runs) * np.conj(TRIALS)) - true)
        fit = fitted_amplitudes(readings(made, 0.01))
        found = correction(fit, draws)  # others each time: the mean of what they state is known to 0.5 %
        least.append(found.weights[0] * 1e6 - true)
        stated.append(found.variance[0] * 1e12)
    expected = 2 * sigma / y0 * np.sqrt(4 / 3 + 1 / (3 * effect**2)) * abs(true)
    rms = [np.sqrt(np.mean(np.square(np.abs(each)))) for each in (linear, least)]
    assert rms[0] == pytest.approx(expected, rel=0.1) and rms[1] < 1.02 * rms[0]
    assert np.sqrt(np.mean(stated)) == pytest.approx(rms[1], rel=0.1)


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_intervals_hold_the_truth():
    """95 % regions, 300 draws of noise that is stated: two standard deviations of the share are 2.5 %; the disc of an error
    that is not circular may hold 92 %. A size is inside its interval more often than the weight is in its disc."""
    rng, inside, p = np.random.default_rng(3), [], []
    bare, coefficient = np.array([6 + 2j, 4j]), np.array([0.3j, 0.2 + 0.1j])
    coefficient[1] = coefficient[0] * bare[1] / bare[0]  # unbalance in the plane alone
    true = -bare[0] / coefficient[0]
    for _ in range(300):
        found = ksmea.balance(job(bare, coefficient, noise=0.05, rng=rng)).record.correction
        [weight] = found.weight
        p.append(found.p)
        inside.append(weight.low <= abs(true) <= weight.high)
    assert 0.92 - 0.025 <= np.mean(inside) <= 1.0
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.025)  # all is unbalance in the plane


def test_without_a_stated_noise_it_is_that_of_the_runs_to_spare():
    rng = np.random.default_rng(4)
    weights = [10 * np.exp(2j * np.pi * n / 40) for n in range(40)]
    made = dataclasses.replace(job(np.array([6.0]), np.array([0.4j]), weights, 0.1, rng), noise=None)
    found = ksmea.balance(made).record
    assert found.method == "common" and found.dof == pytest.approx(19)  # 38 real ones
    assert found.spread[0].spread == pytest.approx(0.1, rel=0.4)  # three of its standard deviations, 0.11


@pytest.mark.parametrize(
    "weights, said",
    [
        (TRIALS[:2], "expected the bare run and three runs or more"),
        ([10.0, -10.0, 5.0], "angle of the correction open"),  # one line: the mirror image fits as well
        ([10.0, 10j, 10 + 10j], "angle of the correction open"),  # one circle with the bare run
    ],
)
def test_weights_that_leave_the_angle_open_are_refused(weights, said):
    with pytest.raises(SettingError, match=said):
        ksmea.balance(amplitudes(job(np.array([6.0]), np.array([0.4j]), weights)))


def test_two_planes_and_unknown_weights_need_phases():
    runs = [("bare", {}, [[6]]), *((f"t{n}", {0.2: w}, [[5 + n]]) for n, w in enumerate(TRIALS))]
    with pytest.raises(
        SettingError, match="expected weights in one plane where amplitudes alone are measured, got 2 planes"
    ):
        ksmea.balance(amplitudes(campaign([*runs, ("other", {0.4: 10.0}, [[5]])], SPEED)))
    with pytest.raises(SettingError, match="expected runs with known weights where amplitudes alone are measured"):
        ksmea.balance(amplitudes(campaign([*runs, ("lost", {0.2: UNKNOWN}, [[5]])], SPEED)))
