"""Whole experiments from Python, as a script without a main guard calls them."""

import json
import subprocess
import sys

import pandas as pd
import pytest

import bench
from bench.from_python import _words
from ksmea.errors import SettingError

SMALL = {
    "optimizer": {"generations": 3, "population": 10},
    "method": {"max_updates": 2},
    "samples": (25, 30),
    "repetitions": 2,
    "workers": 2,
}


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return bench.run("table3", output=tmp_path_factory.mktemp("small"), **SMALL)


@pytest.mark.slow
def test_it_is_the_command_lines_experiment(small, apart, tmp_path):
    words = [word for key, value in SMALL.items() for word in _words(key, value)]
    by_command = apart("+experiment=table3", *words, cwd=tmp_path)
    timeless = ["parameter", "samples", "median", "q1", "q3", "low", "high"]
    ours, theirs = (frame[frame["parameter"] != "time"] for frame in (small.to_frame(), by_command.table()))
    pd.testing.assert_frame_equal(ours[timeless], theirs[timeless])
    table = str(small).split("slip in print")[0]
    without_time = [
        line.split() for line in table.splitlines() if " time " not in line
    ]  # whose digits set the columns' width
    printed = [line.split() for line in by_command.out.splitlines()]
    assert all(line in printed for line in without_time)


def test_results_are_tables_text_and_a_figure(small, tmp_path):
    assert small.failed == 0 and len(small.runs) == 4
    assert small.plot().get_axes()
    assert json.loads(small.to_json(tmp_path / "table.json"))[0]["parameter"] == "kxx"
    assert (tmp_path / "table.json").is_file()
    assert "<table" in small._repr_html_()


def test_a_run_without_an_end_is_unfinished_and_no_failed_one(tmp_path):
    statuses = ["done", "budget", "error", "timeout", "killed", "unreadable", "interrupted", "running", "not run"]
    pd.DataFrame({"key": range(len(statuses)), "status": statuses}).to_csv(tmp_path / "runs.csv", index=False)
    found = bench.from_python.Experiment(tmp_path)
    assert (found.failed, found.unfinished) == (4, 3)


@pytest.mark.parametrize(
    "experiment, settings, message",
    [
        ("tabel3", {}, "did you mean 'table3'"),
        ("table3", {"optimizer": {"generation": 3}}, "did you mean 'optimizer.generations'"),
        ("table3", {"samples": "many"}, "samples: expected a whole number"),
        ("table3", {"repetitions": (1, 2)}, "repetitions: expected one value for the whole experiment"),
    ],
)
def test_what_the_command_line_refuses_is_an_error_in_its_words(experiment, settings, message, tmp_path):
    with pytest.raises(SettingError, match=message):
        bench.run(experiment, output=tmp_path, **settings)


@pytest.mark.slow
def test_a_failed_run_is_counted_and_raises_nothing(tmp_path):
    made = bench.run("table3", output=tmp_path, timeout=0.01, repetitions=1, samples=200, workers=1)
    assert made.failed == 1 and set(made.runs["status"]) == {"timeout"}


SCRIPT = """
print("begun")
import bench
print(bench.run("table3", output="out", repetitions=2, workers=2, samples=25, study={"intervals": "none"},
                optimizer={"generations": 1, "population": 5}, method={"max_updates": 1}).failed)
"""


@pytest.mark.slow
def test_a_script_without_a_main_guard_is_not_begun_again_by_the_workers(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    (tmp_path / "bench").mkdir()  # a folder of the user's that is called like the package
    (tmp_path / "bench" / "notes.txt").write_text("not a package")
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False
    )
    assert (done.returncode, done.stdout.split()) == (0, ["begun", "0"]), done.stderr


@pytest.mark.parametrize(
    "key, value, words",
    [
        ("samples", (40, 70), ["samples=40,70"]),
        ("problem", "rk4", ["problem=rk4"]),
        ("problem", {"name": "rk4", "mesh": 21}, ["problem=rk4", "problem.mesh=21"]),
        ("optimizer", ("de", "pso"), ["optimizer=de,pso"]),
        ("measurement", {"hidden": ["runout"], "truth": {"kxx": 40.0}},
         ["measurement.hidden=['runout']", "measurement.truth={kxx:40.0}"]),
        ("measurement", {"path": "my run.csv"}, ["measurement.path='my run.csv'"]),
        ("journal", True, ["journal=true"]),
        ("timeout", None, ["timeout=null"]),
    ],
)  # fmt: skip
def test_settings_in_the_command_lines_grammar(key, value, words):
    assert _words(key, value) == words
