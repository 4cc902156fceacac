"""Measurements: the statistics of their noise, and what they refuse."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise

CHANNELS = (Channel(0.1, "x"), Channel(0.1, "y"))
N = 100_000  # values per channel


def response(amplitudes=(3e-6, 5e-5)):
    """Constant amplitudes by channel with all phases, (N, n_channel)."""
    phase = np.random.default_rng(8).uniform(-np.pi, np.pi, (N, len(amplitudes)))
    return np.array(amplitudes) * np.exp(1j * phase)


def sampled(values, expected_sd):
    """Mean and standard deviation over their sampling errors of zero and of what is expected: 4 is once in 16 000."""
    mean = values.mean(axis=0) / (expected_sd / np.sqrt(N))
    deviation = (values.std(axis=0) / expected_sd - 1) * np.sqrt(2 * N)
    return np.abs(mean).max(), np.abs(deviation).max()


@pytest.mark.parametrize("relative, floor", [(0.1, 0.0), (0.0, 2e-7), (0.05, 1e-6)])
def test_noise_of_amplitudes_has_the_standard_deviation_that_is_stated(relative, floor):
    clean = np.array([3e-6, 5e-5])
    values = observe(response(), "amplitude", Noise(relative, floor), np.random.default_rng(1))
    mean, deviation = sampled(values - clean, np.sqrt((relative * clean) ** 2 + floor**2))
    assert mean < 4 and deviation < 4


@pytest.mark.parametrize("relative, floor", [(0.1, 0.0), (0.0, 2e-7), (0.05, 1e-6)])
def test_noise_of_complex_responses_is_shared_equally_by_both_parts(relative, floor):
    clean = response()
    error = observe(clean, "complex", Noise(relative, floor), np.random.default_rng(1)) - clean
    total = np.sqrt((relative * np.abs(clean[0])) ** 2 + floor**2)
    for part in (error.real, error.imag):
        mean, deviation = sampled(part, total / np.sqrt(2))
        assert mean < 4 and deviation < 4
    # the relative variance of |error|², exponentially distributed, is 1; the correlation's is 1/N
    assert np.all(np.abs(np.mean(np.abs(error) ** 2, axis=0) / total**2 - 1) < 4 / np.sqrt(N))
    correlation = np.mean(error.real * error.imag, axis=0) / (total**2 / 2)
    assert np.all(np.abs(correlation) < 4 / np.sqrt(N))


def test_noise_differs_by_channel_and_speed():
    values = observe(response((1e-5, 1e-5)), "amplitude", Noise(0.1, 0.0), np.random.default_rng(1))
    assert abs(np.corrcoef(values.T)[0, 1]) < 4 / np.sqrt(N)
    assert abs(np.corrcoef(values[1:, 0], values[:-1, 0])[0, 1]) < 4 / np.sqrt(N)


def test_without_noise_the_response_itself_is_seen():
    clean = response()
    assert np.array_equal(observe(clean, "amplitude", Noise(0.0, 0.0), np.random.default_rng(1)), np.abs(clean))
    assert np.array_equal(observe(clean, "complex", Noise(0.0, 0.0), np.random.default_rng(1)), clean)
    assert Noise(0.0, 0.0).is_absent and not Noise(0.1, 0.0).is_absent and not Noise(0.0, 1e-9).is_absent


def test_no_amplitude_is_negative():
    clean = response()
    values = observe(clean, "amplitude", Noise(3.0, 0.0), np.random.default_rng(1))
    assert values.min() >= 0
    # folded back, not cut: E[(|y + s n|)²] = y² + s²; the variance of the square is 4 y² s² + 2 s⁴
    square, relative = np.mean(values**2, axis=0) / np.abs(clean[0]) ** 2, 3.0
    assert np.all(np.abs(square - 10.0) < 4 * np.sqrt((4 * relative**2 + 2 * relative**4) / N))


def test_the_generator_decides_the_noise():
    clean = response()[:10]
    first, again, other = (
        observe(clean, "complex", Noise(0.1, 0.0), np.random.default_rng(seed)) for seed in (5, 5, 6)
    )
    assert np.array_equal(first, again) and not np.any(first == other)


def test_both_kinds_draw_the_same_numbers():
    clean = np.abs(response()[:10]).astype(complex)
    rngs = np.random.default_rng(5), np.random.default_rng(5)
    noise = Noise(0.01, 0.0)
    amplitude_error = observe(clean, "amplitude", noise, rngs[0]) - clean.real
    complex_error = observe(clean, "complex", noise, rngs[1]) - clean
    assert np.allclose(amplitude_error, np.sqrt(2) * complex_error.real, rtol=1e-12)
    assert rngs[0].random() == rngs[1].random()


def test_the_kind_is_seen_from_the_values():
    speed = np.array([100.0, 200.0])
    assert Measurement(speed, CHANNELS, np.ones((2, 2)), Noise(0, 0), "test").is_amplitude
    assert not Measurement(speed, CHANNELS, np.ones((2, 2), dtype=complex), Noise(0, 0), "test").is_amplitude


@pytest.mark.parametrize("shape", [(3, 2), (2, 3), (2,), (1, 2, 2)])
def test_values_of_another_shape_are_refused(shape):
    with pytest.raises(SettingError, match=r"expected values of shape \(n_speed, n_channel\) = \(2, 2\), got \("):
        Measurement(np.array([100.0, 200.0]), CHANNELS, np.ones(shape), Noise(0, 0), "test")


@pytest.mark.parametrize("bad", [np.nan, np.inf, complex(0, np.nan)])
def test_values_that_are_no_numbers_are_refused(bad):
    values = np.ones((2, 2), dtype=type(bad))
    values[1, 0] = bad
    with pytest.raises(SettingError, match="expected finite values"):
        Measurement(np.array([100.0, 200.0]), CHANNELS, values, Noise(0, 0), "test")


def test_a_channel_looks_in_x_or_y():
    assert str(Channel(0.1, "x")) == "x at 0.1 m"
    with pytest.raises(SettingError, match="expected x, y or degrees from x towards y, got 'z'"):
        Channel(0.1, "z")
