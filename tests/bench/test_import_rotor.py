"""`import rotor` on the command line: what it writes draws at once, says what is open, and answers make a problem for data."""

import os
import re
from pathlib import Path

import numpy as np
import pytest

import ksmea
from bench import main
from ksmea.settings.strict_yaml import parse
from problems.rotor_file import RotorFile
from ross_models import SPEEDS, as_toml, bearing, element, model, saved, table

DATA = Path(os.environ.get("KSMEA_DATA", Path(__file__).resolve().parents[3] / "shared" / "data")) / "rotors"
FILES = (
    "ross-1.5.4-small.toml",
    "ross-2.3.0/magnetic.toml",
    "ross-3.1.0/two_axes.toml",
    "ross-2.3.0/supports.toml",
    "ross-2.3.0/layers.toml",
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def imported(folder, capsys):
    def of(*words, **sections):
        path = saved(folder, model(**sections))
        code = main.run(["import", "rotor", path, *words])
        told = capsys.readouterr()
        return code, told.out, told.err

    return of


@pytest.mark.parametrize("file", FILES)
def test_samples_come_out_as_rotors_that_draw(folder, capsys, file):
    if not DATA.exists():
        pytest.skip(f"no rotor models in {DATA.parent}; KSMEA_DATA names the directory of public data")
    assert main.run(["import", "rotor", str(DATA / file), "--out", "rotor.yaml"]) == 0
    drawing = ksmea.load_problem("rotor.yaml").draw({})
    assert drawing.record.layout.mass > 0
    assert "count, to compare with the drawing" in capsys.readouterr().out


def test_the_count_has_what_the_drawing_has(imported):
    code, told, _ = imported(SealElement__s=bearing(3), PointMass__p={"n": 1, "m": 2.0})
    assert code == 0
    assert "  shaft: 4 elements; 0.4 m; 6.158 kg\n" in told
    assert "  disks: 1 at 0.2 m; 5 kg\n  lumped masses: 1 at 0.1 m; 2 kg\n" in told
    assert "  bearings: 2 at 0, 0.4 m; 1 over speed\n  seals: 1 at 0.3 m\n  in all: 13.16 kg\n" in told
    assert "open: unbalance and unknowns" in told and "open: probes" in told
    assert told.endswith("next: python -m bench draw problem=rotor problem.file=model.yaml\n")


def test_answers_make_a_problem_for_data(imported):
    code, told, _ = imported(
        "--unbalance",
        "0.2",
        "--unbalance",
        "0.3",
        "--probe",
        "1X@0.1",
        "--probe=left@0.1@45",
        "--speeds",
        "500:6000:20",
    )
    assert code == 0 and "open" not in told
    problem = RotorFile(file="model.yaml").build()
    assert problem.parameters.names[:3] == ("u1", "u2", "phase2")
    assert {"kxx1", "stiffness2", "damping2"} <= set(problem.parameters.names)
    assert [(each.position, each.direction) for each in problem.channels] == [(0.1, "x"), (0.1, "45")]
    assert problem.speed[[0, -1]] == pytest.approx(np.array([500, 6000]) * np.pi / 30) and len(problem.speed) == 20
    middle = (problem.parameters.lower + problem.parameters.upper) / 2
    assert np.all(np.isfinite(problem.response(middle[None])))


def test_lines_of_what_is_open_are_ready_to_be_uncommented(imported):
    """Where all bearings are tables; a constant one has to lose the numbers that an unknown sets, as the file says."""
    code, _, _ = imported(**{"BearingElement__Bearing 0": table(0)})
    path = Path("model.yaml")
    text = path.read_text(encoding="utf-8")
    start = text.index("# unbalance:")
    opened = re.sub(r"^# (unbalance:|probes:|unknowns:|  - )", r"\1", text[start:], flags=re.MULTILINE)
    path.write_text(text[:start] + opened, encoding="utf-8")
    assert code == 0
    assert RotorFile(file="model.yaml").build().parameters.names == (
        "u1",
        "stiffness1",
        "damping1",
        "stiffness2",
        "damping2",
    )


def test_long_tables_stand_beside_the_file_and_say_the_same(imported):
    speed = np.linspace(100, 800, 13)
    rows = {
        name: np.interp(speed, SPEEDS, values).tolist()
        for name, values in table(4).items()
        if name in ("kxx", "kyy", "cxx", "cyy")
    }
    code, told, _ = imported(
        "--out", "out/rotor.yaml", **{"BearingElement__Bearing 4": table(4, frequency=speed.tolist(), **rows)}
    )
    assert code == 0 and told.startswith("written: out/rotor.yaml, out/rotor_bearing_2.csv\n")
    (_, own) = RotorFile(file="out/rotor.yaml").build().rotor.bearings
    assert own.table.speed == pytest.approx(tuple(speed), rel=1e-14)  # rpm in 15 digits
    assert [row[0] for row in own.table.rows] == pytest.approx(rows["kxx"], rel=1e-15)


def test_a_shaft_that_turns_from_y_to_x_is_mirrored_on_reading(imported):
    crossed = {"BearingElement__Bearing 0": bearing(0, kxy=[3e6], kyx=[-2e6])}
    assert imported("--rotation", "y to x", **crossed)[0] == 0
    assert parse(Path("model.yaml").read_bytes(), "model.yaml")["rotation"] == "y to x"
    own = RotorFile(file="model.yaml").build().rotor.bearings[0]
    assert (own.kxy, own.kyx) == (-3e6, 2e6)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--rotation", "left"], "unknown --rotation 'left'"),
        (["--axes", "z"], "unknown --axes 'z'"),
        (["--probe", "1X"], "expected such as 1X@0.16"),
        (["--probe", "z@0.1"], "expected x, y or degrees from x towards y"),
        (["--probe", "x@9"], "probes[1].position: probe at 9 m"),
        (["--unbalance", "9"], "unbalance[1].position"),
        (["--speeds", "6000:500:10"], "expected rpm that rise"),
        (["--speeds", "500:6000:0"], "speeds.number: expected a whole number"),
        (["--speeds", "1", "--speeds", "2"], "expected --speeds once"),
        (["--colour", "red"], "unknown option '--colour'"),
        (["--unbalance"], "expected a value after --unbalance"),
        (["--shaft", "shaft.csv"], "expected a model or tables"),
        (["other.toml"], "expected one model"),
        (["--out", "rotor.txt"], "expected --out with the name of a YAML file"),
        (["--out", "a#b.yaml"], "expected --out without #"),
        (["--out", "there.yaml"], "expected no there.yaml yet, found one"),
    ],
)
def test_what_is_wrong_is_said_in_one_line_and_nothing_is_written(imported, folder, words, said):
    (folder / "there.yaml").write_text("mine", encoding="utf-8")
    code, told, error = imported(*words)
    assert code == 2 and not told and error.count("\n") == 1
    assert error.startswith("error: import rotor: ") and said in error
    assert sorted(path.name for path in folder.iterdir()) == ["model.json", "there.yaml"]


