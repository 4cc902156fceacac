"""Waveforms without a keyphasor, and one vector of a record at a steady speed."""

import numpy as np
import pytest

from bench import main
from ksmea.errors import SettingError
from measurements.file import File
from measurements.formats.lazy_file import Opened

RATE = 4000.0
NOISE = 1.0  # µm, of a sample


def run_up(first=15.0, last=45.0, duration=20.0, noise=NOISE, second=0.3):
    """Time, speed (rpm) and motion (µm) through a resonance at 30 Hz, with a 2X, and its 1X amplitude at a frequency in Hz."""
    time = np.arange(int(duration * RATE)) / RATE
    rate = (last - first) / duration
    frequency = first + rate * time
    angle = 2 * np.pi * (first * time + rate * time**2 / 2)

    def response(at):
        return 5 * at**2 / (30**2 - at**2 + 0.12j * 30 * at)

    vector = response(frequency)
    motion = (vector * np.exp(1j * angle) + second * vector * np.exp(2j * angle)).real
    motion += noise * np.random.default_rng(7).standard_normal(len(time))
    return time, 60 * frequency, motion, lambda at: np.abs(response(at))


def source(path, columns, *parts, **settings):
    names = ["t", "n (rpm)", "A (um)"] if len(parts) == 3 else ["t", "A (um)"]
    np.savetxt(path, np.stack(parts, axis=1), "%.9g", ",", header=",".join(names), comments="")
    given = {"format": "waveform", "columns": ["time=t", *columns], "probes": ["A@0.1@x"], **settings}
    return File.of(Opened(str(path)), given)


SIGNAL = "signal.A=A (um)"
WAYS = {
    "a column": (["speed=n (rpm)", SIGNAL], {}),
    "the vibration": ([SIGNAL], {"speed_band": [700.0, 3000.0]}),
}


@pytest.mark.parametrize("way", WAYS)
def test_amplitudes_of_a_run_up_need_no_mark(tmp_path, way):
    time, speed, motion, expected = run_up()
    columns, settings = WAYS[way]
    found = source(tmp_path / "wave.csv", columns, time, speed, motion, revolutions=2, **settings)
    data = found.read()
    assert (
        data.is_amplitude
        and any("no keyphasor: " in each for each in found.remarks)
        and found.remarks[-1].startswith("amplitudes alone: phases would add")
    )
    at = data.speed / (2 * np.pi)
    # the speed itself is read to 1 %: a tenth of the resonance's width
    middle = np.searchsorted(speed / 60, at)
    assert at == pytest.approx((speed / 60)[np.clip(middle, 0, len(speed) - 1)], rel=0.01)
    error = data.values[:, 0] * 1e6 - expected(at)
    noise = np.sqrt(2) * NOISE / np.sqrt(2 * RATE / at)  # of an amplitude: σ √(2/n), n samples in two turns
    slope = np.abs(
        expected(at * 1.003) - expected(at * 0.997)
    )  # what 0.3 % of speed make on the flank, and a window's own sweep
    assert np.median(np.abs(error) / np.hypot(noise, slope)) < 1
    assert np.max(np.abs(error) / expected(at)) < 0.15
    assert data.noise.floor[:, 0] * 1e6 == pytest.approx(np.median(noise), rel=1.5)


def test_a_constant_speed_gives_amplitudes(tmp_path):
    time = np.arange(40_000) / RATE
    motion = 12 * np.cos(2 * np.pi * 24.98 * time + 1) + NOISE * np.random.default_rng(1).standard_normal(len(time))
    found = source(
        tmp_path / "wave.csv", [SIGNAL], time, motion, constant_speed=1500.0, vectors="mean"
    )  # 1498.8 rpm in truth
    data = found.read()
    noise = np.sqrt(2 / len(time)) * NOISE
    assert data.values.shape == (1, 1) and data.speed * 30 / np.pi == pytest.approx([1500], rel=1e-3)
    assert data.values[0, 0] * 1e6 == pytest.approx(12, abs=4 * noise)
    assert data.noise.floor[0, 0] * 1e6 == pytest.approx(noise, rel=0.25)
    assert any("mean of 249 windows of 1 turns" in each or "mean of 250 windows" in each for each in found.remarks)


def test_a_steady_record_with_a_mark_is_one_vector(tmp_path):
    time = np.arange(40_000) / RATE
    turns = 23.17 * time
    vector = 12 * np.exp(0.7j)
    motion = (vector * np.exp(2j * np.pi * turns)).real + NOISE * np.random.default_rng(1).standard_normal(len(time))
    distance = np.mod(turns + 0.5, 1) - 0.5
    key = np.clip(0.5 + distance / 0.03, 0, 1) * np.clip(0.5 - (distance - 0.4) / 0.03, 0, 1)
    np.savetxt(
        tmp_path / "wave.csv", np.stack([time, key, motion], axis=1), "%.9g", ",", header="t,KPH,A (um)", comments=""
    )
    columns = ["time=t", "keyphasor=KPH", SIGNAL]
    given = {
        "format": "waveform",
        "columns": columns,
        "probes": ["A@0.1@x"],
        "keyphasor_edge": "rising",
        "vectors": "mean",
    }
    data = File.of(Opened(str(tmp_path / "wave.csv")), given).read()
    noise = 2 * NOISE / np.sqrt(len(time))
    assert data.speed == pytest.approx([2 * np.pi * 23.17], rel=1e-4)
    # an edge of five samples is read to 0.1°, 0.02 µm
    assert abs(data.values[0, 0] * 1e6 - vector) < 4 * noise + 0.02
    assert data.noise.floor[0, 0] * 1e6 == pytest.approx(noise, rel=0.3)


