"""Code from outside the project is part of a run's key: an edit, a data file or another version makes results stale."""

import pytest

from bench.plan.outside import outside_code

WORDS = ["optimizer=theirs", "method=direct", "repetitions=1"]
SEARCH = '''
import importlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ksmea import Optimizer


@dataclass(frozen=True)
class Theirs(Optimizer):
    """As many random points as the data file of the package, a second package and a module by name say."""

    def minimize(self, objective, rng):
        count = int(Path(__file__).with_name("count.txt").read_text())
        count += importlib.import_module("their_second.counts").COUNT
        objective(rng.random((count, objective.dim)))
        return objective.result()
'''


def installed(folder, name, version, files, metadata="", entry_points="", with_record=True):
    """A distribution as an installer would leave it; without a record, as a source tree has it."""
    information = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    information.mkdir()
    (information / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n{metadata}")
    if entry_points:
        (information / "entry_points.txt").write_text(entry_points)
    for path, text in files.items():
        (folder / path).parent.mkdir(exist_ok=True)
        (folder / path).write_text(text)
    if with_record:
        (information / "RECORD").write_text("".join(f"{path},,\n" for path in [*files, f"{information.name}/RECORD"]))
    return information


@pytest.fixture(params=[True, False], ids=["installed", "source tree"])
def site(request, tmp_path):
    folder = tmp_path / "site"
    folder.mkdir()
    files = {"their_search/__init__.py": SEARCH, "their_search/count.txt": "3"}
    entry = "[ksmea.optimizers]\ntheirs = their_search:Theirs\n"
    needs = "Requires-Dist: their-needs\nRequires-Dist: numpy\nRequires-Dist: absent; extra == 'more'\n"
    installed(folder, "their-search", "1.0", files, needs, entry, with_record=request.param)
    installed(
        folder,
        "their-needs",
        "2.0",
        {"their_needs.py": "", "their_needs_data.bin": "1"},
        "Requires-Dist: ksmea-bench\n",
    )
    (folder / "their_second").mkdir()
    (folder / "their_second" / "counts.py").write_text("COUNT = 2\n")
    return folder


@pytest.fixture
def call(shell, site, tmp_path):
    def run(*words):
        return shell(*words, cwd=tmp_path, output="results/run", PYTHONPATH=str(site))

    return run


def needs_version(folder, version):
    information = next(folder.glob("their_needs-*.dist-info"))
    text = (information / "METADATA").read_text().replace("Version: 2.0", f"Version: {version}")
    (information / "METADATA").write_text(text)


def test_what_a_package_from_outside_brings_along_makes_results_stale(call, site):
    ended = call(*WORDS)
    assert (ended.code, ended.err) == (0, "")
    assert call("status", "run").code == 0
    (site / "their_search" / "count.txt").write_text("4")
    (site / "their_second" / "counts.py").write_text("COUNT = 5\n")
    needs_version(site, "2.1")
    status = call("status", "run")
    assert status.code == 1 and "stale      1" in status.out, status.out
    key = ended.runs()["key"][0]
    changed = call("explain", key).out.splitlines()[-1]
    for what in ("file their_search/count.txt", "file their_second/counts.py", "distribution their-needs 2.0 → 2.1"):
        assert what in changed  # each is seen, and not the others alone
    again = call(*WORDS)
    assert again.runs()["key"][0] != key and again.runs()["model_evaluations"][0] == 9
    assert call("status", "run").code == 0


def test_plugins_of_the_project_bring_nothing_along():
    assert outside_code(["optimizers.de", "problems.three_disk", "ksmea.identification.ksmea"]) == {}
