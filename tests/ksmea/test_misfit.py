"""Misfits: by hand, against independent densities, and their derivatives on the three-disk rotor."""

import itertools

import numpy as np
import pytest
from scipy.stats import norm

from ksmea.errors import SettingError
from ksmea.likelihood.misfit import FORMS, Misfit
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from problems.three_disk import ThreeDisk

KINDS = ("amplitude", "complex")
TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
RELATIVE_ONLY, BOTH, NONE = Noise(0.1, 0.0), Noise(0.1, 1e-7), Noise(0.0, 0.0)


@pytest.fixture(scope="module")
def rotor():
    return ThreeDisk().build()


def measured(rotor, kind, noise, seed=0):
    values = observe(rotor.response(TRUTH[None])[0], kind, noise, np.random.default_rng(seed))
    return Measurement(rotor.speed, rotor.channels, values, noise, "test")


def small(values, noise):
    """A measurement of one channel written down by hand."""
    values = np.array(values)[:, None]
    return Measurement(np.arange(1.0, len(values) + 1), (Channel(0.0, "x"),), values, noise, "test")


def prediction(values):
    return np.array(values)[None, :, None]


def test_plain_is_the_squared_error_over_the_mean_square_of_the_data():
    misfit = Misfit(small([3.0, 4.0], RELATIVE_ONLY), "plain")
    assert misfit.value(prediction([4.0, 6.0])) == pytest.approx((1 + 4) / 12.5)
    misfit = Misfit(small([3.0, 4.0j], RELATIVE_ONLY), "plain")
    assert misfit.value(prediction([3.0 + 1.0j, 2.0j])) == pytest.approx(2 * (1 + 4) / 12.5)


def test_weighted_takes_the_noise_from_the_data():
    misfit = Misfit(small([3.0, 4.0], Noise(0.1, 0.2)), "weighted")
    assert misfit.value(prediction([4.0, 6.0])) == pytest.approx(1 / (0.09 + 0.04) + 4 / (0.16 + 0.04))
    misfit = Misfit(small([3.0, 4.0j], Noise(0.1, 0.2)), "weighted")
    assert misfit.value(prediction([3.0 + 1.0j, 2.0j])) == pytest.approx(2 / (0.09 + 0.04) + 2 * 4 / (0.16 + 0.04))


def test_log_takes_the_logarithm_of_the_ratio():
    misfit = Misfit(small([3.0, 4.0], RELATIVE_ONLY), "log")
    assert misfit.value(prediction([6.0, 4.4])) == pytest.approx((np.log(2) ** 2 + np.log(1.1) ** 2) / 0.01)
    misfit = Misfit(small([3.0, 4.0], Noise(0.0, 0.2)), "log")
    assert misfit.value(prediction([6.0, 4.0])) == pytest.approx(np.log(2) ** 2 * 9 / 0.04)
    misfit = Misfit(small([3.0, 4.0j], RELATIVE_ONLY), "log")
    # ratios 2 and 1/i: ln 2, and a quarter turn
    assert misfit.value(prediction([6.0 + 0j, 4.0])) == pytest.approx(2 * (np.log(2) ** 2 + (np.pi / 2) ** 2) / 0.01)


def test_likelihood_takes_the_noise_from_the_prediction():
    misfit = Misfit(small([3.0, 4.0], RELATIVE_ONLY), "likelihood")
    by_hand = (1 / 4) ** 2 / 0.01 + (2 / 6) ** 2 / 0.01 + 2 * np.log(4 / 3) + 2 * np.log(6 / 4)
    assert misfit.value(prediction([4.0, 6.0])) == pytest.approx(by_hand)


def test_the_error_of_a_surrogate_adds_to_the_noise():
    values, predicted = [3.0, 4.0], prediction([4.0, 6.0])
    model_sd = np.array([[0.3], [0.0]])
    misfit = Misfit(small(values, Noise(0.1, 0.2)), "weighted", model_sd=model_sd)
    assert misfit.value(predicted) == pytest.approx(1 / (0.09 + 0.04 + 0.09) + 4 / (0.16 + 0.04))
    misfit = Misfit(small(values, RELATIVE_ONLY), "log", model_sd=model_sd)
    assert misfit.value(predicted) == pytest.approx(np.log(4 / 3) ** 2 * 9 / (0.09 + 0.09) + np.log(1.5) ** 2 / 0.01)


def test_without_noise_equal_relative_weights_are_assumed():
    misfit = Misfit(small([3.0, 4.0], NONE), "weighted", assumed_relative=0.05)
    assert misfit.value(prediction([3.3, 4.0])) == pytest.approx((0.1 / 0.05) ** 2)


