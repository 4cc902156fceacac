"""Edges of a keyphasor's mark: phases from the edge that is stated, one question if the record leaves it open."""

import numpy as np
import pytest
from scipy.io import savemat
from scipy.signal import lfilter, resample_poly

from bench import main
from ksmea.errors import SettingError
from measurements.campaign import CampaignFile
from measurements.file import File
from measurements.formats.questions import OpenQuestion
from measurements.formats.waveforms.keyphasor import mark_of

VECTOR = 20 * np.exp(-0.8j)  # µm, from where the mark begins
RATE, FINER = 9973.0, 8  # Hz, no multiple of the speed; of a clean trigger, how often it is sampled before a filter
SPEED = 25.0  # Hz, at first
BEGINS = 0.13  # turns, at which the record begins


def record(duty, turns, kind="clean", noise=0.0, is_high=True, seed=0):
    """Time, keyphasor and motion of a shaft that speeds up by a tenth; the mark is from 0 to `duty` of a turn."""
    duration = turns / (1.05 * SPEED)
    time = np.arange(int(duration * RATE * FINER)) / (RATE * FINER)
    angle = BEGINS + SPEED * time + 0.05 * SPEED / duration * time**2
    key = np.where((angle % 1 < duty) == is_high, 4.0, -3.0)
    if kind == "resampled":
        ends = [np.full(500 * FINER, level) for level in (key[0], key[-1])]
        key = resample_poly(np.concatenate([ends[0], key, ends[1]]), 1, FINER)[500:]
    else:
        key = key[::FINER]
    time, angle = time[::FINER], angle[::FINER]
    rng = np.random.default_rng(seed)
    key = key[: len(time)] + 7 * noise * rng.standard_normal(len(time))
    motion = (VECTOR * np.exp(2j * np.pi * angle)).real + 20 * noise * rng.standard_normal(len(time))
    return time, key, motion


DUTIES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.45, 0.4998, 0.5002, 0.55, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98)
WALK = [
    (duty, turns, kind, noise)
    for duty in DUTIES
    for turns, kind, noise in ((11.3, "clean", 0.0), (12.97, "resampled", 0.02), (30.5, "clean", 0.02))
]


def written(path, time, key, motion):
    if path.suffix == ".mat":
        savemat(path, {"t": time, "KPH": key, "A": motion})
    else:
        np.savetxt(path, np.stack([time, key, motion], axis=1), "%.9g", ",", header="t,KPH,A", comments="")
    columns = ["time=t", "keyphasor=KPH", "signal.A=A"]
    return {"path": str(path), "format": "waveform", "columns": columns, "probes": ["A@0.1@x"], "unit": "um"}


def phase_error(source, duty, is_leading):
    """Degrees, of the mean vector of all turns."""
    data = source.read()
    truth = VECTOR * np.exp(0 if is_leading else 2j * np.pi * duty)
    return abs(np.angle(np.mean(data.values) / truth, deg=True))


@pytest.mark.parametrize("ending", ["csv", "mat"])
@pytest.mark.parametrize(("duty", "turns", "kind", "noise"), WALK)
def test_phases_count_from_the_stated_edge_whatever_the_mark_is(tmp_path, ending, duty, turns, kind, noise):
    """At 9973 Hz a sample is 0.9° of a turn, and an edge is known to its half; the mean over turns is within 1°."""
    settings = written(tmp_path / f"wave.{ending}", *record(duty, turns, kind, noise))
    for edge in ("rising", "falling"):
        source = File(**settings, keyphasor_edge=edge)
        assert phase_error(source, duty, edge == "rising") < 1
        assert f"keyphasor edge: {edge}, upper level for" in source.remarks[0]
    if 0.25 < duty < 0.75:
        with pytest.raises(OpenQuestion, match=r"which edge of the mark.*keyphasor_edge=rising or falling"):
            File(**settings)
    else:
        assert phase_error(File(**settings), duty, duty < 0.5) < 1


def test_an_exactly_steady_record_is_read_without_a_question(tmp_path):
    """At 100 samples a turn the speeds of its turns differ by the rounding of their times alone: each turn is a row."""
    angle = np.arange(4000) / 100
    time = 0.1234 + np.arange(4000) / (100 * SPEED)
    motion = (VECTOR * np.exp(2j * np.pi * angle)).real
    data = File(**written(tmp_path / "wave.mat", time, 5.0 * (angle % 1 < 0.1), motion)).read()
    assert len(data.speed) >= 35 and data.speed * 30 / np.pi == pytest.approx(60 * SPEED, rel=1e-6)
    # an edge is known to half a sample, 1.8° of a turn
    assert np.angle(data.values[:, 0] / VECTOR, deg=True) == pytest.approx(0, abs=2)


