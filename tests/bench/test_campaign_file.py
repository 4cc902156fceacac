"""Campaigns from files: what is read, what is refused in one line, and studies of them from the command line."""

import dataclasses
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ksmea
from campaigns import TRIAL, layout_of, measured, write
from ksmea.errors import SettingError
from ksmea.units import RPM
from measurements.campaign import CampaignFile
from measurements.run_up_csv import as_csv
from problems.three_disk import ThreeDisk

ROOT = Path(__file__).resolve().parents[2]
FINE = ThreeDisk(mesh=26).build()
SPEEDS = [np.linspace(200, 1500, 20), np.linspace(300, 1400, 12)]
LAYOUT = layout_of(FINE, SPEEDS, [("bare", ()), ("trial", (TRIAL,))])
DATA = measured(FINE, LAYOUT)
FEW_STARTS = ["optimizer.screening=500", "optimizer.starts=3"]
TWO_RUNS = """\
runs:
  - {name: bare, file: bare.csv}
  - {name: trial, file: trial.csv, weights: [{position: 1.0, g_mm: 150, angle_deg: 60}]}
"""


@pytest.fixture
def folder(tmp_path):
    write(tmp_path, DATA)
    return tmp_path


def test_a_campaign_is_read_as_it_was_written(folder):
    found = ksmea.read_measurement(folder / "campaign.yaml")
    np.testing.assert_allclose(found.speed, DATA.speed, rtol=1e-9)
    np.testing.assert_allclose(found.values, DATA.values, rtol=1e-7)  # eight digits in the file
    assert found.rows == DATA.rows and not found.phase_known and found.noise is None
    [weight] = found.campaign.runs[1].weights
    np.testing.assert_allclose(dataclasses.astuple(weight), dataclasses.astuple(TRIAL), rtol=1e-6)


def timed_runs(folder, rates):
    """The two runs with a column time_s, their speeds passed at these rates, rpm/s."""
    for name, rate, rows in zip(("bare", "trial"), rates, DATA.rows):
        speed = DATA.speed[rows]
        part = dataclasses.replace(DATA.part(np.arange(rows.start, rows.stop)), campaign=None)
        time = (speed - (speed.min() if rate > 0 else speed.max())) / (rate * RPM)
        (folder / f"{name}.csv").write_text(as_csv(part, time=time), encoding="utf-8")


def test_times_say_which_way_and_how_fast_each_run_goes(folder):
    timed_runs(folder, (63.0, -196.0))
    bare, trial = ksmea.read_measurement(folder / "campaign.yaml").campaign.runs
    assert (bare.direction, trial.direction) == ("up", "down")
    assert [run.history.rate / RPM for run in (bare, trial)] == pytest.approx([63.0, -196.0], rel=1e-6)
    (folder / "campaign.yaml").write_text(TWO_RUNS.replace("bare.csv}", "bare.csv, direction: steady}"))
    steady, _ = ksmea.read_measurement(folder / "campaign.yaml").campaign.runs
    assert steady.direction == "steady" and steady.history is None
    (folder / "campaign.yaml").write_text(TWO_RUNS.replace("bare.csv}", "bare.csv, direction: down}"))
    with pytest.raises(SettingError, match=r"direction: expected up, as time_s in .*bare.csv says, got down; correct"):
        ksmea.read_measurement(folder / "campaign.yaml")


def test_runs_may_stand_in_one_file(folder):
    lines = {}
    for name in ("bare", "trial"):
        header, *lines[name] = (folder / f"{name}.csv").read_text().splitlines()
    rows = [f"{line},{name}" for name, own in lines.items() for line in own]
    (folder / "all.csv").write_text("\n".join([f"{header},run", *rows]))
    text = TWO_RUNS.replace(", file: bare.csv", "").replace(", file: trial.csv", "")
    (folder / "one.yaml").write_text("file: all.csv\n" + text)
    one, two = (ksmea.read_measurement(folder / name) for name in ("one.yaml", "campaign.yaml"))
    np.testing.assert_array_equal(one.values, two.values)
    assert CampaignFile(path=str(folder / "one.yaml")).remarks == ()
    (folder / "all.csv").write_text("\n".join([f"{header},run", *rows, rows[-1].replace(",trial", ",trail")]))
    left_out = "left out the rows of runs that are not named here: trail"
    assert CampaignFile(path=str(folder / "one.yaml")).remarks == (left_out,)
    (folder / "all.csv").write_text("\n".join([f"{header},run", *rows]))
    with pytest.raises(
        SettingError, match=r"all.csv: expected the rows of one run, got a column run.*measurement=campaign"
    ):
        ksmea.read_measurement(folder / "all.csv")


