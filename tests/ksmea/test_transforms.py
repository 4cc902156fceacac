"""Output transforms: what a surrogate models, and back."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.measurement.observable import Observable
from ksmea.plugins.transforms import TRANSFORMS, make_transform

N_SPEED, N_CHANNEL = 4, 3
DATA = pytest.mark.parametrize("observable", list(Observable))


def transform_of(name, observable):
    return make_transform(name, observable, n_speed=N_SPEED, n_channel=N_CHANNEL)


def response(n=6, seed=0):
    """Responses over seven decades with any phase, (n, n_speed, n_channel), m."""
    rng = np.random.default_rng(seed)
    shape = (n, N_SPEED, N_CHANNEL)
    return 10 ** rng.uniform(-9, -2, shape) * np.exp(1j * rng.uniform(-np.pi, np.pi, shape))


@DATA
@pytest.mark.parametrize("name", TRANSFORMS)
def test_outputs_turn_back_into_what_the_measurement_holds(name, observable):
    transform = transform_of(name, observable)
    y = response()
    decoded = transform.decode(transform.encode(y))
    expected = observable.seen(y)
    assert np.isrealobj(decoded) == (observable is Observable.AMPLITUDE)
    # rounding: ln and exp lose the digits of ln|y| < 21 before the point, that is 21 eps
    assert np.all(np.abs(decoded - expected) <= 1e-14 * np.abs(expected))


@pytest.mark.parametrize(
    "name, observable, parts",
    [
        ("none", Observable.AMPLITUDE, [np.abs]),
        ("none", Observable.COMPLEX, [np.real, np.imag]),
        ("complex", Observable.AMPLITUDE, [np.real, np.imag]),
        ("complex", Observable.COMPLEX, [np.real, np.imag]),
        ("log", Observable.AMPLITUDE, [lambda y: np.log(abs(y))]),
        ("auto", Observable.AMPLITUDE, [lambda y: np.log(abs(y))]),
        ("log", Observable.COMPLEX, [lambda y: np.log(abs(y)), lambda y: y.real / abs(y), lambda y: y.imag / abs(y)]),
        ("auto", Observable.COMPLEX, [lambda y: np.log(abs(y)), lambda y: y.real / abs(y), lambda y: y.imag / abs(y)]),
        (
            "log_phase",
            Observable.AMPLITUDE,
            [lambda y: np.log(abs(y)), lambda y: y.real / abs(y), lambda y: y.imag / abs(y)],
        ),
    ],
)
def test_outputs_lie_part_by_part_each_speed_by_speed(name, observable, parts):
    y = response(n=2)
    outputs = transform_of(name, observable).encode(y)
    expected = [
        [part(y[n, i, j]) for part in parts for i in range(N_SPEED) for j in range(N_CHANNEL)] for n in range(2)
    ]
    assert outputs.shape == (2, len(parts) * N_SPEED * N_CHANNEL)
    assert np.allclose(outputs, expected, rtol=1e-13, atol=0)  # two routes to cos and sin: rounding


@pytest.mark.parametrize("name", ["log", "log_phase"])
@DATA
def test_the_log_of_any_prediction_is_a_finite_amplitude_whose_square_is_finite(name, observable):
    transform = transform_of(name, observable)
    outputs = transform.encode(response(n=2))
    outputs[:, : N_SPEED * N_CHANNEL] = [[1e6], [-1e6]]
    amplitude = np.abs(transform.decode(outputs))
    assert np.all(np.isfinite(amplitude**2)) and np.all(amplitude > 0)
    assert np.all(amplitude[0] > 1e90) and np.all(amplitude[1] < 1e-90)


def test_the_phase_is_that_of_cosine_and_sine_whatever_their_length():
    transform = transform_of("log_phase", Observable.COMPLEX)
    y = response()
    outputs = transform.encode(y)
    outputs[:, N_SPEED * N_CHANNEL :] *= 0.3
    assert np.allclose(transform.decode(outputs), y, rtol=1e-13, atol=0)


def first_order(transform, outputs, outputs_sd):
    """Standard deviation of the decoded data for independent output errors, by central differences."""
    variance = 0.0
    for j, sd in enumerate(outputs_sd):
        change = np.zeros_like(outputs)
        change[:, j] = 1e-5 * np.abs(outputs[0, j])
        slope = (transform.decode(outputs + change) - transform.decode(outputs - change)) / (2 * change[0, j])
        variance = variance + np.abs(slope) ** 2 * sd**2
    return np.sqrt(variance)


@pytest.mark.parametrize(
    "name, observable",
    [
        ("none", Observable.AMPLITUDE),
        ("none", Observable.COMPLEX),
        ("log", Observable.AMPLITUDE),
        ("log_phase", Observable.AMPLITUDE),
    ],
)
def test_spread_is_first_order_propagation(name, observable):
    transform = transform_of(name, observable)
    outputs = transform.encode(response(n=1))
    outputs_sd = np.random.default_rng(3).uniform(0.01, 0.1, outputs.shape[1])
    found = transform.spread(outputs_sd, transform.decode(outputs))
    assert found.shape == (1, N_SPEED, N_CHANNEL)
    # steps of 1e-5 of an output, of 21 at most: truncation 4e-8 / 6, rounding 1e-16 / 1e-5
    assert np.allclose(found, first_order(transform, outputs, outputs_sd), rtol=1e-7, atol=0)


@pytest.mark.parametrize("name, observable", [("complex", Observable.AMPLITUDE), ("log_phase", Observable.COMPLEX)])
def test_spread_is_never_too_small_and_at_most_root_two_too_large(name, observable):
    """One of the two parts may be harmless where the phase decides which: Re or Im for an amplitude, cos or sin for
    the phase. Both are counted in full, which for equal errors is √2 of first-order propagation at most."""
    transform = transform_of(name, observable)
    outputs = transform.encode(response(n=1))
    parts = outputs.shape[1] // (N_SPEED * N_CHANNEL)
    equal_in_both = np.tile(np.random.default_rng(3).uniform(0.01, 0.1, N_SPEED * N_CHANNEL), parts)
    propagated = first_order(transform, outputs, equal_in_both)
    found = transform.spread(equal_in_both, transform.decode(outputs))
    assert np.all(found >= propagated * (1 - 1e-7)) and np.all(found <= np.sqrt(2) * propagated * (1 + 1e-7))


def test_spread_of_phase_errors_by_monte_carlo():
    """Samples of all phases, each with a phase error of 0.02 rad and an error of 0.03 in ln|y|: the rms errors of
    ln|y|, cos and sin give the rms error of the response."""
    rng = np.random.default_rng(4)
    n = 20_000
    transform = make_transform("auto", Observable.COMPLEX, n_speed=1, n_channel=1)
    y = 1e-5 * np.exp(1j * rng.uniform(-np.pi, np.pi, (n, 1, 1)))
    wrong = y * np.exp(0.03 * rng.standard_normal(y.shape) + 0.02j * rng.standard_normal(y.shape))
    outputs_sd = np.sqrt(np.mean((transform.encode(wrong) - transform.encode(y)) ** 2, axis=0))
    found = transform.spread(outputs_sd, y[:1])[0, 0, 0]
    # sampling error of a standard deviation from n draws 1/√(2n) = 0.5 %, second order of exp 0.03² = 0.1 %
    assert found == pytest.approx(np.sqrt(np.mean(np.abs(wrong - y) ** 2)), rel=0.02)
    assert found == pytest.approx(1e-5 * np.hypot(0.03, 0.02), rel=0.02)


def test_spread_takes_one_row_of_deviations_per_prediction_too():
    transform = transform_of("log", Observable.AMPLITUDE)
    predicted = np.abs(response(n=2))
    outputs_sd = np.array([[0.1], [0.2]]) * np.ones((2, N_SPEED * N_CHANNEL))
    assert np.allclose(transform.spread(outputs_sd, predicted), np.array([0.1, 0.2])[:, None, None] * predicted)


def test_an_unknown_transform_is_refused_with_the_known_ones():
    with pytest.raises(SettingError, match="unknown transform 'logphase'; did you mean 'log_phase'"):
        transform_of("logphase", Observable.COMPLEX)
