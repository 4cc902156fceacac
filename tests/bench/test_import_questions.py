"""Open questions of a file are asked at once, with a command that answers them."""

import re
import shlex
from pathlib import Path

import numpy as np
import openpyxl
import pytest

import ksmea
from bench import main
from instrument_files import TABLES, sampled, written
from ksmea.errors import SettingError
from measurements.file import File
from measurements.formats.column_guess import guessed_columns, guessed_waveforms
from measurements.formats.questions import OpenQuestion, open_questions
from measurements.formats.readers import foreign_rows
from measurements.formats.sheet import read_delimited
from measurements.run_up_rows import read_bytes

OPTIONS = {"probe": "probes", "column": "columns", "speed-unit": "speed_unit"}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def answered(command, settings):
    """The words of a shown command, its places filled from settings; a column that it suggests stays."""
    words = shlex.split(command)
    assert words[:4] == ["python", "-m", "bench", "import"]
    given = {}
    for option, shown in zip(words[5::2], words[6::2]):
        name = option.removeprefix("--")
        given.setdefault(OPTIONS.get(name, name), []).append(shown)
    return [*words[3:5], *as_options({name: settings.get(name, shown) for name, shown in given.items()})]


def as_options(settings):
    option = {setting: each for each, setting in OPTIONS.items()}
    for name, value in settings.items():
        for each in value if isinstance(value, list) else [value]:
            yield from (f"--{option.get(name, name)}", str(each))


@pytest.mark.parametrize("name", TABLES)
def test_all_questions_are_asked_at_once_and_the_command_answers_them(folder, capsys, name):
    example = TABLES[name]()
    direct = written(example).read()
    given = ["--format", example.settings["format"]]
    assert main.run(["import", example.name, *given]) == 2
    said = capsys.readouterr().err
    asked = set(re.findall(r"^  --([\w-]+): ", said, re.MULTILINE))
    if name in ("csv_long", "mat"):  # nothing in their headings says what columns hold
        assert asked == {"column", "out"} and "speed=HEADING" in said
    else:
        of_settings = {OPTIONS.get(each, each) for each in asked} - {"out", "rotation"}
        assert of_settings >= set(example.settings) - {"format"}
        words = answered(said.splitlines()[-1], {"rotation": "ccw", **example.settings})
        assert main.run(words) == 0, capsys.readouterr().err
        assert np.array_equal(ksmea.read_measurement("run.csv").values, direct.values)


def test_a_table_without_any_answer(folder, capsys):
    rows = [
        "Rig 3, May",
        *["#"] * 3,
        "Speed,Amp,Phase",
        "1000,2,30",
        "1100,3,40",
        "1200,4,55",
        "1100,3.1,41",
        "1000,2.1,29",
    ]
    Path("a.csv").write_text("\n".join(rows), encoding="utf-8")
    assert main.run(["import", "a.csv"]) == 2
    said = capsys.readouterr().err
    assert re.findall(r"^  --([\w-]+): ", said, re.MULTILINE) == [
        "format", "column", "probe", "unit", "amplitude", "speed-unit", "phase", "sweep", "out",
    ]  # fmt: skip
    answers = {
        "probes": ["@0.1@45R"], "unit": "um", "amplitude": "pp", "speed_unit": "rpm", "phase": "lead", "sweep": "up",
    }  # fmt: skip
    words = answered(said.splitlines()[-1], answers)
    assert main.run(words) == 2  # an angle from the vertical opens another question
    said = capsys.readouterr().err
    assert "1 question is open" in said and "--rotation" in said and not Path("run.csv").exists()
    assert main.run(answered(said.splitlines()[-1], {"rotation": "ccw"})) == 0
    assert np.abs(ksmea.read_measurement("run.csv").values[:, 0]) == pytest.approx([1e-6, 1.5e-6, 2e-6])


def test_words_in_capitals_are_no_answers(folder, capsys):
    """A command that is copied as it stands is refused."""
    example = TABLES["mat"]()
    written(example)
    main.run(["import", example.name, "--format", "mat", "--column", "speed=n"])
    command = shlex.split(capsys.readouterr().err.splitlines()[-1])
    assert main.run(command[3:]) == 2 and not Path("run.csv").exists()


def test_an_error_is_told_before_questions(folder, capsys):
    Path("a.csv").write_text("RPM,Amp\n1000,2\n", encoding="utf-8")
    assert main.run(["import", "a.csv", "--format", "csv", "--column", "speed=Rpm2"]) == 2
    said = capsys.readouterr().err
    assert "expected a line with the headings Rpm2" in said and said.count("\n") == 1


