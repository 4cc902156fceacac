"""Files of loggers without headings: columns by their number, separated by anything."""

import re

import numpy as np
import pytest

from bench import main
from ksmea.errors import SettingError
from measurements.file import File

SPEED = np.arange(600.0, 3000.0, 100.0)
VALUES = 40 * SPEED**2 / (1700**2 - SPEED**2 + 170j * SPEED)  # µm
LAG = np.mod(-np.angle(VALUES, deg=True), 360)
TABLE = ["speed=#1", "amplitude=#2", "phase=#3"]
OPTIONS = {
    "columns": TABLE,
    "probes": ["@0.1@x"],
    "unit": "um",
    "amplitude": "0pk",
    "phase": "lag",
    "speed_unit": "rpm",
}


def table(separator, decimal=".", remark=""):
    lines = [
        separator.join(f"{each:.6f}" for each in row).replace(".", decimal) for row in zip(SPEED, np.abs(VALUES), LAG)
    ]
    return remark + "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    "text",
    [
        table(","),
        table(";", ","),
        table("\t"),
        table("   "),
        "  " + table(" ").replace("\n", "\n  "),
        table(",", remark="# run 3\n"),
    ],
)
def test_the_first_line_is_a_row_like_the_others(tmp_path, text):
    (tmp_path / "log.txt").write_text(text)
    data = File(path=str(tmp_path / "log.txt"), format="csv", **OPTIONS).read()
    assert len(data.speed) == len(SPEED)
    np.testing.assert_allclose(data.values[:, 0] * 1e6, VALUES, rtol=1e-5)


def test_columns_with_headings_may_still_be_named_by_number(tmp_path):
    for preamble in ("", "Rig 3\n"):
        (tmp_path / "head.csv").write_text(f"{preamble}n,A,lag\n{table(',')}")
        assert len(File(path=str(tmp_path / "head.csv"), format="csv", **OPTIONS).read().speed) == len(SPEED)


def waves():
    time = np.arange(12_000) / 3000
    turns = 23.17 * time + 0.3 * time**2
    motion = (12 * np.exp(2j * np.pi * turns + 0.7j)).real
    return np.stack([time, np.where(turns % 1 < 0.08, 5.0, 0.0), motion], axis=1)


@pytest.mark.parametrize("separator", [",", " ", "\t"])
def test_waveforms_need_no_headings(tmp_path, separator):
    np.savetxt(tmp_path / "wave.txt", waves(), "%.9g", separator)
    columns = ["time=#1", "keyphasor=#2", "signal.A=#3"]
    path = str(tmp_path / "wave.txt")
    data = File(path=path, format="waveform", columns=columns, probes=["A@0.1@x"], unit="um").read()
    # edges between samples: half a sample of 130 in a turn
    np.testing.assert_allclose(data.values[:, 0] * 1e6, 12 * np.exp(0.7j), atol=12 * np.pi / 100)
    (tmp_path / "wave.txt").write_text(
        (tmp_path / "wave.txt").read_text().replace("\n", f"{separator}\n", 1)
    )  # an empty cell
    if separator == ",":
        with pytest.raises(SettingError, match="expected 4 cells as in the header, got 3"):
            File(path=path, format="waveform", columns=columns, probes=["A@0.1@x"], unit="um")


def test_a_file_without_headings_says_how_columns_are_called(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "log.csv").write_text(table(","))
    assert main.run(["import", "log.csv"]) == 2
    said = capsys.readouterr().err
    assert "the file has no headings: columns are #1, #2, …" in said and "--column 'speed=#NUMBER'" in said
    np.savetxt(tmp_path / "wave.csv", waves(), "%.9g", ",")
    assert main.run(["import", "wave.csv", "--format", "waveform"]) == 2
    assert re.search(r"columns are #1, #2, ….*--column 'keyphasor=#NUMBER'", capsys.readouterr().err, re.DOTALL)
