"""Plugins of other people: found by their entry point alone, and harmful to nothing but their own runs."""

import json
import random

import numpy as np
import pandas as pd
import pytest

from bench.jobs.execute import execute
from bench.plan.plan import SEED_PLACES, component_seeds, global_entropy
from outside_package import on_path

NAMES = ("mine", "broken", "exiting", "undeclared")
METADATA = "Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n"
ENTRY_POINTS = """\
[ksmea.optimizers]
mine = mine_search:Mine
broken = mine_broken:Broken
exiting = mine_exiting:Exiting
undeclared = mine_search:Plain
"""
MINE = '''
import os
import random
import signal
import sys
import time
from dataclasses import dataclass, replace

import numpy as np

from ksmea import Optimizer
from ksmea.settings.settings import setting


@dataclass(frozen=True)
class Mine(Optimizer):
    """Random search, or some misbehaviour."""

    my_setting: int = setting(10, "points drawn at random", at_least=1)
    behaviour: str = setting("good", "what it does instead", choices=(
        "good", "raises", "asks to exit", "exits", "kills itself", "crashes", "hangs", "asks at NaN", "asks nothing",
        "returns NaN", "draws globally"))

    def minimize(self, objective, rng):
        if self.behaviour == "raises":
            raise KeyError("no such thing\\nat all")
        if self.behaviour == "asks to exit":
            sys.exit("enough")
        if self.behaviour == "exits":
            os._exit(3)
        if self.behaviour == "kills itself":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.behaviour == "crashes":
            os.kill(os.getpid(), signal.SIGSEGV)
        if self.behaviour == "hangs":
            time.sleep(600)
        if self.behaviour == "asks at NaN":
            objective(np.full((3, objective.dim), np.nan))
        if self.behaviour == "draws globally":
            objective(np.random.random((self.my_setting, objective.dim)) * random.random())
            return objective.result()
        if self.behaviour in ("asks at NaN", "asks nothing"):
            return objective.result()
        objective(rng.random((self.my_setting, objective.dim)))
        found = objective.result()
        if self.behaviour == "returns NaN":
            return replace(found, u=np.full(objective.dim, np.nan))
        return found


class Plain:
    """No dataclass."""
'''


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """A folder for PYTHONPATH, as an installer would leave it."""
    folder = tmp_path_factory.mktemp("packages")
    (folder / "mine_search.py").write_text(MINE)
    (folder / "mine_broken.py").write_text("import a_module_that_nobody_has\n")
    (folder / "mine_exiting.py").write_text("raise SystemExit('not today')\n")
    information = folder / "mine-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text(METADATA)
    (information / "entry_points.txt").write_text(ENTRY_POINTS)
    return str(folder)


@pytest.fixture
def enter_with_mine(enter, packages, monkeypatch):
    """The bench with these plugins inside this process, whose registry and Hydra's store forget them afterwards."""
    with on_path(packages, monkeypatch):
        yield enter


def test_it_runs_with_its_settings(enter_with_mine):
    ended = enter_with_mine("optimizer=mine", "optimizer.my_setting=3", "method=direct", "repetitions=2")
    assert (ended.code, ended.err) == (0, "")
    assert ended.runs()["model_evaluations"].tolist() == [3, 3]
    assert ended.cells()[0]["settings"]["optimizer"] == {"name": "mine", "my_setting": 3, "behaviour": "good"}


def test_what_draws_from_global_generators_draws_anew_in_each_run_whatever_the_workers(enter_with_mine, tmp_path):
    words = ["optimizer=mine", "optimizer.behaviour=draws globally", "method=direct", "repetitions=3", "seed=4"]
    words += ["measurement.relative=0", "measurement.floor=0"]  # the same data in all repetitions
    found = []
    for n in (1, 3):
        assert enter_with_mine(*words, f"workers={n}", f"output=results/workers{n}").code == 0
        runs = pd.read_csv(tmp_path / "results" / f"workers{n}" / "runs.csv").sort_values("repetition")
        found.append(runs["kxx"].tolist())
    assert found[0] == found[1] and len(set(found[0])) == 3


def test_a_run_draws_no_numbers_of_the_global_generators_around_it():
    settings = {"study": {"name": "nothing"}}
    before = random.getstate(), np.random.get_state()[1].tolist()
    execute(settings, component_seeds(0, 1))
    assert (random.getstate(), np.random.get_state()[1].tolist()) == before
    assert global_entropy(component_seeds(2, 1)) == [2, 1, 7] and 7 not in SEED_PLACES.values()