def test_channels_are_those_of_the_first_run_in_its_order(folder):
    header, *rows = (folder / "trial.csv").read_text().splitlines()
    (folder / "trial.csv").write_text("\n".join([header, *reversed(rows)]))
    found = ksmea.read_measurement(folder / "campaign.yaml")
    assert found.channels == DATA.channels
    np.testing.assert_allclose(found.values, DATA.values, rtol=1e-7)


def test_speeds_of_a_run_can_be_chosen(folder):
    text = TWO_RUNS.replace("bare.csv}", "bare.csv, direction: down, speeds: [5000, 9000]}")
    (folder / "some.yaml").write_text(text)
    source = CampaignFile(str(folder / "some.yaml"))
    bare, _ = source.read().campaign.runs
    assert bare.direction == "down" and 0 < bare.n_speed < 20
    assert any("run bare: " in remark and "left out" in remark for remark in source.remarks)


def test_a_changed_run_is_another_measurement(folder):
    before = CampaignFile(str(folder / "campaign.yaml")).fingerprint()
    path = folder / "trial.csv"
    path.write_text(path.read_text() + "# a remark\n")
    assert CampaignFile(str(folder / "campaign.yaml")).fingerprint() != before


def test_the_example_is_what_its_remarks_say(folder):
    data = ksmea.read_measurement(ROOT / "docs/examples/campaign.yaml")
    np.testing.assert_allclose(data.values, DATA.values, rtol=1e-7)
    assert [len(run.weights) for run in data.campaign.runs] == [0, 1]


WRONG = [  # what is written instead, and what the one line says
    (("trial.csv", "trail.csv"), "runs[2].file: ", "trail.csv: expected a CSV file, found none"),
    (("name: trial", "name: bare"), "runs: expected each name once, got bare 2 times"),
    (("name: trial", "name: a b"), "runs[2].name: expected letters, digits, _ . and - alone, got 'a b'"),
    (("angle_deg: 60", "angle_deg: 400"), "runs[2].weights[1].angle_deg: expected a number at least -360 and at most 360 (deg), got 400"),
    (("angle_deg", "angle"), "runs[2].weights[1]: unknown key 'angle'; did you mean 'angle_deg'?"),
    (("g_mm: 150", "g_mm: -1"), "runs[2].weights[1].g_mm: expected a number above 0 (g mm), got -1"),
    (("weights: [{position: 1.0, g_mm: 150, angle_deg: 60}]", "weights: "), "runs[2].weights: expected a list with at least one entry, got nothing"),
    (("runs:", "own: no\nruns:"), "own: expected a list with at least one entry, got 'no'"),
    (("g_mm: 150, ", ""), "runs[2].weights[1].angle_deg: expected g_mm with it"),
    (("g_mm: 150, angle_deg: 60", "at_most_g_mm: 0"), "runs[2].weights[1].at_most_g_mm: expected a number above 0 (g mm), got 0"),
    (("weights", "weight"), "runs[2]: unknown key 'weight'; did you mean 'weights'?"),
    (("runs:", "nois: shared\nruns:"), "unknown key 'nois'; did you mean 'noise'?"),
    (("runs:", "noise: each\nruns:"), "noise: unknown noise 'each'"),
    (("bare.csv}", "bare.csv, direction: upwards}"), "runs[1].direction: unknown direction 'upwards'; did you mean 'up'?"),
    (("bare.csv}", "bare.csv, speeds: [9000, 5000]}"), "runs[1].speeds to: expected a number above 9000 (rpm), got 5000"),
    (("bare.csv}", "bare.csv, speeds: [1, 2]}"), "runs[1]: ", "expected speeds from 1 to 2 rpm"),
    (("trial.csv", "other.csv"), "runs[2].file: expected the channels of the first run (x at 0.1 m, y at 0.1 m), got x at 0.1 m"),
    (("trial.csv", "amplitudes.csv"), "runs[2].file: expected phases in all runs or in none"),
    (("weights: [{position: 1.0, g_mm: 150, angle_deg: 60}]", "weights: "), "runs[2].weights: expected a list with at least one entry, got nothing"),
    (("runs:", "own: no\nruns:"), "own: expected a list with at least one entry, got 'no'"),
]  # fmt: skip


