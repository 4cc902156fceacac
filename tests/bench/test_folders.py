"""A folder of results belongs to one experiment, one measurement and one problem, and tells what it no longer shows."""

import dataclasses
import re
from pathlib import Path

import pytest

from bench.commands.open import open_page
from bench.jobs.records import RecordWriter
from bench.jobs.superseded import earlier_notes
from bench.plan.folder import of_file, own_folder, require_own_folder
from bench.plan.page import Page
from bench.plan.plan import all_runs, write_plan
from bench.reports.pages.document import document
from ksmea.errors import SettingError
from measurements.run_up_csv import as_csv
from tests.bench.test_identify_file import run_up

CHEAP = ["optimizer.screening=64", "optimizer.starts=1", "workers=1"]
IDENTIFY = ["+experiment=identify", *CHEAP]


@pytest.fixture
def files(tmp_path):
    for name, seed in (("first.csv", 1), ("second run.csv", 2)):
        (tmp_path / name).write_text(as_csv(run_up(n_speed=20, seed=seed)[0]))


@pytest.mark.slow
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
    "words, new, folder",
    [
        (
            ["+experiment=identify", *CHEAP, "measurement.path='second run.csv'"],
            "identify (study=identify, problem=three_disk, second run.csv)",
            "mine_second_run",
        ),
        (
            ["+experiment=identify", *CHEAP, "measurement.path=first.csv", "name=other"],
            "other (study=identify, problem=three_disk, first.csv)",
            "mine_other",
        ),
        (
            ["+experiment=diagnose", "name=identify", "measurement=file", "measurement.path=first.csv"],
            "identify (study=diagnose, problem=three_disk, first.csv)",
            "mine_diagnose",
        ),
    ],
)
def test_another_experiment_measurement_or_problem_in_a_folder_is_refused(words, new, folder, enter, files, tmp_path):
    """With the folder to give, and what is there stays as it is to the byte."""
    first = enter(*IDENTIFY, "measurement.path=first.csv", "output=mine", output="mine")
    assert first.code == 0, first.err
    before = {path: path.read_bytes() for path in first.output.rglob("*") if path.is_file()}
    ended = enter(*words, "output=mine", output="mine")
    assert (ended.code, ended.out) == (2, "")
    assert ended.err == (
        f"error: {first.output}: expected a folder of {new}, got one with results of identify (study=identify,"
        f" problem=three_disk, first.csv), which stay as they are; give output={folder} with this command\n"
    )
    assert {path: path.read_bytes() for path in first.output.rglob("*") if path.is_file()} == before


@pytest.mark.slow
def test_the_same_experiment_goes_on_with_other_settings(enter, files, tmp_path):
    words = [*IDENTIFY, "measurement.path=first.csv", "output=mine"]
    first = enter(*words, output="mine")
    assert first.code == 0
    again = enter(*words, "repetitions=2", output="mine")
    assert again.code == 0 and "no longer shown" not in first.out + again.out
    swept = enter(*words, "optimizer.starts=2,3", output="mine")
    assert swept.code == 0 and swept.out.splitlines()[-1].startswith("note: 2 earlier results in this folder")
    (tmp_path / "moved").mkdir()
    (tmp_path / "first.csv").rename(tmp_path / "moved/again.csv")
    assert enter(*IDENTIFY, "measurement.path=moved/again.csv", "output=mine", output="mine").code == 0


@pytest.fixture
def planned(plan):
    """A plan of one run of a problem, perhaps from a file with some content, and of other settings."""

    def of(problem="rotor", file="", content="", measured="", **settings):
        chosen = {"name": problem} | ({"file": file} if file else {})
        settings |= {
            "problem": chosen,
            "measurement": {"name": "file", "path": measured},
            "study": {"name": "identify"},
        }
        settings |= {"fingerprint": content} if content else {}
        cell = dataclasses.replace(plan.cells[0], settings=settings)
        named = {"name": "identify", "command": ("+experiment=identify", f"seed={settings.get('seed', 0)}")}
        return dataclasses.replace(plan, **named, cells=(cell,), runs=all_runs((cell,), 1, plan.versions))

    return of


def test_another_problem_in_a_folder_is_refused_with_a_free_one(planned, tmp_path, monkeypatch):
    """By its name, or by its file: one that is corrected, or moved, is the same rotor; one that is both is not."""
    monkeypatch.chdir(tmp_path)
    write_plan(planned("rotor", "pump.yaml", "a", "run.csv"), tmp_path / "mine")
    require_own_folder(planned("rotor", "pump.yaml", "b", "run.csv"), tmp_path / "mine")
    require_own_folder(planned("rotor", "moved/pump.yaml", "a", "run.csv"), tmp_path / "mine")
    require_own_folder(planned("rotor", "pump.yaml", "a", "run.csv", seed=3), tmp_path / "mine")
    other = planned("rotor", "fan.yaml", "c", "run.csv")
    said = "got one with results of identify (study=identify, problem=rotor pump.yaml, run.csv), which stay as they are; give"
    with pytest.raises(SettingError, match=re.escape(f"{said} output=mine_fan with this command")):
        require_own_folder(other, tmp_path / "mine")
    (tmp_path / "mine_fan").mkdir()
    with pytest.raises(SettingError, match="give output=mine_fan_2 with this command"):
        require_own_folder(other, tmp_path / "mine")
    with pytest.raises(SettingError, match="give output=mine_my_pump with this command"):
        require_own_folder(planned("rotor", "files/my pump.yaml", "c", "run.csv"), tmp_path / "mine")
    with pytest.raises(SettingError, match="give output=mine_pump with this command"):  # moved and corrected at once
        require_own_folder(planned("rotor", "moved/pump.yaml", "b", "run.csv"), tmp_path / "mine")
    with pytest.raises(SettingError, match="give output=mine_three_disk with this command"):
        require_own_folder(planned("three_disk", measured="run.csv"), tmp_path / "mine")