def test_it_appears_in_help_beside_what_cannot_be_loaded(enter_with_mine):
    page = enter_with_mine("help", "optimizer")
    assert page.code == 0
    assert "optimizer=mine: Random search, or some misbehaviour." in page.out
    assert "optimizer.my_setting=10  points drawn at random (at least 1)" in page.out
    assert "optimizer=de: " in page.out
    assert "optimizer=broken: mine_broken:Broken cannot be loaded: ModuleNotFoundError" in page.out
    assert "optimizer=exiting: mine_exiting:Exiting cannot be loaded: SystemExit: not today" in page.out
    assert "mine" in enter_with_mine("help").out


@pytest.mark.parametrize(
    "words, expected",
    [
        (
            ["optimizer=mine", "optimizer.my_setting=0"],
            "optimizer=mine: my_setting: expected a number at least 1, got 0",
        ),
        (["optimizer=broken"], "optimizer=broken: mine_broken:Broken cannot be loaded: ModuleNotFoundError: No module"),
        (
            ["optimizer=undeclared"],
            "optimizer=undeclared: expected a frozen dataclass at mine_search:Plain, got <class",
        ),
    ],
)
def test_what_is_wrong_with_it_is_one_line(words, expected, enter_with_mine, tmp_path):
    ended = enter_with_mine(*words)
    assert (ended.code, ended.out) == (2, "")
    [line] = ended.err.splitlines()
    assert line.startswith(f"error: {expected}")
    assert list(tmp_path.iterdir()) == []


# What the plugin does, the status of its run, and a word of the reason.
HARM = {
    "raises": ("error", "KeyError"),
    "asks to exit": ("error", "SystemExit: enough"),
    "exits": ("killed", "exit code 3"),
    "kills itself": ("killed", "SIGKILL"),
    "crashes": ("killed", "SIGSEGV"),
    "hangs": ("timeout", "did not end within 2 s"),
    "asks at NaN": ("error", "not finite"),
    "asks nothing": ("error", "none of the 0 points of the optimiser has a finite misfit"),
}
HARMLESS = ["good", "returns NaN"]  # the objective knows the best point, whatever is returned


@pytest.fixture
def with_mine(apart, packages, tmp_path):
    """Run with a plugin in a process of its own."""
    return lambda *words, **options: apart(*words, cwd=tmp_path, PYTHONPATH=packages, output="results/run", **options)


def test_whatever_it_does_costs_its_own_runs_only(with_mine):
    behaviours = [*HARMLESS, *HARM]
    sweep = f"optimizer.behaviour={','.join(behaviours)}"
    words = ["optimizer=mine", sweep, "method=direct", "repetitions=1", "workers=2", "timeout=2"]
    ended = with_mine(*words)
    assert ended.code == 1
    assert "Traceback" not in ended.out + ended.err
    assert f"{len(HARM)} of {len(behaviours)} failed (" in ended.out
    runs = ended.runs()
    assert len(runs) == len(behaviours)
    for row in runs.itertuples():
        behaviour = behaviours[row.cell]
        status, reason = HARM.get(behaviour, ("done", ""))
        assert row.status == status and reason in row.error, (behaviour, row.error)
    table = ended.table("run")
    is_harmless = table["optimizer.behaviour"].isin(HARMLESS)
    harmless, harmed = table[is_harmless], table[~is_harmless]
    assert (harmless["runs"] == 1).all() and (harmless["failed"] == 0).all() and len(harmless) == 8 * len(HARMLESS)
    assert (harmed["runs"] == 0).all() and (harmed["failed"] == 1).all() and harmed["median"].isna().all()
    errors = [event for event in ended.events() if event["status"] == "error"]
    assert len(errors) == 4 and all("Traceback" in event["traceback"] for event in errors)

    kept = ended.records()
    again = with_mine(*words[:-1], "timeout=0.5")  # failures are tried again, results are not
    assert again.code == 1 and again.records().startswith(kept)
    tried = [
        event for event in map(json.loads, again.records()[len(kept) :].splitlines()) if event["event"] == "started"
    ]
    assert {event["key"] for event in tried} == set(runs.loc[runs["status"] != "done", "key"])
    assert len(tried) == len(HARM)


def test_a_run_that_fails_under_the_surrogate_is_counted_too(enter_with_mine):
    grid = "grid=[{optimizer:de,samples:[25,26,27]},{optimizer:mine,optimizer.behaviour:raises,samples:25}]"
    ended = enter_with_mine(grid, "surrogate=none", "method.max_updates=1", "repetitions=1")
    assert ended.code == 1
    assert "1 of 4 failed (1 × error: KeyError: 'no such thing\\nat all')" in ended.out
    assert ended.runs()["status"].tolist().count("error") == 1
