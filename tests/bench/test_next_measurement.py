"""A recommended run as something to do: commands that a shell takes, and a campaign's file that reads back."""

import dataclasses
import shlex

import numpy as np
import pytest

import ksmea
from bench.plan.plan import Cell
from bench.reports.design.next_measurement import next_measurement
from ksmea.errors import SettingError
from measurements.run_up_csv import as_csv

RUN = "130@0.5@90"


def following(plan, folder, measurement, command, run=RUN, **changes):
    cell = Cell({"samples": None}, {"measurement": measurement}, 0, (), "c0de")
    one = dataclasses.replace(plan, cells=(cell,), axes=("samples",), command=tuple(command), **changes)
    return next_measurement(one, cell, run, folder)


def test_the_same_command_with_one_more_run(plan, tmp_path):
    words = ["+experiment=plan", "measurement.hidden=[mass]", "seed=3", "study.trial_sites=[0.2, 0.5]"]
    found = following(plan, tmp_path, {"name": "synthetic", "runs": []}, words)
    assert shlex.split(found.command) == ["python", "-m", "bench", *words, "measurement.runs=[bare,130@0.5@90]"]
    runs = ["bare", "20@1"]
    again = following(plan, tmp_path, {"name": "synthetic", "runs": runs}, [*words, "measurement.runs=[bare,20@1]"])
    assert shlex.split(again.command)[3:] == [*words, "measurement.runs=[bare,20@1,130@0.5@90]"]
    assert not found.files and following(plan, tmp_path, {"name": "synthetic"}, words, run="") is None


def test_the_further_run_of_a_campaign_with_directions_goes_as_the_first(plan, tmp_path):
    source = {"name": "synthetic", "runs": ["bare", "bare"], "directions": ["down", "up"]}
    words = ["measurement.runs=[bare,bare]", "measurement.directions=[down,up]"]
    found = following(plan, tmp_path, source, words)
    assert shlex.split(found.command)[3:] == [
        "measurement.runs=[bare,bare,130@0.5@90]",
        "measurement.directions=[down,up,down]",
    ]


def test_each_cell_of_a_sweep_has_a_command_of_its_own(plan, tmp_path):
    words = ("+experiment=plan", "study.target=kxx,cyy")
    cells = tuple(
        Cell({"samples": None, "study.target": target}, {"measurement": {"name": "synthetic"}}, 0, (), "c0de")
        for target in ("kxx", "cyy")
    )
    swept = dataclasses.replace(plan, cells=cells, axes=("samples", "study.target"), command=words)
    found = next_measurement(swept, cells[1], RUN, tmp_path)
    assert shlex.split(found.command)[3:] == [
        "+experiment=plan",
        "study.target='cyy'",
        "measurement.runs=[bare,130@0.5@90]",
    ]


@pytest.fixture
def measured(tmp_path, monkeypatch):
    """A measured run in a folder with a blank in its name, and what is recommended after it."""
    monkeypatch.chdir(tmp_path)
    rotor = ksmea.load_problem("three_disk", n_speed=20)
    runs = ksmea.synthetic_measurement(rotor, relative=0.02, kind="complex", runs=["bare", RUN], rng=1).measurement
    parts = [
        dataclasses.replace(runs.part(np.arange(each.start, each.stop)), campaign=None, noise=None)
        for each in runs.rows
    ]
    (tmp_path / "my data").mkdir()
    (tmp_path / "my data" / "run, up.csv").write_text(as_csv(parts[0]))
    return parts


@pytest.mark.slow
def test_a_measured_run_becomes_a_campaign_with_a_run_to_be_measured(plan, tmp_path, measured, enter):
    folder = tmp_path / "results" / "diagnose_up"
    folder.mkdir(parents=True)
    words = ["+experiment=diagnose", "problem.n_speed=20", "measurement=file", "measurement.path='my data/run, up.csv'"]
    source = {"name": "file", "path": "my data/run, up.csv", "speed_from": None, "speed_to": None}
    found = following(plan, folder, source, [*words, "output=mine", "seed=2"])
    assert shlex.split(found.command) == [
        *("python", "-m", "bench", "+experiment=diagnose", "problem.n_speed=20", "seed=2", "measurement=campaign"),
        *("measurement.path=results/diagnose_up/campaign.yaml", "output=results/diagnose_up_campaign"),
    ]
    (folder / "campaign.yaml").write_bytes(found.files["campaign.yaml"])
    with pytest.raises(SettingError, match=r"runs\[2\]\.file: .*further\.csv: expected a CSV file, found none"):
        ksmea.read_measurement(folder / "campaign.yaml")
    (folder / "further.csv").write_text(as_csv(measured[1]))
    data = ksmea.read_measurement(folder / "campaign.yaml")
    [weight] = data.campaign.runs[1].weights
    assert str(weight) == "130 g mm at 0.5 m, 90°" and data.campaign.runs[0].weights == ()
    np.testing.assert_allclose(data.values[:20], measured[0].values, rtol=1e-6)
    cheap = ["+experiment=identify", "optimizer.screening=200", "optimizer.starts=1", "workers=1"]
    ended = enter(
        *cheap, *shlex.split(found.command)[-2:-1], "measurement=campaign", output="results/identify_campaign"
    )
    assert ended.code == 0, ended.err


def test_chosen_speeds_of_a_file_stay_chosen(plan, tmp_path, measured):
    source = {"name": "file", "path": "my data/run, up.csv", "speed_from": 5000.0, "speed_to": None}
    found = following(plan, tmp_path, source, ["+experiment=diagnose", "measurement.speed_from=5000"])
    assert "speeds: [5000, 1e+06]" in found.files["campaign.yaml"].decode() and "speed_from" not in found.command


def test_a_campaign_gets_one_more_line(plan, tmp_path):
    words = ["+experiment=diagnose", "measurement=campaign", "measurement.path=campaign.yaml"]
    found = following(plan, tmp_path, {"name": "campaign", "path": "campaign.yaml"}, words)
    assert shlex.split(found.command)[3:] == words and not found.files
    [step] = found.steps
    assert (
        "add to campaign.yaml: - {name: further, file: further.csv, weights: [{position: 0.5, g_mm: 130, angle_deg: 90}]}"
        in step
    )
