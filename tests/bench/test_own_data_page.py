"""The commands of docs/own_data.md and docs/file_formats.md that make and import files, as the pages give them."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ksmea
from bench import main

ROOT = Path(__file__).resolve().parents[2]
PAGE, FORMATS = ((ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("own_data.md", "file_formats.md"))
BLOCKS = re.findall(r"```sh\n(.*?)```", PAGE + FORMATS, re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A working directory in which all commands but the experiments were given."""
    made = tmp_path_factory.mktemp("page")
    (made / "docs").mkdir()
    (made / "docs" / "examples").symlink_to(ROOT / "docs" / "examples")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made)
        for words in commands():
            if words[:3] == ["python", "-m", "bench"] and not words[3].startswith("+"):
                assert main.run(words[3:]) == 0, words
            elif words[1] == "docs/examples/made_files.py":
                subprocess.run([sys.executable, *words[1:]], check=True)
    return made


def commands():
    """The words of each command."""
    return [each for block in BLOCKS for each in _split(block)]


def _split(block):
    words = shlex.split(block.replace("\\\n", " "))
    starts = [index for index, word in enumerate(words) if word == "python"]
    return [words[start:stop] for start, stop in zip(starts, [*starts[1:], len(words)])]


def test_the_page_has_the_commands_that_it_speaks_of():
    firsts = [words[3] for words in commands() if words[1:3] == ["-m", "bench"]]
    assert firsts.count("import") == 3 and "export" in firsts and "+experiment=identify" in firsts


def test_the_example_is_read_the_same_imported_or_directly(folder, monkeypatch):
    monkeypatch.chdir(folder)
    code = re.search(r"```python\n(.*?)print", PAGE, re.DOTALL)[1]
    given = {}
    exec(compile(code, "docs/own_data.md", "exec"), given)  # noqa: S102
    imported = ksmea.read_measurement("run.csv")
    assert np.array_equal(given["data"].values, imported.values)
    assert [channel.direction for channel in imported.channels] == ["45", "135"] and len(imported.speed) == 52


def test_the_table_is_the_measurement_that_it_was_made_of(folder):
    made, table = (ksmea.read_measurement(folder / name) for name in ("made.csv", "wide_run.csv"))
    assert table.channels == made.channels
    assert table.values == pytest.approx(made.values, rel=1e-7)  # eight digits in both


def test_the_waveform_holds_what_it_was_made_of(folder):
    data = ksmea.read_measurement(folder / "wave_run.csv")
    amplitude, sigma = np.abs(data.values) * 1e6, data.noise.floor * 1e6
    # 12 standard errors of the mean over windows would be a wrong amplitude, 5 are not
    for channel, expected in ((0, 30.0), (1, 4.0)):
        error = np.mean(amplitude[:, channel]) - expected
        assert abs(error) < 5 * np.mean(sigma[:, channel]) / np.sqrt(len(amplitude))
