"""The bench as its users meet it: as a command in a process of its own, and through its `main` inside this one."""

import fcntl
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest
from hydra.core.global_hydra import GlobalHydra
from hypothesis import HealthCheck, settings

from bench import main
from bench.plan.plan import Cell, ParameterFacts, Plan, ReportSettings, all_runs
from loaded_bench import LoadedBench

# Damaged files (tests/helpers/damaged_files.py): the same ones at each call, or many others with --hypothesis-profile=long.
EVER = {"database": None, "deadline": None, "suppress_health_check": list(HealthCheck)}
settings.register_profile("short", max_examples=40, derandomize=True, **EVER)
settings.register_profile("long", max_examples=2000, print_blob=True, **EVER)
settings.load_profile("short")


HERE = "{here}"  # a folder, in an output that is copied from one to another


@dataclass(frozen=True)
class Ended:
    """How a call of the bench ended, and the folder it wrote to."""

    code: int
    out: str
    err: str
    output: Path

    def table(self, name="table3"):
        return pd.read_csv(self.output / f"{name}.csv")

    def runs(self):
        return pd.read_csv(
            self.output / "runs.csv", dtype={"key": str}, keep_default_na=False, na_values={"time": [""]}
        )

    def records(self):
        return (self.output / "records" / "batch-0000.jsonl").read_text()

    def events(self, event="result"):
        return [line for line in map(json.loads, self.records().splitlines()) if line["event"] == event]

    def cells(self):
        lines = map(json.loads, (self.output / "plan.jsonl").read_text().splitlines())
        return [line for line in lines if line["line"] == "cell"]


def command(words):
    return [sys.executable, "-m", "bench", *words]


def clean_environment(**changes):
    """This process's environment without what would change the bench's behaviour."""
    kept = {key: value for key, value in os.environ.items() if key not in ("BENCH_TRACEBACK", "HYDRA_FULL_ERROR")}
    return kept | changes


@pytest.fixture
def plan():
    """Two cells, 40 and 70 samples, of four repetitions each, made by hand."""
    facts = (ParameterFacts("kxx", "MN/m", 1e6, 50e6), ParameterFacts("u", "g mm", 1e-6, 2e-4))
    settings = {"method": {"name": "ksmea"}}
    cells = tuple(Cell({"samples": n}, {**settings, "samples": n}, 0, facts, "c0de") for n in (40, 70))
    runs = all_runs(cells, 4, {"numpy": "2.0"})
    return Plan(
        name="table3",
        report=ReportSettings(table="summary", paper="table3", figures=(), exact=None),
        axes=("samples",),
        command=("+experiment=table3",),
        commit="c0de",
        versions={"numpy": "2.0"},
        platform="abacus",
        modules={},
        cells=cells,
        runs=runs,
    )


@pytest.fixture(scope="session")
def quick():
    """An experiment of two cells that a core does in a second; a list, to be followed by more overrides."""
    cheap = ["optimizer.generations=5", "optimizer.population=20", "method.max_updates=2"]
    return ["+experiment=table3", *cheap, "samples=25,30"]


@pytest.fixture(scope="session")
def cheapest():
    """Settings without an experiment whose run takes a few milliseconds."""
    return ["optimizer.generations=1", "optimizer.population=5", "method.max_updates=1", "surrogate=none", "samples=25"]


@pytest.fixture(scope="session")
def shell():
    """`python -m bench WORDS` in a process of its own."""

    def call(*words, cwd, output="results/table3", timeout=300, **environment):
        done = subprocess.run(
            command(words),
            check=False,
            cwd=cwd,
            env=clean_environment(**environment),
            capture_output=True,
            text=True,
            timeout=timeout,
        )
        return Ended(done.returncode, done.stdout, done.stderr, Path(cwd, output))

    return call


@pytest.fixture(scope="session")
def apart(tmp_path_factory):
    """`shell` without the seconds for imports and figures: its process is a fork of one that has imported the bench."""
    server, streams = LoadedBench(clean_environment()), tmp_path_factory.mktemp("streams")

    def call(*words, cwd, output="results/table3", timeout=300, draws=False, **environment):
        done = server.call(words, cwd, clean_environment(**environment), streams, timeout, draws)
        return Ended(*done, Path(cwd, output))

    yield call
    server.end()


@pytest.fixture(scope="session")
def start():
    """Process of a command that is not waited for, in a session of its own.

    All its processes can be signalled at once.
    """

    def call(words, cwd):
        return subprocess.Popen(
            command(words),
            cwd=cwd,
            env=clean_environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    return call


@pytest.fixture(scope="session")
def table3(request, apart, quick, tmp_path_factory):
    """The small experiment, done once on two workers; each process of the tests looks at a copy of its folder."""

    def made(folder):
        return apart(*quick, "repetitions=4", "workers=2", cwd=folder, draws=True)

    own = tmp_path_factory.mktemp("table3")
    if not hasattr(request.config, "workerinput"):
        return made(own)
    shared = tmp_path_factory.getbasetemp().parent / "table3"
    with open(shared.with_suffix(".lock"), "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (said := shared.with_suffix(".json")).exists():
            shared.mkdir(exist_ok=True)  # from an attempt that failed
            ended = made(shared)
            said.write_text(json.dumps([ended.code, ended.out.replace(str(shared), HERE), ended.err]))
    shutil.copytree(shared, own, dirs_exist_ok=True)
    code, out, err = json.loads(said.read_text())
    return Ended(code, out.replace(HERE, str(own)), err, own / "results" / "table3")


def undrawn(monkeypatch):
    """Figures are empty files: drawing them takes longer than all else that a small experiment does."""
    monkeypatch.setattr("bench.reports.collect._png", lambda chart: b"")


@pytest.fixture
def no_figures(monkeypatch):
    undrawn(monkeypatch)


@pytest.fixture
def enter(tmp_path, monkeypatch, capsys):
    """The bench inside this process, in a working directory of the test's own; it spares the imports and the figure."""

    def call(*words, output="results/run"):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["bench"])
        undrawn(monkeypatch)
        monkeypatch.setenv("HYDRA_FULL_ERROR", "1")  # `main` sets it: so it is restored
        capsys.readouterr()
        try:
            code = main.run(list(words))
        finally:
            GlobalHydra.instance().clear()
        printed = capsys.readouterr()
        return Ended(code, printed.out, printed.err, tmp_path / output)

    return call