@pytest.mark.parametrize("is_high", [True, False])
@pytest.mark.parametrize("turns", np.arange(10, 11, 0.1))
def test_where_a_record_is_cut_changes_neither_edge_nor_share(turns, is_high):
    """A mark of half a turn, in records that hold it for 47 to 53 % of their time."""
    time, key, _ = record(0.5, turns, is_high=is_high)
    with pytest.raises(OpenQuestion):
        mark_of(time, key, None)
    found = mark_of(time, key, "rising")
    assert found.share == pytest.approx(0.5, abs=0.005)  # a sample is 0.0025 turns
    passed = BEGINS + SPEED * found.time + 0.05 * SPEED * 1.05 * SPEED / turns * found.time**2 - (0 if is_high else 0.5)
    assert passed == pytest.approx(np.round(passed), abs=0.003)


@pytest.mark.parametrize("duty", [0.05, 0.5, 0.95])
def test_marks_that_a_filter_makes_lower_as_the_speed_rises_are_all_found(duty):
    """From 15 to 80 Hz behind a low-pass filter of 200 Hz: a pulse of 5 % of a turn loses half of its height."""
    rate, last = 20_000, 20.0
    time = np.arange(int(last * rate)) / rate
    angle = BEGINS + 15 * time + 65 / last * time**2 / 2
    weight = np.exp(-2 * np.pi * 200 / rate)
    clean = (angle % 1 < duty) * 1.0
    key = lfilter([1 - weight], [1, -weight], clean - clean[0])[::4]  # settled at the beginning
    key += 0.02 * np.random.default_rng(1).standard_normal(len(key))
    found = mark_of(time[::4], key, "rising")
    assert len(found.time) == int(angle[-1])
    passed = BEGINS + 15 * found.time + 65 / last * found.time**2 / 2
    lag = passed - np.round(passed)
    # of an edge alone: t = ln 2 / (2 π 200 Hz); the top of a short pulse comes nearer, and so does its half
    assert np.all(lag > -0.005) and np.all(lag[5:-5] < 1.3 * np.log(2) / (2 * np.pi * 200) * 80)
    assert found.duration > 20 and "as of a filtered signal" in found.remark


def test_pulses_up_and_down_count_at_the_higher_one():
    """A magnetic pickup: rest, a positive and a smaller negative lobe."""
    time, key, _ = record(0.04, 20)
    turn = (BEGINS + SPEED * time + 0.05 * SPEED * 1.05 * SPEED / 20 * time**2) % 1
    key = np.where(turn < 0.04, 5.0, np.where(turn < 0.08, -4.0, 0.0))
    assert mark_of(time, key, None).edge == "rising"
    assert mark_of(time, -key, None).edge == "falling"
    assert len(mark_of(time, key, None).time) == 20


def test_the_edge_is_asked_for_said_and_kept(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, turns in (("bare", 20.3), ("trial", 20.7)):
        written(tmp_path / f"{name}_wave.csv", *record(0.5, turns, "resampled", 0.01))
    command = [
        "import",
        "bare_wave.csv",
        "--format",
        "waveform",
        "--probe",
        "A@0.1@x",
        "--unit",
        "um",
        "--column",
        "time=t",
    ]
    command += ["--column", "keyphasor=KPH", "--column", "signal.A=A", "--out", "bare.csv"]
    assert main.run(command) == 2
    assert "--keyphasor-edge RISING_OR_FALLING" in (said := capsys.readouterr().err) and said.count("1 question") == 1
    assert main.run([*command, "--keyphasor-edge", "rising"]) == 0
    assert "keyphasor edge: rising, upper level for 50 % of a turn" in capsys.readouterr().out
    assert "# keyphasor edge: rising" in (tmp_path / "bare.csv").read_text()
    other = [each.replace("bare", "trial") for each in command]
    assert main.run([*other, "--keyphasor-edge", "falling"]) == 0
    runs = "runs:\n  - {name: bare, file: bare.csv}\n  - {name: trial, file: trial.csv}\n"
    (tmp_path / "campaign.yaml").write_text(runs)
    with pytest.raises(
        SettingError, match=r"rising in bare.csv and falling in trial.csv; import all runs with --keyphasor-edge"
    ):
        CampaignFile(path="campaign.yaml")
    (tmp_path / "campaign.yaml").write_text(f"own: [phase_origin]\n{runs}")
    CampaignFile(path="campaign.yaml")


def test_an_edge_is_no_answer_of_other_files():
    with pytest.raises(SettingError, match="keyphasor_edge: expected none with format=csv"):
        File(path="run.csv", format="csv", keyphasor_edge="rising")