@pytest.mark.parametrize("change, words", [(each[0], each[1:]) for each in WRONG])
def test_a_wrong_campaign_is_one_clear_line(folder, change, words):
    part = dataclasses.replace(DATA.part(np.arange(5)), campaign=None)
    other = dataclasses.replace(part, channels=part.channels[:1], values=part.values[:, :1])
    (folder / "other.csv").write_text(as_csv(other))
    (folder / "amplitudes.csv").write_text(as_csv(dataclasses.replace(part, values=np.abs(part.values))))
    assert change[0] in TWO_RUNS
    (folder / "wrong.yaml").write_text(TWO_RUNS.replace(*change))
    with pytest.raises(SettingError) as raised:
        ksmea.read_measurement(folder / "wrong.yaml")
    message = str(raised.value)
    assert "\n" not in message and "wrong.yaml" in message
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    "change, words",
    [
        (("position: 1.0", "position: 7"), "run trial, weight 150 g mm at 7 m, 60°: "),
        (("g_mm: 150", "g_mm: 1.5e8"), "expected weights up to 500000 g mm, 1000 times the largest unbalance of the model"),
        (("position: 1.0, g_mm: 150, angle_deg: 60", "position: 7"), "run trial, an unknown weight at 7 m: "),
        (("runs:", "own: [kxz]\nruns:"), "unknown in own: 'kxz'; did you mean 'kxx'?"),
    ],
)  # fmt: skip
def test_what_does_not_fit_the_machine_is_refused_with_code_2(folder, enter, change, words):
    (folder / "wrong.yaml").write_text(TWO_RUNS.replace(*change))
    ended = enter("+experiment=identify", "measurement=campaign", "measurement.path=wrong.yaml")
    assert ended.code == 2 and words in ended.err
    assert len(ended.err.strip().splitlines()) == 1
    assert not (folder / "results").exists()


def test_identify_from_the_command_line(folder, enter):
    words = ["+experiment=identify", "workers=1", "measurement=campaign", "measurement.path=campaign.yaml"]
    ended = enter(*words, *FEW_STARTS, "study.level=0.999", output="results/identify_campaign")
    assert ended.code == 0, ended.err
    assert "2 runs of one machine: bare (20 speeds), trial (12 speeds, 150 g mm at 1 m, 60°)" in ended.out
    table = ended.table("identify").set_index("parameter")
    for name, value in (("kxx", 50), ("kyy", 70), ("u", 200)):
        assert table.loc[name, "low"] < value < table.loc[name, "high"]  # 0.1 % of draws would not


@pytest.mark.slow
def test_a_weight_on_no_disk_is_remarked(folder, enter):
    (folder / "beside.yaml").write_text(TWO_RUNS.replace("position: 1.0", "position: 0.33"))
    cheap = ["workers=1", *FEW_STARTS, "study.intervals=none"]
    ended = enter("+experiment=identify", *cheap, "measurement=campaign", "measurement.path=beside.yaml")
    assert "run trial: 150 g mm at 0.33 m, 60° sits on no disk (disk 1 at 0.2 m, disk 2 at 0.5 m" in ended.out


@pytest.mark.slow
def test_an_unknown_weight_is_found_from_the_command_line(folder, enter):
    (folder / "campaign.yaml").write_text(TWO_RUNS.replace(", g_mm: 150, angle_deg: 60", ""))
    words = ["+experiment=identify", "workers=1", "measurement=campaign", "measurement.path=campaign.yaml"]
    ended = enter(*words, *FEW_STARTS, "study.level=0.999", output="results/identify_campaign")
    assert ended.code == 0, ended.err
    assert "weight in run trial at 1 m (disk 3): " in ended.out
    table = ended.table("identify").set_index("parameter")
    for name, value in (("weight at 1 m@trial, size", 150), ("weight at 1 m@trial, angle", 60)):
        assert table.loc[name, "low"] < value < table.loc[name, "high"]  # 0.1 % of draws would not
    influence = pd.read_csv(folder / "results/identify_campaign/influence.csv")
    assert set(influence["plane"]) == {"disk 1", "disk 2", "disk 3"}


@pytest.mark.parametrize(
    ("study", "little", "value", "crlb"),
    [("identifiability", "study.variations=[]", "true", "crlb_pct"), ("plan", "study.add=2", "value", "before_pct")],
)
def test_what_further_data_would_tell_starts_at_what_the_campaign_says(folder, enter, study, little, value, crlb):
    """Most likely values and noise stand in for the true ones, which nobody knows."""
    words = ["measurement=campaign", "measurement.path=campaign.yaml", little]
    ended = enter(f"+experiment={study}", "workers=1", *words, output=f"results/{study}_campaign")
    assert ended.code == 0, ended.err
    told = ended.table(study).drop_duplicates("parameter").set_index("parameter").loc["kxx"]
    assert told[value] == pytest.approx(50, rel=0.01) and 0 < told[crlb] < 1


def test_a_plan_of_a_measured_run_writes_the_campaign_that_it_names(folder, enter):
    ended = enter(
        "+experiment=plan",
        "workers=1",
        "measurement=file",
        "measurement.path=bare.csv",
        "study.add=2",
        output="results/plan_bare",
    )
    assert ended.code == 0, ended.err
    assert "measurement=campaign measurement.path=results/plan_bare/campaign.yaml" in ended.out
    with pytest.raises(SettingError, match=r"runs\[2\].file: .*further.csv: expected a CSV file, found none"):
        ksmea.read_measurement(ended.output / "campaign.yaml")


