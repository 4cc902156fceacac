"""Units and names of a measurement's own file: read, written, and shown."""

import pytest

from bench.commands.import_file import import_file
from ksmea.errors import SettingError
from ksmea.measurement.notation import Notation, of_text
from measurements.file import File


def test_a_notation_comes_back_from_the_line_that_it_writes():
    own = Notation("mil", "pp", "lag", "rpm", {"x at 0.1 m": "3X", "45° at 0.1 m": "3Y; old"})
    assert of_text(
        f"# one\n# {Notation('mil', 'pp', 'lag', names={'x at 0.1 m': '3X'}).line()}\nspeed_rpm\n"
    ).names == {"x at 0.1 m": "3X"}
    assert of_text(f"# {own.line()}\n").unit == "mil pp" and of_text("speed_rpm\n") == Notation()


@pytest.mark.parametrize(
    ("headings", "words"),
    [
        ("speed_rpm,position_m,direction,amplitude_mil_pp,phase_lag_deg", "mil_pp,lag,rpm"),
        ("speed_rpm,position_m,direction,phase_lead_deg,amplitude_um_rms", "µm_rms,lead,rpm"),
        ("speed_rpm,position_m,direction,amplitude_thou_0pk", "mil_0-peak,lead,rpm"),
    ],
)
def test_headings_say_the_units_of_a_file_without_such_a_line(tmp_path, headings, words):
    numbers = {"speed_rpm": (600, 700), "position_m": (0.1, 0.1), "direction": "xx"}
    columns = [numbers.get(name, (1.0, 2.0)) for name in headings.split(",")]
    rows = [",".join(map(str, row)) for row in zip(*columns)]
    path = tmp_path / "run.csv"
    path.write_text("\n".join(["# amplitude_mm_pp is not a heading here", headings, *rows]))
    assert File(path=str(path)).notation.words == words


@pytest.mark.parametrize(
    ("words", "unit", "phase", "speed"),
    [
        ("mil_pp,lag", "mil pp", "lag", "rpm"),
        ("um_rms lead Hz", "µm rms", "lead", "Hz"),
        ("", "µm 0-peak", "lead", "rpm"),
        ("mm_0pk", "mm 0-peak", "lead", "rpm"),
    ],
)
def test_words_choose_units(words, unit, phase, speed):
    found = Notation().with_words(words)
    assert (found.unit, found.phase, found.speed) == (unit, phase, speed)


def test_an_amplitude_is_shown_as_its_detector_shows_it():
    """25.4 µm 0-peak are 2 mil pp and 17.96 µm rms."""
    assert Notation().with_words("mil_pp").vibration(25.4e-6) == pytest.approx(2.0)
    assert Notation().with_words("um_rms").vibration(25.4e-6) == pytest.approx(25.4 / 2**0.5)
    assert Notation().with_words("lag").angle(-65.0) == 65.0


def test_an_unknown_word_is_refused_with_the_choices():
    with pytest.raises(SettingError, match=r"expected words such as mil_pp,lag .* got 'furlong_pp'"):
        Notation().with_words("furlong_pp")


def test_import_writes_units_and_names_that_are_read_again(tmp_path, capsys):
    """From a table in mil pp and lag; values stay what they were."""
    raw = tmp_path / "raw.csv"
    lines = ["rpm,3X mil pp,3X phase lag,3Y mil pp,3Y phase lag"] + [
        f"{1000 + 10 * n},{1 + n},{30 + n},{2 + n},{120 + n}" for n in range(5)
    ]
    raw.write_text("\n".join(lines), encoding="utf-8")
    out = tmp_path / "run.csv"
    words = [
        str(raw),
        "--format",
        "csv",
        "--unit",
        "mil",
        "--amplitude",
        "pp",
        "--phase",
        "lag",
        "--speed-unit",
        "rpm",
        "--out",
        str(out),
    ]
    words += ["--probe", "3X@0.1@x", "--probe", "3Y@0.1@y", "--column", "speed=rpm"]
    words += [
        w
        for p in ("3X", "3Y")
        for w in ("--column", f"amplitude.{p}={p} mil pp", "--column", f"phase.{p}={p} phase lag")
    ]
    assert import_file(words) == 0, capsys.readouterr()
    own = File(path=str(out))
    assert own.notation == Notation("mil", "pp", "lag", "rpm", {"x at 0.1 m": "3X", "y at 0.1 m": "3Y"})
    assert own.read().notation == own.notation and abs(own.read().values[0, 0]) == pytest.approx(12.7e-6)
