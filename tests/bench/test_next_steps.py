"""The next step of a study is a command with a folder of its own, wherever the results lie."""

import dataclasses
import shlex
from types import SimpleNamespace

import pytest

from bench.plan.plan import Cell
from bench.reports.design.next_measurement import from_here, next_measurement
from bench.reports.design.next_steps import after_diagnosis

NAMED = SimpleNamespace(verdict="named")  # all that is read of a diagnosis
FOLDERS = [
    ("results/diagnose", "results/identify_extended"),
    ("results/diagnose_run_up", "results/identify_run_up_extended"),
    ("results/diagnoses", "results/identify_diagnoses_extended"),
    ("mine", "identify_mine_extended"),
    ("mine_diagnose", "identify_mine_diagnose_extended"),
]


def named_output(command):
    [found] = [word for word in shlex.split(command) if word.startswith("output=")]
    return found.removeprefix("output=")


def extended_output(plan, folder):
    cell = Cell({}, {"measurement": {"name": "synthetic"}}, 0, (), "c0de")
    diagnosed = dataclasses.replace(plan, name="diagnose", command=("+experiment=diagnose",))
    [command] = after_diagnosis(diagnosed, cell, NAMED, None, from_here(folder / "extended.yaml"))
    return named_output(command.words)


@pytest.mark.parametrize("folder, expected", FOLDERS)
def test_an_extended_model_is_identified_beside_its_diagnosis(folder, expected, plan, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert extended_output(plan, tmp_path / folder) == expected


def test_results_in_the_working_directory_are_followed_by_a_folder_beside_it(plan, tmp_path, monkeypatch):
    (tmp_path / "pump").mkdir()
    monkeypatch.chdir(tmp_path / "pump")
    assert extended_output(plan, tmp_path / "pump") == str(tmp_path / "identify_pump_extended")
    cell = Cell({}, {"measurement": {"name": "file", "path": "run.csv"}}, 0, (), "c0de")
    found = next_measurement(dataclasses.replace(plan, cells=(cell,)), cell, "130@0.5@90", tmp_path / "pump")
    assert named_output(found.command) == str(tmp_path / "pump_campaign")
