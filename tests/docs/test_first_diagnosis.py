"""The page that leads from a CSV to a diagnosis: its rotor file is a rotor, its import reads such a file, and it is short."""

import numpy as np
import pytest

import ksmea
from bench import main
from shown_pages import DOCS, ROOT, blocks, commands, text_of

PAGE = DOCS / "first_diagnosis.md"
MOST_WORDS = (
    700  # three minutes at 238 words a minute, the mean of silent reading (Brysbaert, J. Mem. Lang. 109, 2019, 104047)
)


def test_the_rotor_file_of_the_page_is_the_three_disk_rotor(tmp_path):
    [file] = blocks(text_of(PAGE), "yaml")
    (tmp_path / "my_rotor.yaml").write_text(file, encoding="utf-8")
    values = {"kxx": 50.0, "kyy": 70.0, "cxx": 0.5, "cyy": 0.7, "u": 200.0}
    shown, known = ksmea.load_problem(str(tmp_path / "my_rotor.yaml")), ksmea.load_problem("three_disk")
    speed = np.linspace(200.0, 1500.0, 9)
    # 1e-9: the same elements, solved the same way; the rotors are written with the same digits
    assert shown.response(values, speed=speed) == pytest.approx(known.response(values, speed=speed), rel=1e-9)


def test_the_import_of_the_page_reads_a_file_with_such_headings(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lines = [
        line.split(",") for line in (DOCS / "examples" / "run_up.csv").read_text().splitlines() if line[0].isdigit()
    ]
    pairs = zip(lines[::2], lines[1::2])
    rows = [f"{x[0]},{2 * float(x[3])},{-float(x[4])},{2 * float(y[3])},{-float(y[4])}" for x, y in pairs]
    (tmp_path / "bode.csv").write_text("\n".join(["rpm,X,X_deg,Y,Y_deg", *rows]))
    [words] = [list(command.words[3:]) for command in commands(PAGE) if command.words[3:4] == ("import",)]
    assert main.run(words) == 0, capsys.readouterr().err
    back = ksmea.read_measurement("run_up.csv")
    there = ksmea.read_measurement(str(DOCS / "examples" / "run_up.csv"))
    assert back.channels == there.channels
    assert back.values == pytest.approx(there.values, rel=1e-12)  # halved what was doubled: rounding of the text alone


def test_a_newcomer_reads_the_way_in_three_minutes():
    """The README as far as the link, and the page with its rotor file and commands."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    until, link, _ = readme.partition("](docs/first_diagnosis.md)")
    assert link and len(until.split()) + len(text_of(PAGE).split()) <= MOST_WORDS
