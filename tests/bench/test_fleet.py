"""`measurement.path=fleet/*.csv`: a run for each file, one table and one page over all machines."""

import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import bench
import ksmea
from bench.reports.fleet.page import fleet_chart
from ksmea.errors import SettingError
from measurements.run_up_csv import as_csv

ROOT = Path(__file__).parents[2]
SENSORS = "problem.sensors=[0.1,0.5]"
CHEAP = ["optimizer.screening=200", "optimizer.starts=2", "workers=1", SENSORS]
IDENTIFY = ["+experiment=identify", *CHEAP]
EVERY = "measurement.path=fleet/*.csv"
TRUE_KXX = 50.0  # MN/m, of problem=three_disk


def run_up(seed, hidden=()):
    """A run-up of the three-disk rotor with 5 % noise, as a CSV file has it."""
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.5], n_speed=30)
    noise = {"relative": 0.05, "floor": 0.05, "noise_known": False}
    data = ksmea.synthetic_measurement(rotor, kind="complex", hidden=list(hidden), rng=seed, **noise)
    return as_csv(data.measurement)


@pytest.fixture
def fleet(tmp_path):
    """Two machines that can be identified."""
    folder = tmp_path / "fleet"
    folder.mkdir()
    for seed, name in ((1, "fan.csv"), (2, "pump.csv")):
        (folder / name).write_text(run_up(seed))
    return folder


def started(ended):
    return len(ended.events("started"))


def identify(enter, *words):
    return enter(*IDENTIFY, *words, output="results/identify_fleet")


@pytest.mark.slow
def test_each_file_has_a_row_and_a_broken_one_costs_its_own(enter, fleet):
    (fleet / "broken.csv").write_text("speed,amplitude\n1,2\n")
    few = run_up(3).splitlines()
    (fleet / "short.csv").write_text("\n".join(few[:5]) + "\n")  # 4 data, 5 unknowns and the origin of phases
    ended = identify(enter, EVERY)
    assert ended.code == 1
    table = ended.table("identify").set_index("file")
    assert list(table.index) == [f"fleet/{name}.csv" for name in ("broken", "fan", "pump", "short")]
    assert list(table["status"]) == ["error", "done", "done", "error"]
    assert "line 1: unknown column 'speed'" in table.loc["fleet/broken.csv", "error"]
    assert "expected at least" in table.loc["fleet/short.csv", "error"]
    assert "SettingError" not in ended.out + (ended.output / "index.html").read_text("utf-8")
    for name in ("fleet/fan.csv", "fleet/pump.csv"):
        row = table.loc[name]
        half_width = (row["kxx_high"] - row["kxx_low"]) / 2
        assert abs(row["kxx"] - TRUE_KXX) < 2 * half_width  # four standard deviations
        assert row["noise_pct"] == pytest.approx(5, rel=0.3)  # 120 real data: 7 % at one standard deviation
    assert ended.out.startswith("4 files: ")


def test_the_page_shows_all_machines_and_needs_no_network(enter, fleet):
    (fleet / "<b>.csv").write_text("no measurement\n")
    ended = identify(enter, EVERY)
    page = (ended.output / "index.html").read_text()
    assert all(name in page for name in ("fleet/fan.csv", "fleet/pump.csv", "fleet/&lt;b&gt;.csv", "kxx (MN/m)"))
    assert "95 % interval [" in page  # the whole text of each machine
    assert not re.search(r"(src|href)=.(?!data:|#)|<b>|@import|url\(", page)


def test_a_pattern_that_finds_nothing_refuses_and_names_what_is_there(enter, fleet):
    ended = identify(enter, "measurement.path=fleet/*.txt")
    assert ended.code == 2 and not ended.output.exists()
    assert "expected files fleet/*.txt, found none; the files in fleet are: fan.csv, pump.csv" in ended.err
    assert "found no folder fleets" in identify(enter, "measurement.path=fleets/*.csv").err


def test_a_misspelt_name_in_a_list_refuses(enter, fleet):
    ended = identify(enter, "measurement.path=fleet/fan.csv,fleet/pmp.csv")
    assert ended.code == 2 and not (ended.output.parent / "identify").exists()
    assert "expected a file fleet/pmp.csv, found none; the files in fleet are: fan.csv, pump.csv" in ended.err


def test_what_fits_no_file_is_a_wrong_setting_and_refuses(enter, fleet):
    ended = identify(enter, EVERY, "measurement.speed_from=500000")
    assert ended.code == 2 and "expected speeds from 500000" in ended.err and not ended.output.exists()


