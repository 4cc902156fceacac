"""Sizes of experiments, labels and messages: known before anything is written, cut where they are shown."""

import csv
import json
import time

import pytest

from outside_package import plain_files

LOUD = '''
from dataclasses import dataclass

from ksmea import Optimizer


@dataclass(frozen=True)
class Loud(Optimizer):
    """Fails with a message of ten megabytes."""

    def minimize(self, objective, rng):
        raise ValueError("#" * 10**7)
'''
FORMULA = "=HYPERLINK(example)"
LONG = "#" * 5000


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (
            ["repetitions=1000000000000"],
            "at most 10000000 runs, got 1e+12 (1 cells × 1e+12 repetitions); give fewer, in several",
        ),
        (
            ["repetitions=100001"],
            "at most 100000 runs, got 100001 (1 cells × 100001 repetitions); give fewer, or force=true",
        ),
        (["seed=range(1,100000000)"], "seed: expected at most 1000000 values, got range(1,100000000) with 99999999"),
        (["measurement.relative=range(0.0,1.0,1e-12)"], "measurement.relative: expected at most 1000000 values, got"),
        (["measurement.relative=range(0,nan)"], "measurement.relative: expected finite numbers from, to and step"),
        (["seed=range(1,50001)", "samples=20,25"], "at most 100000 runs, got 2000000 (100000 cells × 20 repetitions)"),
        (["repetitions=20000000", "force=true"], "at most 10000000 runs, got 20000000"),
        (["force=true,false"], "force: expected one value for the whole experiment"),
    ],
)
def test_more_runs_than_anyone_means_are_refused_before_anything_is_written(words, line, enter, tmp_path):
    started = time.monotonic()
    ended = enter(*words)
    assert ended.code == 2 and line in ended.err and ended.err.count("\n") == 1
    assert time.monotonic() - started < 10 and not [*tmp_path.iterdir()]


def test_a_forced_plan_is_made(enter):
    """100 001 cells would take minutes to compose; a report without runs counts its cells too."""
    ended = enter("table=settings", "repetitions=0", "force=true")
    assert (ended.code, ended.err) == (0, "")


def test_the_number_of_many_runs_is_said_before_they_are_begun(enter, cheapest, monkeypatch):
    from bench.plan import size

    monkeypatch.setattr(size, "MANY", 2)
    ended = enter(*cheapest, "repetitions=2", "workers=1")
    assert f"run: 2 runs (1 cells × 2 repetitions) in {ended.output}" in ended.err


@pytest.fixture
def loud(enter, cheapest, tmp_path):
    (tmp_path / "loud.py").write_text(LOUD)
    lines = f"grid=[{{label: '{FORMULA}'}},{{label: '{LONG}'}},{{label: '{LONG}+'}},{{label: loud, optimizer: loud, method: direct}}]"
    words = [word for word in cheapest if not word.startswith("optimizer.")]
    with plain_files(tmp_path):
        yield enter(*words, "plugins=[loud.py]", lines, "optimizer.de.generations=1", "repetitions=1", "workers=1")


def test_long_labels_and_messages_are_cut_where_they_are_shown(loud, enter):
    assert loud.code == 1 and len(loud.out) < 20_000 and "#" * 600 not in loud.out
    assert (loud.output / "run.log").stat().st_size < 20_000
    assert (loud.output / "runs.csv").stat().st_size < 20_000
    key = next(row["key"] for row in loud.runs().to_dict("records") if row["status"] == "error")
    assert len(enter("explain", key).out) < 50_000
    shown = [row.split("…")[1].split(")")[0] for row in loud.out.splitlines() if " kxx " in row and "…" in row]
    assert len(shown) == len({*shown}) == 2, "labels that begin alike are distinguished"
    assert len(next(line for line in loud.events() if line["status"] == "error")["error"]) < 11_000


def test_no_cell_of_a_table_is_a_formula(loud):
    for name in ("runs.csv", "run.csv"):
        with (loud.output / name).open(newline="") as file:
            rows = list(csv.DictReader(file))
        cells = [cell for row in rows for cell in row.values()]
        assert f"'{FORMULA}" in cells and FORMULA not in cells
        assert any(cell.startswith("-") for cell in cells) is (name == "runs.csv")  # numbers stay
    assert json.loads((loud.output / "plan.jsonl").read_text().splitlines()[1])["place"]["label"] == FORMULA