def test_records_at_steady_speeds_become_one_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    time = np.arange(12_000) / RATE
    columns = [word for each in ("time=t", "keyphasor=KPH", SIGNAL) for word in ("--column", each)]
    words = ["--format", "waveform", *columns, "--probe", "A@0.1@x", "--vectors", "mean"]
    expected = {}
    for number, frequency in enumerate((23.17, 11.3, 31.9)):
        turns, vector = frequency * time, frequency * np.exp(0.1j * frequency)
        motion = (vector * np.exp(2j * np.pi * turns)).real + 0.1 * np.random.default_rng(number).standard_normal(
            len(time)
        )
        key = np.where((turns + 0.2) % 1 < 0.05, 1.0, 0.0)
        np.savetxt(
            f"hold_{number}.csv", np.stack([time, key, motion], axis=1), "%.9g", ",", header="t,KPH,A (um)", comments=""
        )
        expected[frequency] = vector * np.exp(-0.4j * np.pi)
    assert main.run(["import", "hold_0.csv", "hold_1.csv", "hold_2.csv", *words]) == 2
    assert "import hold_0.csv hold_1.csv hold_2.csv --format" in capsys.readouterr().err
    assert main.run(["import", "hold_0.csv", "hold_1.csv", "hold_2.csv", *words, "--out", "run.csv"]) == 0
    assert "3 speeds from 3 files" in capsys.readouterr().out
    data = File(path="run.csv").read()
    assert data.speed / 2 / np.pi == pytest.approx(sorted(expected), rel=1e-4)
    # half a sample of 125 in the fastest turn
    np.testing.assert_allclose(data.values[:, 0] * 1e6, [expected[each] for each in sorted(expected)], rtol=0.03)
    assert (
        data.noise is not None
        and "# Imported from hold_0.csv, hold_1.csv, hold_2.csv" in (tmp_path / "run.csv").read_text()
    )
    assert main.run(["import", "hold_0.csv", "hold_0.csv", *words, "--out", "twice.csv"]) == 2
    assert "expected each speed and channel once" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("columns", "settings", "said"),
    [
        (
            [SIGNAL],
            {},
            "expected a keyphasor, or how the speed is known without one, got neither; give columns=[keyphasor=heading]",
        ),
        (
            [SIGNAL],
            {"constant_speed": 1500.0, "speed_band": [600.0, 900.0]},
            "expected one of a keyphasor and a speed, got constant_speed",
        ),
        ([SIGNAL], {"speed_band": [900.0, 600.0]}, "speed_band: expected [lowest,highest] in rpm"),
        (
            [SIGNAL],
            {"speed_band": [7000.0, 9000.0]},
            "expected a vibration that stands out between 7000 and 9000 rpm, got none",
        ),
        ([SIGNAL], {"speed_band": [600.0, 90000.0]}, "expected speeds of at least four samples a turn"),
        (["speed=n (rpm)", SIGNAL], {"harmonics": [1.0, 2.0]}, "harmonics: expected 1 alone without a keyphasor"),
        (["speed=n (rpm)", SIGNAL], {"speed_unit": "Hz"}, "expected speed_unit=rpm, which n (rpm) says, got Hz"),
        (["speed=n (rpm)", SIGNAL], {"vectors": "mean"}, "expected a steady speed with vectors=mean, got"),
        (["speed=n (rpm)"], {}, "columns: expected signal.NAME=HEADING"),
    ],
)
def test_what_no_speed_can_be_had_from_is_refused(tmp_path, columns, settings, said):
    time, speed, motion, _ = run_up(duration=4.0)
    with pytest.raises(SettingError) as error:
        source(tmp_path / "wave.csv", columns, time, speed, motion, **settings)
    assert said in str(error.value) and "\n" not in str(error.value)


def test_the_unit_of_a_speed_is_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    time, speed, motion, _ = run_up(duration=4.0)
    np.savetxt("wave.csv", np.stack([time, speed / 60, motion], axis=1), "%.9g", ",", header="t,n,A (um)", comments="")
    words = [
        "import",
        "wave.csv",
        "--format",
        "waveform",
        "--probe",
        "A@0.1@x",
        "--column",
        "time=t",
        "--column",
        "speed=n",
    ]
    words += ["--column", SIGNAL, "--out", "run.csv"]
    assert main.run(words) == 2 and "--speed-unit RPM_HZ_OR_RAD/S" in capsys.readouterr().err
    assert main.run([*words, "--speed-unit", "Hz"]) == 0
    assert "no phase" in capsys.readouterr().out
    data = File(path="run.csv").read()
    assert data.is_amplitude and data.speed[0] / 2 / np.pi == pytest.approx(15, rel=0.05)