def questions(capsys, *words):
    assert main.run(["import", *words]) == 2
    return capsys.readouterr().err


def test_a_file_that_is_not_there_is_told_at_once(folder, capsys):
    said = questions(capsys, "nosuch.csv")
    assert said.startswith("error: import: nosuch.csv: expected a CSV file, found none") and said.count("\n") == 1


def test_a_file_that_cannot_be_read_by_its_ending_says_why(folder, capsys):
    Path("bad.mat").write_bytes(b"MATLAB 5.0 junk" * 20)
    said = questions(capsys, "bad.mat")
    assert "its name suggests mat, and that fails: expected a .mat file that can be read" in said
    assert "--format FORMAT" in said and "All in one" not in said


@pytest.mark.parametrize("name", ["adre", "system1"])
def test_exports_are_recognised_by_their_headings_and_that_is_said(folder, capsys, name):
    example = TABLES[name]()
    written(example)
    said = questions(capsys, example.name)
    assert f"its headings suggest {name}, check it" in said and f"--format {name}" in said
    assert "All in one command" in said


def test_a_file_of_the_project_is_recognised(folder, capsys):
    content = b"# remark\nspeed_rpm,position_m,direction,amplitude_um_0pk\n1000,0,x,1\n1100,0,x,2\n"
    Path("own.csv").write_bytes(content)
    assert "its headings suggest run_up" in questions(capsys, "own.csv")


def test_more_may_be_open_where_reading_stops_after_a_preliminary_answer(folder, capsys):
    """A probe that the suggested columns do not name."""
    Path("a.csv").write_text("RPM,Amp A,Amp B\n1000,2,3\n1100,3,4\n", encoding="utf-8")
    said = questions(capsys, "a.csv", "--format", "csv", "--probe", "X@0.1@x")
    assert "More may be open once these are answered" in said and "All in one" not in said


def test_to_average_is_the_decision_of_the_user(folder, capsys):
    rows = ["speed_rpm,position_m,direction,amplitude_um_0pk", *(f"{speed},0,x,1" for speed in (1000, 1100, 1100))]
    Path("own.csv").write_text("\n".join(rows), encoding="utf-8")
    said = questions(capsys, "own.csv", "--format", "run_up")
    assert "--repeats AVERAGE" in said and "--repeats average" in said and "repeats=" not in said
    assert main.run(shlex.split(said.splitlines()[-1])[3:]) == 2 and not Path("run.csv").exists()


def test_an_option_is_listed_once(folder, capsys):
    known = questions(capsys, "a.csv", "--colum", "x").partition("known: ")[2].partition(";")[0].split(", ")
    assert len(known) == len(set(known)) and {"--column", "--probe", "--out"} <= set(known)


def book(path, *sheets):
    """An Excel file: names of sheets with their rows."""
    made = openpyxl.Workbook()
    made.remove(made.active)
    for name, rows in sheets:
        sheet = made.create_sheet(name)
        for row in rows:
            sheet.append(row)
    made.save(path)


RUN_UP_ROWS = [["Speed (rpm)", "Amp (um pp)", "Phase (deg)"], *([1000 + 100 * at, 2 + at, 30 + at] for at in range(4))]
OPEN = ["format", "sheet", "column", "probe", "phase", "out"]


def test_a_sheet_that_looks_like_a_run_is_suggested_and_all_the_rest_asked_with_it(folder, capsys):
    book("a.xlsx", ("Notes", [["by hand"]]), ("Run up", RUN_UP_ROWS))
    said = questions(capsys, "a.xlsx")
    assert re.findall(r"^  --([\w-]+): ", said, re.MULTILINE) == OPEN
    assert "its headings suggest Run up, check it" in said and "All in one command" in said
    words = answered(said.splitlines()[-1], {"probes": ["@0.1@x"], "phase": "lag"})
    assert words[words.index("--sheet") + 1] == "Run up"
    assert main.run(words) == 0
    assert np.abs(ksmea.read_measurement("run.csv").values[:, 0]) == pytest.approx([1e-6, 1.5e-6, 2e-6, 2.5e-6])


