"""What a file leaves open is asked for at once, with a command that answers it."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import ksmea
from bench import door
from instrument_files import TABLES, written
from ksmea.errors import SettingError
from measurements.file import File
from measurements.formats.column_guess import guessed_columns

OPTIONS = {"probe": "probes", "column": "columns", "speed-unit": "speed_unit"}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def answered(command, settings):
    """The words of a shown command, its places filled from settings; a column that it suggests stays."""
    words = shlex.split(command)
    assert words[:4] == ["python", "-m", "bench", "import"]
    filled, given = words[3:5], {}
    for option, shown in zip(words[5::2], words[6::2]):
        name = option.removeprefix("--")
        given.setdefault(OPTIONS.get(name, name), []).append(shown)
    for name, shown in given.items():
        known = settings.get(name)
        values = shown if known is None else known if isinstance(known, list) else [str(known)]
        option = {setting: each for each, setting in OPTIONS.items()}.get(name, name)
        filled += [word for value in values for word in (f"--{option}", value)]
    return filled


@pytest.mark.parametrize("name", TABLES)
def test_all_questions_are_asked_at_once_and_the_command_answers_them(folder, capsys, name):
    example = TABLES[name]()
    direct = written(example).read()
    given = ["--format", example.settings["format"]]
    assert door.run(["import", example.name, *given]) == 2
    said = capsys.readouterr().err
    asked = set(re.findall(r"^  --([\w-]+): ", said, re.MULTILINE))
    if name in ("csv_long", "mat"):  # nothing in their headings says what columns hold
        assert asked == {"column", "out"} and "speed=HEADING" in said
    else:
        of_settings = {OPTIONS.get(each, each) for each in asked} - {"out", "rotation"}
        assert of_settings >= set(example.settings) - {"format"}
        words = answered(said.splitlines()[-1], {"rotation": "ccw", **example.settings})
        assert door.run(words) == 0, capsys.readouterr().err
        assert np.array_equal(ksmea.read_measurement("run.csv").values, direct.values)


def test_a_table_without_any_answer(folder, capsys):
    rows = [
        "Rig 3, May",
        *["#"] * 3,
        "RPM,Amp,Phase",
        "1000,2,30",
        "1100,3,40",
        "1200,4,55",
        "1100,3.1,41",
        "1000,2.1,29",
    ]
    Path("a.csv").write_text("\n".join(rows), encoding="utf-8")
    assert door.run(["import", "a.csv"]) == 2
    said = capsys.readouterr().err
    assert re.findall(r"^  --([\w-]+): ", said, re.MULTILINE) == [
        "format", "column", "probe", "unit", "amplitude", "speed-unit", "phase", "sweep", "out",
    ]  # fmt: skip
    answers = {
        "probes": ["@0.1@45R"], "unit": "um", "amplitude": "pp", "speed_unit": "rpm", "phase": "lead", "sweep": "up",
    }  # fmt: skip
    words = answered(said.splitlines()[-1], answers)
    assert door.run(words) == 2  # an angle from the vertical opens another question
    said = capsys.readouterr().err
    assert "1 question is open" in said and "--rotation" in said and not Path("run.csv").exists()
    assert door.run(answered(said.splitlines()[-1], {"rotation": "ccw"})) == 0
    assert np.abs(ksmea.read_measurement("run.csv").values[:, 0]) == pytest.approx([1e-6, 1.5e-6, 2e-6])


def test_words_in_capitals_are_no_answers(folder, capsys):
    """A command that is copied as it stands is refused."""
    example = TABLES["mat"]()
    written(example)
    door.run(["import", example.name, "--format", "mat", "--column", "speed=n"])
    command = shlex.split(capsys.readouterr().err.splitlines()[-1])
    assert door.run(command[3:]) == 2 and not Path("run.csv").exists()


def test_an_error_is_told_before_questions(folder, capsys):
    Path("a.csv").write_text("RPM,Amp\n1000,2\n", encoding="utf-8")
    assert door.run(["import", "a.csv", "--format", "csv", "--column", "speed=Rpm2"]) == 2
    said = capsys.readouterr().err
    assert "expected a line with the headings Rpm2" in said and said.count("\n") == 1


def test_one_question_at_a_time_of_a_measurement_is_one_line(folder):
    with pytest.raises(SettingError) as refused:
        written(TABLES["mat"](), unit=None, phase=None)
    assert "\n" not in str(refused.value)
    Path("a.csv").write_text("RPM,Amp\n1000,2\n", encoding="utf-8")
    with pytest.raises(SettingError, match="the headings suggest"):
        File(path="a.csv", format="csv")


@pytest.mark.parametrize(
    ("headings", "expected"),
    [
        (["Speed (rpm)", "1X (µm pp)", "Phase °"], ("speed=Speed (rpm)", "amplitude=1X (µm pp)", "phase=Phase °")),
        (["rpm", "X amp", "X phase", "Y amp", "Y phase"],
         ("speed=rpm", "amplitude.A=X amp", "phase.A=X phase", "amplitude.B=Y amp", "phase.B=Y phase")),
        (["rpm", "speed 2", "amp"], ()),  # two speeds
        (["rpm", "amp 1", "amp 2", "phase"], ()),  # whose phase?
    ],
)  # fmt: skip
def test_columns_are_suggested_where_headings_tell_them_apart(headings, expected):
    assert guessed_columns(headings) == expected
