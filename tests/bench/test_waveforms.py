"""Vectors and their noise from waveforms with a keyphasor."""

import numpy as np
import pytest

from instrument_files import HALF_HEIGHT, sampled, waveform, written
from ksmea.errors import SettingError
from measurements.formats.order_tracking import noise_of, pulse_times, tracked

RUN_UP = "speed_rpm,position_m,direction,amplitude_um_0pk,phase_lead_deg"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_waveforms_give_the_vectors_that_are_in_them(folder):
    data = written(waveform()).read()
    _, _, _, vectors = sampled()
    expected = (vectors * np.exp(1j * np.array([1, 2]) * HALF_HEIGHT)).reshape(-1)
    assert [str(channel) for channel in data.channels] == ["x at 0.1 m", "2X x at 0.1 m", "y at 0.1 m", "2X y at 0.1 m"]
    # 2e-4: the pulse is a triangle sampled forty times in a turn's fiftieth, of which a straight line finds the half height
    assert data.values * 1e6 == pytest.approx(np.tile(expected, (len(data.speed), 1)), rel=5e-4)
    assert data.speed == pytest.approx(2 * np.pi * np.linspace(20, 24, 60)[:-1] + 2 * np.pi * 2 / 60, rel=0.02)


def test_the_noise_of_a_waveform_is_that_which_is_in_it():
    """White noise σ of samples gives a vector of n samples the total variance 4 σ²/n."""
    time, keyphasor, signals, vectors = sampled(turns=120, samples=24_000, noise=2.0, seed=5)
    found = tracked(time, signals, pulse_times(time, keyphasor), (1.0, 2.0))
    expected = 2 * 2.0 / np.sqrt(24_000 / 120)
    # 120 windows, of which 21 neighbours share a value: 5 % in the mean
    assert np.mean(found.sigma) == pytest.approx(expected, rel=0.06)
    truth = vectors * np.exp(1j * np.array([1, 2]) * HALF_HEIGHT)
    errors = np.abs(found.values - truth)
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(np.sqrt(np.mean(found.sigma**2)), rel=0.06)


def test_half_orders_need_whole_windows_and_noise_needs_neighbours():
    time, keyphasor, signals, _ = sampled(turns=10, samples=4000)
    pulses = pulse_times(time, keyphasor)
    with pytest.raises(SettingError, match="such as revolutions=2"):
        tracked(time, signals, pulses, (1.0, 0.5))
    found = tracked(time, signals, pulses, (1.0, 0.5), revolutions=2)
    assert found.values.shape == (4, 2, 2) and found.sigma is None and noise_of(found.values) is None
    assert np.max(np.abs(found.values[..., 1])) < 1e-3  # there is none in the signal
    with pytest.raises(SettingError, match="a pulse is missing"):
        tracked(time, signals, np.delete(pulses, 4), (1.0,))
    with pytest.raises(SettingError, match="expected pulses"):
        pulse_times(time, np.zeros(len(time)))
    with pytest.raises(SettingError, match="expected pulses"):
        pulse_times(time, np.random.default_rng(1).standard_normal(len(time)))


def test_a_drifting_gap_does_not_leak_into_1x():
    """A drift of 1 µm a turn would leave 1/π µm in each vector; of a line through constants nothing is left but at the ends."""
    time, keyphasor, signals, vectors = sampled()
    drift = 60 * time / time[-1]
    found = tracked(time, signals + drift[:, None], pulse_times(time, keyphasor), (1.0,))
    expected = vectors[:, 0] * np.exp(1j * HALF_HEIGHT)
    assert np.max(np.abs(found.values[1:-1, :, 0] - expected)) < 0.02 < 1 / np.pi