def test_of_two_sheets_with_a_run_none_is_suggested(folder, capsys):
    book("a.xlsx", ("Up", RUN_UP_ROWS), ("Down", RUN_UP_ROWS))
    said = questions(capsys, "a.xlsx")
    assert re.findall(r"^  --([\w-]+): ", said, re.MULTILINE) == OPEN
    assert "--sheet SHEET" in said and "the other questions are about Up" in said
    words = answered(said.splitlines()[-1], {"probes": ["@0.1@x"], "phase": "lag"})
    assert main.run(words) == 2 and "unknown sheet" in capsys.readouterr().err  # a word in capitals is no answer
    words[words.index("SHEET")] = "Down"
    assert main.run(words) == 0


def test_sheets_without_a_run_are_asked_for_by_name(folder, capsys):
    book("a.xlsx", ("A", [["a", "b"]]), ("B", []))
    said = questions(capsys, "a.xlsx", "--format", "excel")
    assert re.findall(r"^  --([\w-]+): ", said, re.MULTILINE) == ["sheet", "out"] and "More may be open" in said


@pytest.mark.parametrize("with_time", [True, False])
@pytest.mark.parametrize("file_type", ["text", "excel"])
def test_waveforms_are_asked_for_at_once(folder, capsys, file_type, with_time):
    time, keyphasor, signals, _ = sampled(turns=20, samples=4000)
    columns = {"KPH": keyphasor, "A (um)": signals[:, 0], "B (um)": signals[:, 1]}
    columns = ({"t (s)": time} if with_time else {}) | columns
    rows = [list(columns), *np.stack(list(columns.values()), axis=1).tolist()]
    name = {"text": "a.csv", "excel": "a.xlsx"}[file_type]
    if file_type == "text":
        Path(name).write_text("\n".join(",".join(map(str, row)) for row in rows), encoding="utf-8")
    else:
        book(name, ("Scope", rows), ("Notes", [["two probes"]]))
    said = questions(capsys, name, *(() if file_type == "text" else ("--format", "waveform")))
    found = re.findall(r"^  --([\w-]+): ", said, re.MULTILINE)
    first, rate = {"text": ["format"], "excel": ["sheet"]}[file_type], [] if with_time else ["sampling"]
    assert [each for each in found if each != "repeats"] == [*first, "column", *rate, "probe", "out"]
    rate = 1 / (time[1] - time[0])
    words = answered(said.splitlines()[-1], {"probes": ["A@0.1@x", "B@0.1@y"], "sampling": rate, "repeats": "average"})
    assert main.run(words) == 0, capsys.readouterr().err
    given = ["keyphasor=KPH", "signal.A=A (um)", "signal.B=B (um)", *(["time=t (s)"] if with_time else [])]
    direct = File(path=name, format="waveform", columns=given, sheet="Scope" if file_type == "excel" else "",
                  probes=["A@0.1@x", "B@0.1@y"], sampling=None if with_time else rate, repeats="average")  # fmt: skip
    assert ksmea.read_measurement("run.csv").values == pytest.approx(direct.read().values, rel=1e-12)


@pytest.mark.parametrize(
    ("headings", "expected"),
    [
        (["Time", "Keyphasor", "X", "Y"], ("time=Time", "keyphasor=Keyphasor", "signal.X=X", "signal.Y=Y")),
        (["Tacho (V)", "1X (mil)"], ("keyphasor=Tacho (V)", "signal.1X=1X (mil)")),
        (["t", "KPH 1", "KPH 2", "X"], ()),  # which of them?
        (["t", "KPH"], ()),  # no waveform
        (["t", "KPH", "X (um)", "X (mil)"], ()),  # one name twice
        (["Tach speed (rpm)", "1X amp", "1X phase"], ()),  # a table of vectors
        (["KPH", "1X", "phase"], ()),
    ],
)
def test_waveforms_are_suggested_where_one_heading_speaks_of_a_keyphasor(headings, expected):
    assert guessed_waveforms(headings) == expected


def test_a_question_that_its_own_answer_does_not_close_is_asked_once(folder):
    def read(answers):
        raise OpenQuestion("which?", "sheet", ("SHEET",), "A")

    asked = open_questions(read, {})
    assert [each.said for each in asked.questions] == ["which?"] and not asked.is_all


