"""Waveform exports of System 1, whose keyphasor is implicit: samples of whole turns from its mark on."""

import os
from pathlib import Path

import numpy as np
import pytest

import ksmea
from bench import main
from ksmea.errors import SettingError
from measurements.file import File
from measurements.formats.lazy_file import Opened
from measurements.formats.waveforms.steady import mean_of_windows

ROOT = Path(__file__).resolve().parents[2]
CASE = Path(os.environ.get("KSMEA_DATA", ROOT.parent / "shared" / "data")).parent / "cases" / "imports" / "s1_wave.csv"
A_TURN, TURNS = 64, 16
PROBES = ["1XD@0.1@x", "1YD@0.1@y"]


def block(name, vector, speed=1500, noise=0.0, variable=f"Disp Wf({A_TURN}X/{TURNS}revs).KPH", seed=0):
    angle = 2 * np.pi * np.arange(A_TURN * TURNS) / A_TURN
    wave = (vector * np.exp(1j * angle) + 0.2 * vector * np.exp(2j * angle)).real
    wave += noise * np.random.default_rng(seed).standard_normal(len(wave))
    lines = [
        "Machine Name,UNIT1",
        f"Point Name,{name}",
        "X-Axis Unit,ms",
        "Y-Axis Unit,mil pp",
        f"Sample Speed, {speed} rpm",
    ]
    lines += ["Sample Status,Valid", f"Timestamp,9/21/2026 8:{29 + speed // 1000:02d}:22 PM", f"Variable,{variable}"]
    lines += ["X-Axis Value,Y-Axis Value"]
    step = 60e3 / speed / A_TURN
    return lines + [f"{step * index:.3f},{value:.6f}" for index, value in enumerate(wave)]


def read(folder, *blocks, **settings):
    (folder / "wave.csv").write_text("\n".join(line for each in blocks for line in each) + "\n")
    given = {
        "format": "system1",
        "probes": PROBES[: 1 + any("1YD" in line for each in blocks for line in each)],
        **settings,
    }
    return File.of(Opened(str(folder / "wave.csv")), given)


def test_points_and_samples_become_channels_and_speeds(tmp_path):
    """Two points at two speeds, 1 rpm apart in the same sample; mil of a waveform are no peak to peak."""
    vectors = {
        ("1XD", 1500): 2 * np.exp(0.5j),
        ("1YD", 1501): 1 * np.exp(-1j),
        ("1XD", 2600): 5 + 0j,
        ("1YD", 2600): -3 + 0j,
    }
    source = read(tmp_path, *(block(name, vector, speed, 0.02) for (name, speed), vector in vectors.items()))
    data = source.read()
    assert data.speed * 30 / np.pi == pytest.approx([1500.5, 2600])
    expected = np.array(list(vectors.values())).reshape(2, 2) * 25.4
    error = np.abs(data.values * 1e6 - expected)
    noise = 2 * 0.02 * 25.4 / np.sqrt(A_TURN * TURNS)  # of a vector of so many samples, total
    assert np.all(error < 4 * noise)
    assert data.noise.floor * 1e6 == pytest.approx(np.full((2, 2), noise), rel=0.6)  # from the scatter of 16 turns
    assert any("phases count from the first sample" in each for each in source.remarks)
    with_2x = read(tmp_path, block("1XD", 2.0), block("1XD", 3.0, 2600), harmonics=[1.0, 2.0]).read()
    assert np.abs(with_2x.values[:, 1] / with_2x.values[:, 0]) == pytest.approx([0.2, 0.2], rel=1e-5)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"variable": "Disp Wf(Async)"},
            "expected a synchronous waveform such as Disp Wf(128X/16revs), got 'Disp Wf(Async)'",
        ),
        ({"variable": "Disp Wf(64X/8revs)"}, "expected 64 × 8 samples, which Variable says, got 1024"),
        ({"harmonics": [1.0, 0.3]}, "expected harmonics of whole periods in 16 turns"),
        ({"harmonics": [1.0, 40.0]}, "below 32X, got 40X"),
        ({"phase": "lag"}, "phase: expected none with waveforms, whose phases are computed here, got lag"),
    ],
)
def test_what_no_synchronous_waveform_says_is_refused(tmp_path, change, said):
    changed = {key: change.pop(key) for key in ("variable",) if key in change}
    with pytest.raises(SettingError) as error:
        read(tmp_path, block("1XD", 2.0, **changed), **change)
    assert said in str(error.value) and "\n" not in str(error.value)


def test_one_speed_is_a_run_of_a_campaign_and_no_measurement_by_itself(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    bare, gain = 2 * np.exp(0.5j), 0.3 * np.exp(-2j)  # mil, mil per g
    for name, vector in (("bare", bare), ("trial", bare + 5 * gain)):
        Path(f"{name}_wave.csv").write_text("\n".join(block("1XD", vector)))
        words = ["import", f"{name}_wave.csv", "--format", "system1", "--probe", PROBES[0], "--out", f"{name}.csv"]
        assert main.run(words) == 0
        assert f"written: {name}.csv: 1500 rpm; x at 0.1 m" in capsys.readouterr().out
    with pytest.raises(SettingError, match=r"expected at least 2 speeds.*as a run of a campaign"):
        File(path="bare.csv")
    with pytest.raises(SettingError, match=r"expected at least 2 speeds"):
        File(path="bare_wave.csv", format="system1", probes=[PROBES[0]])
    trial = "{name: trial, file: trial.csv, weights: [{position: 0.2, size: 5 g}]}"
    Path("job.yaml").write_text(f"runs: [{{name: bare, file: bare.csv}}, {trial}]")
    [(size, angle)] = ksmea.balance(ksmea.read_measurement("job.yaml")).correction.values()
    correction = -bare / gain
    assert size == pytest.approx(abs(correction), rel=1e-5)
    assert np.exp(1j * np.radians(angle)) == pytest.approx(correction / abs(correction), abs=1e-5)


def test_the_error_of_a_mean_counts_what_neighbours_share():
    """White noise and a first-order autoregressive one with ρ = 0.6: the spread of 400 means is what they say."""
    rng = np.random.default_rng(2)
    for rho in (0.0, 0.6):
        noise = rng.standard_normal((400, 200, 2)) @ [1, 1j]
        for turn in range(1, 200):
            noise[:, turn] = rho * noise[:, turn - 1] + np.sqrt(1 - rho**2) * noise[:, turn]
        means, sigma = zip(*(mean_of_windows(5 + each[:, None]) for each in noise))
        spread = np.sqrt(np.mean(np.abs(np.array(means) - 5) ** 2))
        # 400 draws know the spread to 4 %, and the estimated correlation is 2 % short of its own
        assert np.sqrt(np.mean(np.array(sigma) ** 2)) == pytest.approx(spread, rel=0.15)
    assert mean_of_windows(np.ones((5, 1), dtype=complex))[1] is None


@pytest.mark.skipif(not CASE.is_file(), reason=f"no published case {CASE}")
def test_the_published_export(tmp_path):
    """Made of 20 µm at -50° and 3 µm of 2X, three decimals in the file."""
    source = File.of(
        Opened(str(CASE)), {"format": "system1", "probes": ["1XD TURBINE DE@0.1@x"], "harmonics": [1.0, 2.0]}
    )
    values = source.read().values[0] * 1e6
    assert source.read().speed * 30 / np.pi == pytest.approx([14049])
    assert values[0] == pytest.approx(20 * np.exp(-1j * np.radians(50)), abs=1e-4)
    assert abs(values[1]) == pytest.approx(3, abs=1e-4)