def test_a_default_folder_that_is_taken_is_followed_by_one_named_after_what_is_other(planned, tmp_path):
    """A repeated command comes back to its folder; nothing is refused, and nothing written over."""
    first, second = planned("rotor", "pump.yaml", "a", "run.csv"), planned("rotor", "fan.yaml", "c", "run.csv")
    assert own_folder(first, tmp_path / "run") == tmp_path / "run"
    write_plan(first, tmp_path / "run")
    assert own_folder(first, tmp_path / "run") == tmp_path / "run"
    assert own_folder(second, tmp_path / "run") == tmp_path / "run_fan"
    write_plan(second, tmp_path / "run_fan")
    assert own_folder(second, tmp_path / "run") == tmp_path / "run_fan"
    other_name = dataclasses.replace(second, name="diagnose")
    assert own_folder(other_name, tmp_path / "run") == tmp_path / "run_fan_diagnose"


def test_open_finds_the_page_of_a_drawing(tmp_path, monkeypatch, capsys):
    """It has no plan: the page says what it is."""
    monkeypatch.chdir(tmp_path)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    folder = tmp_path / "results/draw_my_rotor"
    folder.mkdir(parents=True)
    (folder / "index.html").write_bytes(document("my rotor", Page("4 critical speeds"), (), {"study": "draw"}, {}))
    assert open_page(["draw_my_rotor"]) == 0
    assert capsys.readouterr().out.startswith("results/draw_my_rotor/index.html")


def test_results_that_are_no_longer_shown_are_told_with_the_command_that_shows_them(planned, tmp_path):
    first, other = planned(seed=1), planned(seed=2)
    assert earlier_notes(first, tmp_path) == []
    write_plan(first, tmp_path)
    assert earlier_notes(other, tmp_path) == []  # nothing was done
    with RecordWriter(tmp_path, 0, first) as writer:
        writer.result(first.runs[0], {"status": "done"})
    assert earlier_notes(first, tmp_path) == []
    [said] = earlier_notes(other, tmp_path)
    assert said == (
        "note: 1 earlier result in this folder, of other settings or files, is no longer shown: its record is kept, and its"
        " command shows it again: python -m bench +experiment=identify seed=1 (another output=DIR keeps both side by side)"
    )
    more = dataclasses.replace(first, cells=first.cells + other.cells, runs=(*first.runs, *other.runs))
    assert earlier_notes(more, tmp_path) == []  # shows what was there, and more


def test_results_of_an_earlier_content_of_a_file_are_told_without_a_command(planned, tmp_path):
    """The key hangs on what the file holds: neither this command nor that of other settings shows them."""
    first = planned("rotor", "pump.yaml", "a", seed=1)
    write_plan(first, tmp_path)
    with RecordWriter(tmp_path, 0, first) as writer:
        writer.result(first.runs[0], {"status": "done"})
    said = (
        "note: 1 earlier result in this folder, of an earlier content of pump.yaml, is no longer shown: its record is kept in"
        " records/, and shown again only with that content (another output=DIR keeps both side by side)"
    )
    assert earlier_notes(planned("rotor", "pump.yaml", "b", seed=1), tmp_path) == [said]
    assert earlier_notes(planned("rotor", "pump.yaml", "b", seed=2), tmp_path) == [said]
    [other] = earlier_notes(planned("rotor", "pump.yaml", "a", seed=2), tmp_path)
    assert "its command shows it again: python -m bench +experiment=identify seed=1" in other
    same_words = dataclasses.replace(planned("rotor", "pump.yaml", "a", seed=2), command=first.command)
    [unknown] = earlier_notes(same_words, tmp_path)
    assert (
        "of this command with earlier files or another version of the bench" in unknown and "python -m" not in unknown
    )


@pytest.mark.slow
def test_a_table_that_changed_is_named_and_not_the_rotor_file(enter, tmp_path):
    """The file of the rotor is as it was; the hash of a table follows that of the file that names it."""
    examples = Path(__file__).resolve().parents[2] / "docs" / "examples"
    for name in ("machine.yaml", "bearing.csv"):
        (tmp_path / name).write_bytes((examples / name).read_bytes())
    words = ["problem=rotor", "problem.file=machine.yaml", "method=direct", "optimizer=lm", "study.intervals=none"]
    words += ["measurement.relative=0.03", "repetitions=1", "output=mine"]
    assert enter(*words, output="mine").code == 0
    table = tmp_path / "bearing.csv"
    table.write_text(table.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    said = enter(*words, output="mine")
    assert "1 earlier result in this folder, of an earlier content of bearing.csv, is no longer shown" in said.out


@pytest.mark.slow
def test_a_changed_sweep_of_files_is_the_same_experiment(enter, files):
    words = [*IDENTIFY, "output=mine", "name=all"]
    assert enter(*words, "measurement.path=first.csv", output="mine").code == 0
    assert enter(*words, "measurement.path=first.csv,'second run.csv'", output="mine").code == 0