@pytest.mark.parametrize(
    ("sections", "said"),
    [
        ({"BearingElement__Bearing 4": table(4, frequency=list(range(1, 20002)), **dict.fromkeys(("kxx", "kyy", "cxx", "cyy"), [1e7] * 20001))}, "rows"),
        ({f"ShaftElement__e{n}": element(n, odl=0.05 + n * 1e-5) for n in range(4, 6000)}, "expected at most"),
    ],
)  # fmt: skip
def test_a_model_far_too_large_is_refused_before_it_takes_long(imported, sections, said):
    code, _, error = imported(**sections)
    assert code == 2 and said in error and error.count("\n") == 1 and not list(Path().glob("*.yaml"))


def test_a_model_that_is_no_rotor_is_refused_by_the_place_in_it(imported):
    code, _, error = imported(**{"BearingElement__Bearing 4": table(4, frequency=[1.0, 2.0, 2.0, 3.0])})
    assert code == 2 and "in words of a rotor file, bearings[2].table" in error and not Path("model.yaml").exists()


def test_a_model_given_elsewhere_is_sent_to_its_import(folder, capsys):
    path = saved(folder, model())
    toml, table = folder / "model.toml", folder / "shaft.csv"
    toml.write_text(as_toml(model()), encoding="utf-8")
    table.write_text("length\n1\n", encoding="utf-8")
    for words, said in (
        (["import", path, "--out", "x.csv"], "a model of a rotor is imported by: import rotor "),
        (
            ["draw", "problem=rotor", "problem.file=model.toml"],
            "made into a rotor file by python -m bench import rotor",
        ),
        (["import", "rotor", "shaft.csv"], "got a table; give it as --shaft shaft.csv"),
    ):
        assert main.run(words) == 2
        error = capsys.readouterr().err
        assert said in error and error.count("\n") == 1
