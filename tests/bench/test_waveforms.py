"""Vectors and their noise from waveforms with a keyphasor."""

import numpy as np
import pytest

from instrument_files import HALF_HEIGHT, sampled, waveform, written
from ksmea.errors import SettingError
from measurements.formats.waveforms.keyphasor import mark_of
from measurements.formats.waveforms.order_tracking import evened, noise_of, tracked


def pulse_times(time, keyphasor):
    return mark_of(time, keyphasor, None).time


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
    with pytest.raises(SettingError, match="expected a pulse in each turn"):
        pulse_times(time, np.zeros(len(time)))
    with pytest.raises(SettingError, match="expected a pulse in each turn"):
        pulse_times(time, np.random.default_rng(1).standard_normal(len(time)))


def run_up(rate, duration=20.0, first=15.0, last=80.0):
    """Time, angle and frequency (Hz) of a shaft that speeds up evenly."""
    time = np.arange(int(rate * duration)) / rate
    slope = (last - first) / duration
    return time, 2 * np.pi * (first * time + slope * time**2 / 2), lambda at: first + slope * at


def test_the_speed_is_not_that_of_pulses_that_fall_on_samples():
    """Square pulses, 62 samples in the fastest turn: by themselves they make the speed wrong by more than a hundredth."""
    time, angle, frequency = run_up(5000.0)
    pulses = pulse_times(time, (angle % (2 * np.pi) < 0.3).astype(float))
    response = 1 / (30.0**2 - frequency(time) ** 2 + 2j * 0.03 * 30.0 * frequency(time))
    found = tracked(time, (response * np.exp(1j * angle)).real[:, None], pulses, (1.0,))
    middle = found.time + np.pi / found.speed
    raw, mended = (
        np.abs(speed / (2 * np.pi * frequency(middle)) - 1) for speed in (2 * np.pi / np.diff(pulses), found.speed)
    )
    assert np.max(raw) > 0.01
    assert np.median(mended) < 5e-4 and np.max(mended) < 3e-3  # the ends of a record have pulses on one side alone
    expected = 1 / (30.0**2 - frequency(middle) ** 2 + 2j * 0.03 * 30.0 * frequency(middle))
    assert np.median(np.abs(found.values[:, 0, 0] / expected - 1)) < 0.01


def test_pulses_that_are_known_well_are_left_as_they_are():
    """An acceleration alone is no error: third differences of an even course are next to nothing."""
    number = np.arange(300.0)
    even = (-15 + np.sqrt(15**2 + 2 * 3.25 * number)) / 3.25  # s, of 15 Hz and 3.25 Hz/s
    assert evened(even) is even
    uneven = even + np.random.default_rng(0).normal(0, 1e-4, 300)
    assert np.std((evened(uneven) - even)[20:-20]) < 0.5e-4
    assert np.std((np.diff(evened(uneven)) - np.diff(even))[20:-20]) < 0.1 * np.std(np.diff(uneven) - np.diff(even))


def test_speeds_that_coincide_are_no_repeats():
    """Ten turns of 50 samples each: equal speeds in all digits, of rows at ten times."""
    time = np.arange(600) / 1000
    pulses = np.arange(1, 12) * 0.05
    found = tracked(time, np.cos(40 * np.pi * time)[:, None], pulses, (1.0,))
    assert len(set(found.speed.tolist())) == 10 and found.speed == pytest.approx(np.full(10, 40 * np.pi), rel=1e-7)


def test_a_drifting_gap_does_not_leak_into_1x():
    """A drift of 1 µm a turn would leave 1/π µm in each vector; of a line through constants nothing is left but at the ends."""
    time, keyphasor, signals, vectors = sampled()
    drift = 60 * time / time[-1]
    found = tracked(time, signals + drift[:, None], pulse_times(time, keyphasor), (1.0,))
    expected = vectors[:, 0] * np.exp(1j * HALF_HEIGHT)
    assert np.max(np.abs(found.values[1:-1, :, 0] - expected)) < 0.02 < 1 / np.pi
