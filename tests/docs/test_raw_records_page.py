"""The commands of docs/raw_records.md: what each raw file leaves open, and the vectors that its import gives."""

import re
import shlex
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest

from bench import main
from measurements.file import File
from problems.three_disk import ThreeDisk
from shown_pages import DOCS, ROOT, commands

PAGE = DOCS / "raw_records.md"
COMMANDS = [list(each.words) for each in commands(PAGE)]
IMPORTS = {words[4]: words[3:] for words in COMMANDS if words[3:4] == ["import"] and "--out" in words}
TRUTH = ThreeDisk(sensors=[0.1, 0.5])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("raw")
    script = str(ROOT / "docs" / "examples" / "raw_records.py")
    subprocess.run([sys.executable, script, "records"], cwd=made, check=True)
    return made


def test_the_page_has_a_command_for_each_file():
    assert sorted(IMPORTS) == [
        f"records/{name}" for name in ("logger.csv", "record.tdms", "table.mat", "unmarked.csv", "waveforms.csv")
    ]


@pytest.mark.parametrize(
    ("name", "is_open"),
    [
        ("waveforms.csv", ["format", "probe", "out"]),
        ("table.mat", ["format", "column", "probe", "out"]),
        ("record.tdms", ["format", "column", "keyphasor-edge", "probe", "out"]),
        ("logger.csv", ["format", "column", "probe", "out"]),
        ("unmarked.csv", ["format", "column", "probe", "out"]),
    ],
)
def test_its_questions_and_its_vectors(folder, monkeypatch, capsys, name, is_open):
    if name.endswith("tdms"):
        pytest.importorskip("nptdms", reason="npTDMS is not installed")
    monkeypatch.chdir(folder)
    path = f"records/{name}"
    assert main.run(["import", path]) == 2
    said = capsys.readouterr().err
    assert re.findall(r"^  --([\w-]+): ", said, re.MULTILINE) == is_open
    suggested = shlex.split(said.splitlines()[-1])
    given = IMPORTS[path]
    columns = [[b for a, b in pairwise(words) if a == "--column"] for words in (suggested, given)]
    assert sorted(columns[0]) == sorted(columns[1])  # the page's own
    assert main.run(given) == 0, capsys.readouterr().err
    data = File(path=given[given.index("--out") + 1]).read()
    problem = TRUTH.build().at(data.speed, data.channels)
    reference = TRUTH.reference()
    expected = problem.dense_response(np.array([[reference[each] for each in problem.parameters.names]]))[0]
    found, expected = (np.abs(each) if data.is_amplitude else each for each in (data.values, expected))
    # noise is 3 % in the table; five turns of a run-up, and the mesh of the model, make less away from resonances
    assert np.median(np.abs(found / expected - 1)) < 0.04, name
