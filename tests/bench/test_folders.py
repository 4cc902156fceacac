"""A folder of results belongs to one experiment and one measurement."""

import pytest

from bench.command_line.config import of_file
from measurements.run_up_csv import as_csv
from tests.bench.test_identify_file import run_up

CHEAP = ["optimizer.screening=64", "optimizer.starts=1", "workers=1"]
IDENTIFY = ["+experiment=identify", *CHEAP]


@pytest.fixture
def files(tmp_path):
    for name, seed in (("first.csv", 1), ("second run.csv", 2)):
        (tmp_path / name).write_text(as_csv(run_up(n_speed=20, seed=seed)[0]))


def test_each_measured_file_has_a_folder_of_its_own(enter, files, tmp_path):
    first = enter(*IDENTIFY, "measurement.path=first.csv", output="results/identify_first")
    kept = (first.output / "identify.csv").read_bytes()
    second = enter(*IDENTIFY, "measurement.path='second run.csv'", output="results/identify_second_run")
    assert (first.code, second.code) == (0, 0), second.err
    assert (first.output / "identify.csv").read_bytes() == kept != (second.output / "identify.csv").read_bytes()
    assert sorted(path.name for path in (tmp_path / "results").glob("*/")) == ["identify_first", "identify_second_run"]


def test_the_name_of_a_folder_holds_what_a_folder_may_be_called():
    assert of_file({"path": "a/b/run up (2).csv"}) == "_run_up_2_"
    assert of_file({"path": "<b>U\u0308mlaut.csv"}) == "__b_\u00dcmlaut"  # letters of any script, and one form of each
    assert of_file({"path": ""}) == of_file({"relative": 0.1}) == of_file(None) == ""


@pytest.mark.parametrize(
    "words, new",
    [
        (
            ["+experiment=identify", *CHEAP, "measurement.path='second run.csv'"],
            "identify (study=identify, second run.csv)",
        ),
        (
            ["+experiment=identify", *CHEAP, "measurement.path=first.csv", "name=mine"],
            "mine (study=identify, first.csv)",
        ),
        (
            ["+experiment=diagnose", "name=identify", "measurement=file", "measurement.path=first.csv"],
            "identify (study=diagnose, first.csv)",
        ),
    ],
)
def test_another_experiment_or_measurement_in_a_folder_is_refused(words, new, enter, files, tmp_path):
    first = enter(*IDENTIFY, "measurement.path=first.csv", "output=mine", output="mine")
    assert first.code == 0, first.err
    before = {path: path.read_bytes() for path in first.output.rglob("*") if path.is_file()}
    ended = enter(*words, "output=mine", output="mine")
    assert (ended.code, ended.out) == (2, "")
    assert ended.err == (
        f"error: {first.output}: expected a folder of {new}, got one with results of identify (study=identify, first.csv);"
        " choose another output=DIR\n"
    )
    assert {path: path.read_bytes() for path in first.output.rglob("*") if path.is_file()} == before


def test_the_same_experiment_goes_on_with_other_settings(enter, files, tmp_path):
    words = [*IDENTIFY, "measurement.path=first.csv", "output=mine"]
    assert enter(*words, output="mine").code == 0
    assert enter(*words, "repetitions=2", output="mine").code == 0
    assert enter(*words, "optimizer.starts=1,2", output="mine").code == 0
    (tmp_path / "moved").mkdir()
    (tmp_path / "first.csv").rename(tmp_path / "moved/again.csv")
    assert enter(*IDENTIFY, "measurement.path=moved/again.csv", "output=mine", output="mine").code == 0


def test_a_changed_sweep_of_files_is_the_same_experiment(enter, files):
    words = [*IDENTIFY, "output=mine", "name=all"]
    assert enter(*words, "measurement.path=first.csv", output="mine").code == 0
    assert enter(*words, "measurement.path=first.csv,'second run.csv'", output="mine").code == 0