def test_speeds_that_differ_by_rounding_alone_are_averaged(folder):
    """They are written, and read again, as the same number."""
    rows = ["rpm,um", *(f"{speed!r},{size}" for speed, size in ((1000.0, 1), (1000.0000000000001, 3), (1100.0, 5)))]
    Path("a.csv").write_text("\n".join(rows), encoding="utf-8")
    file = File(path="a.csv", format="csv", columns=["speed=rpm", "amplitude=um"], probes=["@0.1@x"], unit="um",
                amplitude="0pk", speed_unit="rpm", repeats="average")  # fmt: skip
    assert np.abs(file.read().values[:, 0]) == pytest.approx([2e-6, 5e-6])


def test_a_file_with_questions_is_read_once(folder, capsys, monkeypatch):
    """Its content once, its table once it is known where that is."""
    example = TABLES["csv_wide"]()
    written(example)
    contents, tables = [], []
    monkeypatch.setattr(
        "measurements.formats.lazy_file.read_bytes", lambda *given: contents.append(1) or read_bytes(*given)
    )
    monkeypatch.setattr(
        "measurements.formats.readers.read_delimited", lambda *given: tables.append(given[2]) or read_delimited(*given)
    )
    said = questions(capsys, example.name)
    assert said.count("\n  --") > 4
    assert len(contents) == 1 and len(tables) == 2 and tables[0] == []  # the first has no headings yet


def test_a_file_without_questions_is_read_once(folder, monkeypatch):
    """The pass that finds nothing open is the one whose rows are written."""
    example = TABLES["csv_wide"]()
    written(example)
    reads = []
    monkeypatch.setattr("measurements.file.foreign_rows", lambda *given: reads.append(1) or foreign_rows(*given))
    assert main.run(["import", example.name, *as_options(example.settings), "--out", "run.csv"]) == 0
    assert len(reads) == 1


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
         ("speed=rpm", "amplitude.X=X amp", "phase.X=X phase", "amplitude.Y=Y amp", "phase.Y=Y phase")),
        (["rpm", "Amp DE (um pp)", "Amp NDE (mil pp)", "Angle NDE", "Angle DE"],  # phases in another order
         ("speed=rpm", "amplitude.DE=Amp DE (um pp)", "phase.DE=Angle DE", "amplitude.NDE=Amp NDE (mil pp)", "phase.NDE=Angle NDE")),
        (["speed_rpm", "X_um_pp", "X_deg", "Y_um_pp", "Y_deg"],
         ("speed=speed_rpm", "amplitude.X=X_um_pp", "phase.X=X_deg", "amplitude.Y=Y_um_pp", "phase.Y=Y_deg")),
        (["RPM", "X [mils pk-pk]", "X Phase Lag [deg]", "Y [mils pk-pk]", "Y Phase Lag [deg]"],
         ("speed=RPM", "amplitude.X=X [mils pk-pk]", "phase.X=X Phase Lag [deg]", "amplitude.Y=Y [mils pk-pk]",
          "phase.Y=Y Phase Lag [deg]")),
        (["n", "A1", "Ph1"], ()),  # A1 is a probe as well
        (["spd", "amp1", "ph1"], ("speed=spd", "amplitude=amp1", "phase=ph1")),
        (["Drehzahl in U/min", "Schwingweg", "Winkel"], ("speed=Drehzahl in U/min", "amplitude=Schwingweg", "phase=Winkel")),
        (["vitesse (tr/min)", "déplacement (µm)", "phase"],
         ("speed=vitesse (tr/min)", "amplitude=déplacement (µm)", "phase=phase")),
        (["velocidad", "desplazamiento", "fase"], ("speed=velocidad", "amplitude=desplazamiento", "phase=fase")),
        (["velocità [giri/min]", "ampiezza", "fase"], ("speed=velocità [giri/min]", "amplitude=ampiezza", "phase=fase")),
        (["转速", "振幅", "相位"], ("speed=转速", "amplitude=振幅", "phase=相位")),
        (["rpm", "amp X", "amp Y"], ("speed=rpm", "amplitude.X=amp X", "amplitude.Y=amp Y")),
        (["rpm", "X amp", "Y amp", "X phase", "Z phase"], ()),  # names disagree
        (["rpm", "amp", "phase", "amp", "phase"], ()),  # nothing tells two probes apart
        (["rpm", "1X amp", "1X phase", "2X amp", "2X phase"], ()),  # harmonics, of which probes?
        (["rpm", "speed 2", "amp"], ()),  # two speeds
        (["rpm", "amp 1", "amp 2", "phase"], ()),  # whose phase?
    ],
)  # fmt: skip
def test_columns_are_suggested_where_headings_tell_them_apart(headings, expected):
    assert guessed_columns(headings) == expected