@pytest.mark.slow
def test_only_new_and_changed_files_are_computed(enter, fleet):
    words = [EVERY, "study.intervals=none"]
    assert started(identify(enter, *words)) == 2
    assert started(identify(enter, *words)) == 2
    (fleet / "turbine.csv").write_text(run_up(3))
    assert started(identify(enter, *words)) == 3
    (fleet / "fan.csv").write_text(run_up(4))
    ended = identify(enter, *words)
    assert started(ended) == 4 and len(ended.table("identify")) == 3


@pytest.mark.slow
def test_one_machine_alone_is_taken_over_from_the_fleet(enter, fleet):
    identify(enter, EVERY, "study.intervals=none")
    words = ["measurement.path=fleet/fan.csv", "share=[results/identify_fleet]", "study.intervals=none"]
    alone = enter(*IDENTIFY, *words, output="results/identify_fan")
    assert alone.code == 0 and not alone.events("started")
    assert alone.out.startswith("three_disk, fan.csv: 30 speeds")


@pytest.mark.slow
def test_each_machine_may_have_a_rotor_of_its_own(enter, fleet):
    for name in ("fan", "pump"):
        shutil.copy(ROOT / "docs/examples/rotor.yaml", fleet / f"{name}.yaml")
    words = ["problem=rotor", "problem.file=fleet/*.yaml", "study.intervals=none"]
    ended = enter(*IDENTIFY[:-1], EVERY, *words, output="results/identify_fleet")
    assert ended.code != 2, ended.err
    files = [(cell["settings"]["measurement"]["path"], cell["settings"]["problem"]["file"]) for cell in ended.cells()]
    assert files == [(f"fleet/{name}.csv", f"fleet/{name}.yaml") for name in ("fan", "pump")]
    (fleet / "pump.yaml").unlink()
    ended = enter(*IDENTIFY[:-1], EVERY, *words, output="results/identify_fleet")
    assert ended.code == 2 and "expected one rotor named as fleet/pump.csv" in ended.err


@pytest.mark.slow
def test_a_diagnosis_names_the_cause_machine_by_machine(enter, fleet):
    (fleet / "pump.csv").write_text(run_up(2, ["runout"]))
    words = ["+experiment=diagnose", "measurement=file", EVERY, SENSORS, "workers=1"]
    ended = enter(*words, "study.effects=[runout]", "study.locate=false", output="results/diagnose_fleet")
    assert ended.code == 0, ended.err
    table = ended.table("diagnose").set_index("file")
    assert list(table["verdict"]) == ["adequate", "named"]
    assert table.loc["fleet/pump.csv", "cause"] == "runout"
    assert re.search(r"runout_x .*\[.*\] µm", table.loc["fleet/pump.csv", "size"])
    values = pd.read_csv(ended.output / "values.csv")
    assert (values.groupby("file")["name"].nunique() == 6).all()  # five unknowns and the origin of phases
    assert not (ended.output / "diagnosis.json").exists()  # that of one machine


@pytest.mark.slow
def test_a_fleet_from_python(fleet, monkeypatch):
    monkeypatch.chdir(fleet.parent)
    settings = {"problem": {"sensors": [0.1, 0.5]}, "optimizer": {"screening": 200, "starts": 2}, "workers": 1}
    settings["study"] = {"intervals": "none"}
    found = bench.run("identify", measurement={"path": "fleet/*.csv"}, **settings)
    assert list(found.to_frame()["file"]) == ["fleet/fan.csv", "fleet/pump.csv"]
    with pytest.raises(SettingError, match=r"the files in fleet are: fan\.csv, pump\.csv"):
        bench.run("identify", measurement={"path": "fleet/*.txt"}, **settings)


def test_open_ends_are_arrows_and_without_intervals_there_are_none():
    values = pd.DataFrame(
        {
            "file": ["a", "b"],
            "name": "kxx",
            "unit": "MN/m",
            "value": [1.0, 2.0],
            "low": [0.5, np.nan],
            "high": [np.nan, np.nan],
        }
    )
    bars, least, most = fleet_chart(values).panels[0].elements
    assert list(bars.left) == [0.5, 0.5] and list(bars.right) == [2.0, 2.0]
    assert (list(least.y), list(least.x), list(most.y), list(most.x)) == ([1], [0.5], [0, 1], [2.0, 2.0])
    (dots,) = fleet_chart(values.assign(low=np.nan)).panels[0].elements
    assert dots.left is None and list(dots.x) == [1.0, 2.0]