@pytest.mark.parametrize("form, kind, noise", list(itertools.product(FORMS, KINDS, (NONE, BOTH))))
def test_the_data_themselves_have_no_misfit(rotor, form, kind, noise):
    measurement = measured(rotor, kind, noise)
    misfit = Misfit(measurement, form)
    at_data = misfit.value(measurement.values[None])
    # the offset of 100 per datum is taken off again: rounding of 1e4 remains
    assert at_data == pytest.approx(0.0, abs=1e-10)
    other = misfit.value(1.05 * measurement.values[None])
    assert other > at_data


@pytest.mark.parametrize("kind", KINDS)
def test_log_is_as_bad_for_a_ratio_as_for_its_inverse(rotor, kind):
    misfit = Misfit(measured(rotor, kind, BOTH), "log")
    y = misfit.measurement.values[None]
    ratio = np.random.default_rng(1).uniform(0.01, 100.0, y.shape)
    if kind == "complex":
        ratio = ratio * np.exp(1j * np.random.default_rng(2).uniform(-3.0, 3.0, y.shape))
    assert misfit.value(y * ratio) == pytest.approx(misfit.value(y / ratio), rel=1e-12)
    assert misfit.screening(y * ratio) == pytest.approx(misfit.screening(y / ratio), rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_log_and_weighted_agree_for_small_errors(rotor, kind):
    measurement = measured(rotor, kind, BOTH)
    predicted = measurement.values[None] * (
        1 + 1e-4 * np.random.default_rng(1).standard_normal(measurement.values.shape)
    )
    log, weighted = (Misfit(measurement, form).value(predicted) for form in ("log", "weighted"))
    assert log == pytest.approx(weighted, rel=5e-4)  # ln(1 + e) = e (1 − e/2): 1e-4 and less, up to 4 times that


def test_screening_is_the_mean_of_absolute_logarithms():
    misfit = Misfit(small([3.0, 4.0], RELATIVE_ONLY), "likelihood")
    assert misfit.screening(prediction([6.0, 1.0])) == pytest.approx((np.log(2) + np.log(4)) / 2)
    misfit = Misfit(small([3.0 + 0j, 4.0], RELATIVE_ONLY), "likelihood")
    assert misfit.screening(prediction([3.0j, 8.0])) == pytest.approx((np.pi / 2 + np.log(2)) / 2)


@pytest.mark.parametrize("model_sd", [False, True])
@pytest.mark.parametrize("noise", [RELATIVE_ONLY, BOTH, Noise(0.0, 1e-6)])
@pytest.mark.parametrize("kind", KINDS)
def test_likelihood_is_that_of_independent_normal_densities(rotor, kind, noise, model_sd):
    """−2 ln L up to a constant: differences between predictions. Complex data are two real ones of half the variance."""
    measurement = measured(rotor, kind, noise)
    y = measurement.values
    surrogate = 0.05 * np.abs(y) if model_sd else np.zeros(y.shape)
    misfit = Misfit(measurement, "likelihood", model_sd=surrogate if model_sd else None)
    predicted = misfit.observed(rotor.response(TRUTH * np.array([[1.0] * 5, [1.003, 0.997, 1.2, 0.8, 1.05]])))

    def minus_twice_log_likelihood(p):
        variance = (noise.relative * np.abs(p)) ** 2 + noise.floor**2 + surrogate**2
        if kind == "amplitude":
            return -2 * np.sum(norm.logpdf(y, p, np.sqrt(variance)))
        sd = np.sqrt(variance / 2)
        return -2 * np.sum(norm.logpdf(y.real, p.real, sd) + norm.logpdf(y.imag, p.imag, sd))

    value = misfit.value(predicted)
    expected = minus_twice_log_likelihood(predicted[1]) - minus_twice_log_likelihood(predicted[0])
    assert abs(expected) > 1  # two predictions that the data tell apart
    assert value[1] - value[0] == pytest.approx(expected, rel=1e-9)  # rounding of sums of a few thousand


@pytest.mark.parametrize("kind, per_datum", [("amplitude", 1), ("complex", 2)])
def test_at_the_truth_the_likelihood_misfit_is_the_number_of_data(rotor, kind, per_datum):
    """χ² of one number per amplitude, two per complex value. The logarithm of s(p)² is taken relative to that of the
    noisy data, which adds −E[ln (1 + 0.1 n)²] = 0.0102 per amplitude, and nothing for complex data, where ln|1 + w| is
    harmonic."""
    draws = 200
    truth = rotor.response(TRUTH[None])
    values = []
    for seed in range(draws):
        misfit = Misfit(measured(rotor, kind, RELATIVE_ONLY, seed), "likelihood")
        values.append(misfit.value(misfit.observed(truth))[0])
    n = truth.size
    expected = n * (1.0102 if kind == "amplitude" else per_datum)
    spread = np.std(values, ddof=1)
    assert np.mean(values) == pytest.approx(expected, abs=4 * spread / np.sqrt(draws))  # once in 16 000
    # the χ² part alone varies by √(2 · number); the logarithms correlate little with it
    assert spread == pytest.approx(np.sqrt(2 * n * per_datum), rel=0.3)


def differences(function, u, step):
    """Derivatives (m, d) by central differences of sixth order, all points in one batch: u (d,), function (k, d) → (k, m)."""
    weights = np.array([-1, 9, -45, 45, -9, 1]) / 60
    offsets = np.array([-3, -2, -1, 1, 2, 3]) * step
    points = u + offsets[None, :, None] * np.eye(len(u))[:, None, :]  # (d, 6, d)
    values = function(points.reshape(-1, len(u))).reshape(len(u), 6, -1)
    return np.einsum("o,dom->md", weights, values) / step


@pytest.mark.parametrize("model_sd", [False, True], ids=["", "model_sd"])
@pytest.mark.parametrize("noise", [NONE, RELATIVE_ONLY, BOTH], ids=["none", "relative", "both"])
@pytest.mark.parametrize("form, kind", list(itertools.product(FORMS, KINDS)))
def test_derivatives_are_those_of_the_residuals(rotor, form, kind, noise, model_sd):
    measurement = measured(rotor, kind, noise)
    surrogate = 10 ** np.random.default_rng(7).uniform(-9, -6, measurement.values.shape) if model_sd else None
    misfit = Misfit(measurement, form, model_sd=surrogate)
    parameters = rotor.parameters

    def residuals(u):
        return misfit.residuals(misfit.observed(rotor.response(parameters.to_si(u))))

    for u in np.random.default_rng(11).uniform(0.05, 0.95, (3, 5)):
        x = parameters.to_si(u)
        found = misfit.jacobian(rotor.response(x[None])[0], rotor.sensitivity(x) * parameters.width)
        expected = differences(residuals, u, step=1e-4)
        assert found.shape == expected.shape
        # the sharpest peaks are 1e-3 of the cube wide: truncation (1e-4 / 1e-3)⁶ · 36 and less away from them
        deviation = np.linalg.norm(found - expected, axis=0) / np.linalg.norm(expected, axis=0)
        assert deviation.max() < 1e-5


@pytest.mark.parametrize("form, kind, noise", list(itertools.product(FORMS, KINDS, (NONE, RELATIVE_ONLY, BOTH))))
def test_a_zero_in_the_data_leaves_everything_finite(rotor, form, kind, noise):
    clean = measured(rotor, kind, noise)
    values = clean.values.copy()
    values[5, 0] = 0.0
    misfit = Misfit(Measurement(rotor.speed, rotor.channels, values, noise, "test"), form)
    response = rotor.response(TRUTH[None] * np.array([[1.0], [1.01]]))
    predicted = misfit.observed(response)
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        value, screening = misfit.value(predicted), misfit.screening(predicted)
        jacobian = misfit.jacobian(response[0], rotor.sensitivity(TRUTH))
        far_off = misfit.value(np.full_like(predicted, 1e100))  # the largest that a logarithmic surrogate predicts
    assert np.all(np.isfinite(value)) and np.all(np.isfinite(screening))
    assert np.all(np.isfinite(jacobian))
    assert np.all(np.isfinite(far_off)) and np.all(far_off > value)


def test_relative_noise_gives_a_zero_no_weight():
    """Without a floor nothing is known of its noise; with one it counts like any other value."""
    values, predicted = [3.0, 0.0], prediction([4.0, 0.5])
    assert Misfit(small(values, RELATIVE_ONLY), "weighted").value(predicted) == pytest.approx(1 / 0.09)
    assert Misfit(small(values, RELATIVE_ONLY), "log").value(predicted) == pytest.approx(np.log(4 / 3) ** 2 / 0.01)
    floor = Misfit(small(values, Noise(0.1, 0.2)), "weighted").value(predicted)
    assert floor == pytest.approx(1 / 0.13 + 0.25 / 0.04)


def test_a_zero_leaves_the_differences_of_the_likelihood():
    misfit = Misfit(small([3.0, 0.0], RELATIVE_ONLY), "likelihood")
    first, second = (misfit.value(prediction([4.0, p]))[0] for p in (0.5, 0.6))
    assert second - first == pytest.approx(2 * np.log(0.6 / 0.5))  # both deviations are −1 / 0.1


@pytest.mark.parametrize("form, kind", list(itertools.product(FORMS, KINDS)))
def test_every_prediction_of_a_batch_is_judged_alone(rotor, form, kind):
    misfit = Misfit(measured(rotor, kind, BOTH), form)
    predicted = misfit.observed(rotor.response(TRUTH * np.linspace(0.9, 1.1, 4)[:, None]))
    alone = np.array([misfit.value(one[None])[0] for one in predicted])
    assert np.allclose(misfit.value(predicted), alone, rtol=1e-12, atol=1e-10)  # sums in another order


def test_an_unknown_form_is_refused_with_the_known_ones():
    with pytest.raises(SettingError, match="unknown misfit 'likelyhood'; did you mean 'likelihood'"):
        Misfit(small([1.0], NONE), "likelyhood")