@pytest.mark.slow
def test_diagnose_from_the_command_line(folder, enter):
    words = ["+experiment=diagnose", "workers=1", "measurement=campaign", "measurement.path=campaign.yaml"]
    ended = enter(*words, "study.effects=[runout,mass]", output="results/diagnose_campaign")
    assert ended.code == 0, ended.err
    assert "2 runs of one machine" in ended.out and "Verdict: adequate" in ended.out


def test_a_weight_that_was_not_told_is_noticed(folder, enter):
    """The runs differ by 75 % of the unbalance: no single model of the machine explains both."""
    (folder / "untold.yaml").write_text(TWO_RUNS.replace(", weights: [{position: 1.0, g_mm: 150, angle_deg: 60}]", ""))
    rotor, data = ksmea.load_problem("three_disk"), ksmea.read_measurement(folder / "untold.yaml")
    assert ksmea.diagnose(rotor, data, effects=["none"], locate=False).verdict == "unknown"


def test_a_speed_may_be_measured_several_times(folder):
    header, *rows = (folder / "bare.csv").read_text().splitlines()
    (folder / "bare.csv").write_text("\n".join([header, *rows, *rows[:4]]))
    found = ksmea.read_measurement(folder / "campaign.yaml")
    assert len(found.speed) == len(DATA.speed) + 2  # two channels a speed
    np.testing.assert_allclose(found.values[[0, 2]], found.values[[1, 3]])
    (folder / "bare.csv").write_text("\n".join([header, *rows, *rows[:1]]))
    with pytest.raises(SettingError, match=r"expected every channel at every speed, got no y at 0.1 m"):
        ksmea.read_measurement(folder / "campaign.yaml")


def test_differences_are_of_speeds_that_two_runs_have(folder):
    header, *rows = (folder / "bare.csv").read_text().splitlines()
    (folder / "trial.csv").write_text("\n".join([header, *rows[6:20]]))
    source = CampaignFile(str(folder / "campaign.yaml"), reference="trial")
    found = source.read()
    assert found.is_by_differences and [run.n_speed for run in found.campaign.runs] == [7, 7]
    assert any("run bare: 13 of 20 speeds left out: no other run has them" in remark for remark in source.remarks)


@pytest.mark.parametrize(
    "reference, words",
    [
        ("bear", "unknown run of measurement.reference: 'bear'; did you mean 'bare'?"),
        ("bare", "expected speeds of run bare that another run has for differences, equal within 0.1 %, got none"),
    ],
)
def test_differences_that_cannot_be_are_refused_with_code_2(folder, enter, reference, words):
    words_given = ["+experiment=identify", "measurement=campaign", "measurement.path=campaign.yaml"]
    ended = enter(*words_given, f"measurement.reference={reference}")
    assert ended.code == 2 and words in ended.err and len(ended.err.strip().splitlines()) == 1


def test_differences_want_phases(folder):
    for name, rows in zip(("bare", "trial"), DATA.rows):
        part = dataclasses.replace(DATA.part(np.arange(rows.start, rows.stop)), campaign=None)
        (folder / f"{name}.csv").write_text(as_csv(dataclasses.replace(part, values=np.abs(part.values))))
    with pytest.raises(SettingError, match="expected phases for differences between runs, got amplitudes"):
        ksmea.read_measurement(folder / "campaign.yaml", reference="bare")


def test_headings_with_another_unit_or_sign_are_read_as_they_say(folder):
    """A lag is a negative lead; 1 mil peak to peak is 12.7 µm 0-peak, 1 µm rms is √2 µm."""
    for heading, factor in (("amplitude_mil_pp", 12.7), ("amplitude_um_rms", 2**0.5), ("amplitude_mm_pp", 500.0)):
        rows = f"speed_rpm,position_m,direction,{heading},phase_lag_deg\n1000,0.1,x,0.2,30\n1100,0.1,x,0.3,-40\n"
        (folder / "bare.csv").write_text(rows)
        (folder / "alone.yaml").write_text("runs:\n  - {name: bare, file: bare.csv}\n")
        found = ksmea.read_measurement(folder / "alone.yaml").values[:, 0]
        leads = np.exp(-1j * np.radians([30, -40]))
        np.testing.assert_allclose(found, np.array([0.2, 0.3]) * factor * 1e-6 * leads, rtol=1e-12)
    (folder / "bare.csv").write_text(
        rows.replace("phase_lag_deg", "phase_lead_deg,phase_lag_deg").replace(",30", ",30,30")
    )
    with pytest.raises(SettingError, match="expected each column once, got phase_lead_deg twice"):
        ksmea.read_measurement(folder / "alone.yaml")
