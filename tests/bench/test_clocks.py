"""Waveforms of loggers, whose samples have times of their own."""

from datetime import datetime, timedelta

import numpy as np
import pytest
from scipy.io import savemat

from ksmea.errors import SettingError
from measurements.file import File

VECTOR = 12 * np.exp(0.7j)  # µm
NOISE = 3.0  # µm, of a sample


def logged(duration, steps=(632e-6, 648e-6), seed=3):
    """Time, keyphasor and motion of a shaft from 20 to 40 Hz, sampled at random steps of a logger's clock."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(*steps, int(duration / np.mean(steps))))
    turns = 20 * time + 10 / duration * time**2
    motion = (VECTOR * np.exp(2j * np.pi * turns)).real + NOISE * rng.standard_normal(len(time))
    distance = np.mod(turns + 0.5, 1) - 0.5  # of a mark whose rising edge lasts 0.03 turns, at half height at 0
    key = np.clip(0.5 + distance / 0.03, 0, 1) * np.clip(0.5 - (distance - 0.1) / 0.03, 0, 1) * 5
    return time, key, motion


def source(path, time, key, motion, **settings):
    texts = time if isinstance(time[0], str) else [f"{each:.6f}" for each in time]
    rows = [f"{at},{pulse:.5g},{value:.6g}" for at, pulse, value in zip(texts, key, motion)]
    path.write_text("\n".join(["t,KPH,A (um)", *rows]) + "\n")
    columns = ["time=t", "keyphasor=KPH", "signal.A=A (um)"]
    return File(path=str(path), format="waveform", columns=columns, probes=["A@0.1@x"], sweep="any", **settings)


def test_a_vibration_is_read_within_its_noise_from_an_uneven_clock(tmp_path):
    """36 s at steps of 632 to 648 µs, 40 to 80 samples in a turn: times lie up to milliseconds off even ones."""
    time, key, motion = logged(36.0)
    off = time - np.linspace(time[0], time[-1], len(time))
    assert np.max(np.abs(off)) > 0.5e-3 > 0.3 * 640e-6
    found = source(tmp_path / "log.csv", time, key, motion)
    assert any("clock: uneven steps of 632 to 648 µs (median 640)" in each for each in found.remarks)
    data = found.read()
    assert len(data.speed) > 1050  # of 1080 turns
    error = data.values[:, 0] * 1e6 - VECTOR
    samples = 2 * np.pi / data.speed / 640e-6  # of a turn, which make 4 σ²/n (total) and 2 °/n of angle by half of it
    expected = 2 * NOISE / np.sqrt(samples)
    # the angle of each turn adds the error of its pulse, an edge of four samples: 10 % in the root mean square of 1080 turns
    assert np.sqrt(np.mean((np.abs(error) / expected) ** 2)) == pytest.approx(1, abs=0.1)
    mean = np.mean(data.values[:, 0]) * 1e6
    assert abs(mean) == pytest.approx(12, abs=4 * NOISE / np.sqrt(len(time) / 2))
    # four standard errors of the noise are 0.35°; the pulse's own straight edge is read to less
    assert np.angle(mean / VECTOR, deg=True) == pytest.approx(0, abs=0.5)
    assert data.noise.floor * 1e6 == pytest.approx(expected[:, None], rel=0.6)


def test_rounded_times_of_an_even_clock_are_even(tmp_path):
    """At 5 kHz a time in ms without decimals is off by up to 2.5 samples, and stands several times."""
    time = np.arange(20_000) / 5000
    turns = 22.13 * time + 0.2 * time**2
    motion, key = (
        (VECTOR * np.exp(2j * np.pi * turns)).real,
        np.clip(np.mod(turns + 0.01, 1) / 0.02, 0, 1) * (turns % 1 < 0.1),
    )
    exact = source(tmp_path / "exact.csv", time, key, motion)
    rounded = source(tmp_path / "rounded.csv", [f"{each:.3f}" for each in time], key, motion)
    assert rounded.read().values == pytest.approx(exact.read().values, rel=1e-3)
    assert not any("clock" in each for each in (*exact.remarks, *rounded.remarks))
    savemat(tmp_path / "single.mat", {"t": (time + 100).astype(np.float32), "KPH": key, "A": motion})
    columns = ["time=t", "keyphasor=KPH", "signal.A=A"]
    settings = {"format": "waveform", "columns": columns, "probes": ["A@0.1@x"], "unit": "um"}
    single = File(path=str(tmp_path / "single.mat"), **settings)  # of which steps are off by 4 % beyond 64 s
    assert single.read().values == pytest.approx(exact.read().values, rel=1e-3)
    assert not any("clock" in each for each in single.remarks)


def test_times_may_be_clock_times(tmp_path):
    time, key, motion = logged(5.0)
    start = datetime(2026, 3, 1, 23, 59, 58)
    stamps = [start + timedelta(microseconds=round(1e6 * each)) for each in time]
    expected = source(tmp_path / "numbers.csv", time, key, motion).read().values
    for name, texts in (
        ("iso", [each.isoformat(timespec="microseconds") for each in stamps]),
        ("german", [each.strftime("%d.%m.%Y %H:%M:%S.%f") for each in stamps]),
        ("clock", [each.strftime("%H:%M:%S.%f") for each in stamps]),  # over midnight
    ):
        assert source(tmp_path / f"{name}.csv", texts, key, motion).read().values == pytest.approx(
            expected, rel=1e-6
        ), name


def test_turns_with_missing_samples_are_left_out(tmp_path):
    time, key, motion = logged(10.0)
    kept = np.ones(len(time), dtype=bool)
    kept[5000:5020] = False  # 13 ms of a turn of 40 ms
    turns = 20 * time + time**2
    assert not np.any((turns[4999:5021] % 1 > 0.9) | (turns[4999:5021] % 1 < 0.2))  # no pulse is among them
    full = source(tmp_path / "full.csv", time, key, motion).read()
    found = source(tmp_path / "gap.csv", time[kept], key[kept], motion[kept])
    assert any(
        each.startswith("1 of ") and each.endswith("windows left out: samples are missing in them")
        for each in found.remarks
    ), found.remarks
    data = found.read()
    same = np.searchsorted(full.speed, data.speed)
    assert len(data.speed) == len(full.speed) - 1
    # the two neighbours: the line through the gap voltages of 3 / √60 µm now spans two turns, of which it leaves a part in 1X
    assert data.values * 1e6 == pytest.approx(full.values[np.clip(same, 0, len(full.speed) - 1)] * 1e6, abs=0.1)


def test_times_that_do_not_rise_are_refused(tmp_path):
    time, key, motion = logged(3.0)
    time[100:200] -= 0.5
    with pytest.raises(SettingError, match=r"line 102: expected times that rise, got one that does not"):
        source(tmp_path / "back.csv", time, key, motion)
