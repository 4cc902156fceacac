"""Code from outside the project is part of a run's key: an edit, a data file or another version makes results stale."""

import json
import os
import shutil
import subprocess
import sys

import pytest

from bench.plan.outside import outside_code
from bench.plan.plan import question_of

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
def call(apart, site, tmp_path):
    def run(*words):
        return apart(*words, cwd=tmp_path, output="results/run", PYTHONPATH=str(site))

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


TWO = {
    "two_searches/__init__.py": "",
    "two_searches/shared.py": "COUNT = 3\n",
    "two_searches/one.py": "from two_searches.shared import COUNT\n"
    + SEARCH.partition("@dataclass")[0].replace("importlib", "math")
    + "@dataclass(frozen=True)\nclass One(Optimizer):\n    def minimize(self, objective, rng):\n"
    "        objective(rng.random((COUNT, objective.dim)))\n        return objective.result()\n",
    "two_searches/README.md": "Two searches.\n",
    "two_searches_core.py": "COUNT = 1\n",
}
TWO["two_searches/other.py"] = (
    TWO["two_searches/one.py"].replace("One", "Other").replace("COUNT\n", "COUNT\nimport two_searches_core\n", 1)
)


@pytest.fixture(params=[True, False], ids=["installed", "source tree"])
def two(request, tmp_path):
    """A package with two optimisers, which share one module; the other one has a further module, of another top level."""
    folder = tmp_path / "site"
    folder.mkdir()
    entry = "[ksmea.optimizers]\none = two_searches.one:One\nother = two_searches.other:Other\n"
    information = installed(folder, "two-searches", "1.0", TWO, "", entry, with_record=request.param)
    (information / "top_level.txt").write_text("two_searches\ntwo_searches_core\n")
    return folder


@pytest.mark.parametrize(
    ("file", "text", "stale"),
    [
        ("two_searches/other.py", "\nWIDTH = 2\n", ["other"]),
        ("two_searches_core.py", "\nWIDTH = 2\n", ["other"]),
        ("two_searches/shared.py", "\nWIDTH = 2\n", ["one", "other"]),
        ("two_searches/__init__.py", "\nWIDTH = 2\n", ["one", "other"]),
        ("two_searches/one.py", "\n# a remark\n", []),
        ("two_searches/README.md", "More words.\n", []),
        ("two_searches/data.csv", "1\n", ["one", "other"]),
        ("two_searches/changes.csv", "1\n", ["one", "other"]),
    ],
)
def test_an_edit_makes_results_of_the_plugins_that_use_it_stale(two, digests_in, file, text, stale):
    if file.endswith(".csv"):
        (two / file).write_text("0\n")
        if (record := next(two.glob("*.dist-info/RECORD"), None)) is not None:
            record.write_text(record.read_text() + f"{file},,\n")
    before = digests_in(two)
    (two / file).write_text((two / file).read_text() + text)
    after = digests_in(two)
    assert [name for name in before if before[name] != after[name]] == stale


@pytest.mark.parametrize(
    "means",
    [
        "import importlib\nload = importlib.import_module(__name__.replace('one', 'other'))",
        "from importlib import import_module as load",
        "from importlib.util import spec_from_file_location",
        "import runpy",
        "from two_searches import *",
        "exec('import two_searches.other')",
        "import importlib\nload = importlib.import_module",
        "import importlib\nspec = importlib.util.find_spec('two_searches.other')",
    ],
)
def test_all_modules_count_if_one_may_load_others_by_name(two, digests_in, means):
    (two / "two_searches" / "one.py").write_text((two / "two_searches" / "one.py").read_text() + f"\n{means}\n")
    before = digests_in(two)
    (two / "two_searches" / "other.py").write_text((two / "two_searches" / "other.py").read_text() + "\nWIDTH = 2\n")
    assert digests_in(two)["one"] != before["one"]


DIGESTS = """
import os, sys
from bench.plan.provenance import code_digest, used_modules
for line in sys.stdin:
    child = os.fork()
    if child == 0:  # it knows no other site, and no earlier state of this one
        sys.path.insert(1, line.removesuffix("\\n"))
        for name in ("one", "other"):
            print(name, code_digest(used_modules({"optimizer": {"name": name}})), flush=True)
        os._exit(0)
    print("ended", os.waitpid(child, 0)[1], flush=True)
"""


@pytest.fixture(scope="module")
def digests_in():
    """Digest of what runs with each of the two optimisers use, in a process that finds the package in a folder."""
    words, pipes = [sys.executable, "-c", DIGESTS], {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(words, text=True, **pipes) as process:

        def read(site):
            print(site, file=process.stdin, flush=True)
            found = {}
            while "ended" not in found:
                name, value = process.stdout.readline().split()
                found[name] = value
            assert found.pop("ended") == "0" and len(found) == 2
            return found

        yield read
        process.stdin.close()


def test_plugins_of_the_project_bring_nothing_along():
    assert outside_code(["optimizers.de", "problems.three_disk", "ksmea.identification.ksmea"]) == {}


LOUD = "import pathlib\npathlib.Path(__file__).with_name('imported').touch()\n"
RECEIVED = {  # what a plan of a received folder may name; each package says so when it is imported
    "loud/__init__.py": LOUD,
    "loud/inner/__init__.py": LOUD,
    "loud/inner/search.py": LOUD
    + TWO["two_searches/one.py"].replace("from two_searches.shared import COUNT", "COUNT = 3"),
    "loud/study.py": LOUD,
}


@pytest.fixture(scope="module")
def done(apart, cheapest, tmp_path_factory):
    """A run with plugins of this project, in a folder to be copied."""
    ended = apart(*cheapest, "repetitions=1", "workers=1", cwd=tmp_path_factory.mktemp("done"), output="results/run")
    assert ended.code == 0, ended.err
    return ended


@pytest.mark.parametrize(
    "named",
    [
        {"parts": ["optimizer=loud_one"]},
        {"parts": ["effect=loud_one", "loud.inner.search", "optimizer=loud.inner.search"]},
        {"parts": ["loud=inner", "=loud.inner", "loud="]},
        {"optimizer": {"name": "loud_one"}},
        {"optimizer": {"name": "loud.inner.search"}},
        {"study": {"name": "loud_study"}},
        {"study": {"name": "loud.study"}},
    ],
)
def test_nothing_that_a_received_folder_names_is_imported(named, apart, done, tmp_path):
    """Registered plugins are read as files, also by `status` and `explain`; what is not registered is not looked for."""
    site = tmp_path / "site"
    site.mkdir()
    entry = "[ksmea.optimizers]\nloud_one = loud.inner.search:One\n[ksmea.studies]\nloud_study = loud.study:Study\n"
    installed(site, "loud", "1.0", RECEIVED, "", entry)
    received = shutil.copytree(done.output, tmp_path / "results" / "run")
    lines = [json.loads(line) for line in (received / "plan.jsonl").read_text().splitlines()]
    [cell] = [line for line in lines if line["line"] == "cell"]
    cell["settings"] |= named
    for line in lines:
        if line["line"] == "run":  # as whoever makes such a folder would
            line["question"] = question_of(cell["settings"], cell["seed"], line["repetition"])
    (received / "plan.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    key = done.runs()["key"][0]
    for words in (["status", "run"], ["explain", key, "run"], ["merge", "run", "run", "--out", "merged"]):
        looked = apart(*words, cwd=tmp_path, PYTHONPATH=os.pathsep.join([str(site), os.environ.get("PYTHONPATH", "")]))
        assert looked.code in (0, 1, 2) and "Traceback" not in looked.err, looked.err
    assert not [*site.rglob("imported")]
