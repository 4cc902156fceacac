"""`export`: the course of runs in the formats of IOHprofiler and COCO, and as a table.

The programs that read these formats (the extra `export`) are asked where they are here, or in an environment whose interpreter
`EXPORT_PYTHON` names. Without them the files are compared with the formats as they are documented.
"""

import dataclasses
import importlib.util
import json
import os
import subprocess
import sys
import tarfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from bench.plan.plan import Cell, ParameterFacts, all_runs, read_plan, write_plan
from bench.reports.exports.coco import PRECISION, write_coco
from bench.reports.exports.courses import NOTHING, courses
from bench.reports.exports.ioh import HEADER, write_ioh
from bench.reports.identification.trace_table import Traced, read_traces
from ksmea.records.trace import TraceRecord

READER = Path(__file__).parents[1] / "helpers" / "read_exports.py"
ARE_HERE = all(importlib.util.find_spec(name) for name in ("cocopp", "iohinspector"))
PYTHON = os.environ.get("EXPORT_PYTHON") or (sys.executable if ARE_HERE else None)
needs_readers = pytest.mark.skipif(
    PYTHON is None, reason="no cocopp and iohinspector here: install the extra `export`, or name its EXPORT_PYTHON"
)
SYMBOLS = ("kxx", "kyy", "u")


def cell(label, noise, problem="three_disk", unknowns=2, **method):
    facts = tuple(ParameterFacts(name, "-", 1.0, 1.0) for name in SYMBOLS[:unknowns])
    settings = {
        "problem": {"name": problem},
        "measurement": {"name": "synthetic", "relative": noise},
        "method": {"name": "direct", **method},
        "optimizer": {"name": label},
    }
    return Cell({"samples": None, "label": label, "measurement.relative": noise}, settings, 0, facts, "c0de")


@pytest.fixture
def plan(plan):
    """Two methods on two instances of one problem, one of them on a second problem too, with two repetitions each."""
    cells = (
        cell("Kriging + DE", 0.05),
        cell("CMA-ES", 0.05, budget=30),
        cell("Kriging + DE", 0.1),
        cell("CMA-ES", 0.1),
        cell("CMA-ES", 0.1, "rk4", 3),
    )
    axes = ("samples", "label", "measurement.relative")
    return dataclasses.replace(plan, name="contest", axes=axes, cells=cells, runs=all_runs(cells, 2, plan.versions))


def traced(evaluations, excess, jacobians=None, total=(20, 0), least=1e5):
    """A trace in which a third of a value was not representable in fewer than 17 digits."""
    n = len(evaluations)
    misfit = tuple(least + value for value in excess)
    columns = tuple(evaluations), tuple(jacobians or [0] * n), (7,) * n, misfit, (0.25,) * n
    return Traced(TraceRecord(*columns, error=tuple(value / 3 for value in excess), least=least), *total)


@pytest.fixture
def found(plan):
    """Of both repetitions of the cells: an ordinary run, one that begins late, one that has failed, and some with nothing."""
    keys = {(run.cell, run.repetition): run.key for run in plan.runs}
    traces = {
        keys[0, 0]: traced([1, 4, 9], [100.0, 10.0, 1.0]),
        keys[0, 1]: traced([1, 20], [50.0, -0.5]),
        keys[1, 1]: traced([3, 5, 5], [30.0, 20.0, 1e-12], [0, 0, 2], (10, 3)),
        keys[2, 0]: traced([1], [7.0], total=(1, 0)),
        keys[3, 0]: dataclasses.replace(
            traced([1], [7.0]), trace=dataclasses.replace(traced([1], [7.0]).trace, least=None)
        ),
        keys[4, 0]: traced([1, 2], [70.0, 60.0]),
    }
    statuses = {**dict.fromkeys(traces, "done"), keys[1, 0]: "error", keys[2, 1]: "killed"}
    return courses(plan, traces, statuses)


def course(found, algorithm, instance, repetition, family="three_disk"):
    [one] = [
        each
        for each in found.courses
        if (each.place.algorithm, each.place.instance, each.place.family) == (algorithm, instance, family)
        and each.repetition == repetition
    ]
    return one


def test_a_course_goes_from_cost_one_to_the_cost_of_the_run(found):
    first = course(found, "Kriging + DE", 1, 0)
    assert first.costs.tolist() == [1, 4, 9, 20]  # in all it took 20, the last 11 without an improvement
    assert first.excess == pytest.approx([100, 10, 1, 1])
    late = course(found, "CMA-ES", 1, 1)  # a Jacobian as 2
    assert late.costs.tolist() == [1, 3, 5, 9, 16] and late.excess[0] == NOTHING
    assert course(found, "Kriging + DE", 2, 0).costs.tolist() == [1]
    for each in found.courses:
        assert each.costs[0] == 1 and (np.diff(each.costs) > 0).all() and (np.diff(each.excess) <= 0).all()


def test_of_improvements_at_one_cost_the_last_counts(plan, monkeypatch):
    """Where a Jacobian costs nothing, points that differ by Jacobians alone have the same cost; a reader would take a second row
    at cost 1 for another run."""
    monkeypatch.setattr("bench.reports.exports.courses.jacobian_price", lambda cell: 0)
    trace = traced([1, 1, 2], [9.0, 8.0, 7.0], [0, 1, 1], (2, 1))
    [free] = courses(plan, {plan.runs[0].key: trace}, {}).courses
    assert free.costs.tolist() == [1, 2] and free.excess == pytest.approx([8, 7])


def test_a_failed_run_has_nothing_at_the_cost_of_its_budget(found):
    failed = course(found, "CMA-ES", 1, 0)
    assert failed.costs.tolist() == [1, 30] and (failed.excess == NOTHING).all()
    killed = course(found, "Kriging + DE", 2, 1)  # no budget: the most that any run took on its instance
    assert killed.costs.tolist() == [1, 20]


def test_what_was_not_done_or_has_no_known_maximum_is_left_out_and_counted(found, plan):
    assert found.n_left_out == 3 and len(found.courses) == len(plan.runs) - 3
    assert not [each for each in found.courses if each.place.algorithm == "CMA-ES" and each.place.instance == 2]


def test_numbers_are_told(found):
    table = found.instances.drop(columns="settings").to_numpy().tolist()
    assert table == [[1, "three_disk", 1, 2], [1, "three_disk", 2, 2], [2, "rk4", 1, 3]]
    assert json.loads(found.instances["settings"][1])["measurement"]["relative"] == 0.1


def test_methods_of_one_name_on_the_same_data_are_told_apart(plan):
    """Another budget of one label is another method; another seed is another draw of the same."""
    twice = tuple(
        dataclasses.replace(plan.cells[0], place={**plan.cells[0].place, **place}, seed=place["seed"])
        for place in ({"samples": 40, "seed": 0}, {"samples": 70, "seed": 0}, {"samples": 40, "seed": 1})
    )
    axes = (*plan.axes, "seed")
    own = dataclasses.replace(plan, axes=axes, cells=twice, runs=all_runs(twice, 1, plan.versions))
    told = courses(own, {run.key: traced([1], [2.0]) for run in own.runs}, {}).courses
    names = ["Kriging + DE, samples 40", "Kriging + DE, samples 70", "Kriging + DE, samples 40"]
    assert [each.place.algorithm for each in told] == names


def test_ioh_tables_are_the_courses_to_the_last_digit(found, tmp_path):
    write_ioh(found, tmp_path)
    for algorithm, folder in (("Kriging + DE", "Kriging_DE"), ("CMA-ES", "CMA-ES")):
        meta = json.loads((tmp_path / folder / "IOHprofiler_f1_three_disk.json").read_text())
        [scenario] = meta["scenarios"]
        assert (meta["algorithm"]["name"], meta["function_id"], meta["maximization"]) == (algorithm, 1, False)
        assert scenario["dimension"] == 2 and meta["attributes"][:2] == HEADER[:2] == ["evaluations", "raw_y"]
        tables = (tmp_path / folder / scenario["path"]).read_text().split(" ".join(HEADER) + "\n")[1:]
        mine = [each for each in found.courses if each.place.algorithm == algorithm and each.place.function == 1]
        assert len(tables) == len(mine) == len(scenario["runs"])
        for text, run, each in zip(tables, scenario["runs"], mine):
            rows = np.array([[float(value) for value in row.split()] for row in text.splitlines()])
            np.testing.assert_array_equal(rows, each.values)
            assert (run["instance"], run["evals"]) == (each.place.instance, each.costs[-1])
            assert run["best"]["y"] == each.excess.min() and run["repetition"] == each.repetition
    assert (tmp_path / "CMA-ES" / "data_f2_rk4" / "IOHprofiler_f2_DIM3.dat").is_file()


def test_coco_archives_have_an_index_and_tables_of_all_runs(found, tmp_path):
    write_coco(found, tmp_path)
    with tarfile.open(tmp_path / "Kriging_DE.tar.gz") as archive:
        texts = {entry.name: archive.extractfile(entry).read().decode() for entry in archive}
    table = "Kriging_DE/data_f1/bbobexp_f1_DIM2"
    assert set(texts) == {f"{table}.dat", f"{table}.tdat", "Kriging_DE/bbobexp_f1.info"}
    head, comment, runs = texts["Kriging_DE/bbobexp_f1.info"].splitlines()
    assert head == "funcId = 1, DIM = 2, Precision = 1.000e-08, algId = 'Kriging_DE'" and comment.startswith(
        "% contest"
    )
    assert runs.split(", ") == [
        "data_f1/bbobexp_f1_DIM2.dat",
        "1:20|1.0e+00",
        "2:1|7.0e+00",
        "1:20|1.0e-08",
        "2:20|3.0e+21",
    ]
    blocks = [block.splitlines() for block in texts[f"{table}.dat"].split("%")[1:]]
    rows = [[float(value) for value in row.split()] for row in blocks[2][1:]]
    assert [row[0] for row in rows] == [1, 20] and rows[0][2] == pytest.approx(50.0)
    assert rows[1][2] == PRECISION  # an excess below zero: nothing is left to be found


@needs_readers
def test_iohinspector_reads_the_courses(found, tmp_path):
    write_ioh(found, tmp_path)
    read = pd.DataFrame(
        read_by("ioh", tmp_path),
        columns=["algorithm", "family", "unknowns", "instance", "run", "evals", "best", "cost", "excess", "error"],
    )
    assert len(read) == sum(len(each.values) for each in found.courses)
    for (algorithm, family), rows in read.groupby(["algorithm", "family"]):
        mine = [each for each in found.courses if (each.place.algorithm, each.place.family) == (algorithm, family)]
        for number, each in enumerate(mine, 1):
            run = rows[rows["run"] == number]
            np.testing.assert_array_equal(run[["cost", "excess", "error"]].to_numpy(float), each.values[:, :3])
            assert set(run["instance"]) == {each.place.instance} and set(run["evals"]) == {int(each.costs[-1])}


@needs_readers
def test_cocopp_finds_the_same_running_times(found, tmp_path):
    write_coco(found, tmp_path)
    read = read_by("coco", tmp_path)
    instances, ends, table = read["Kriging_DE.tar.gz f1 2"]
    mine = [each for each in found.courses if each.place.algorithm == "Kriging + DE"]
    assert instances == [each.place.instance for each in mine] and ends == [each.costs[-1] for each in mine]
    for target, *times in table:
        for each, time in zip(mine, times):
            reached = each.costs[np.maximum(each.excess, PRECISION) <= target * (1 + 1e-9)]
            assert time == reached[0] if len(reached) else np.isnan(time)
    assert "CMA-ES.tar.gz f2 3" in read


def read_by(reader, folder):
    """Apart from this process: importing cocopp asks its web site for archives, and keeps them in the home folder."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {"HOME": str(folder)}
    words = [str(PYTHON), str(READER), reader, str(folder)]
    read = subprocess.run(words, check=False, capture_output=True, text=True, timeout=200, env=environment)
    assert read.returncode == 0, read.stderr[-2000:]
    return json.loads(read.stdout.splitlines()[-1])


def test_the_command_writes_what_the_records_have(enter, cheapest):
    """Into the folder of the results, or another one; what is there stays."""
    words = ["workers=1", "repetitions=1", "measurement.relative=0.1", "optimizer=de,pso"]
    ended = enter(*cheapest, *words)
    for asked, file in (("ioh", "ksmea_none_pso/IOHprofiler_f1_three_disk.json"), ("coco", "ksmea_none_pso.tar.gz")):
        done = enter("export", asked, "run")
        assert done.code == 0 and "2 runs (algorithms: 2, instances: 1)" in done.out, done.err
        assert (ended.output / asked / file).is_file() and (ended.output / asked / "instances.csv").is_file()
    assert enter("export", "csv", "run", "--out", "table").code == 0
    rows = pd.read_csv(ended.output.parents[1] / "table" / "courses.csv")
    plan = read_plan(ended.output)
    for run, (_, mine) in zip(plan.runs, rows.groupby("algorithm")):  # de stands before pso in both
        trace = read_traces(plan, ended.output)[run.key]
        told = mine.iloc[: len(trace.trace.misfit)]
        np.testing.assert_allclose(told["excess"], trace.excess, rtol=1e-9)  # ten digits are written
        np.testing.assert_allclose(told["error"], trace.error, rtol=1e-9)
        assert mine["cost"].iloc[-1] == trace.evaluations + 2 * trace.jacobians
    refused = enter("export", "csv", "run", "--out", "table")
    assert refused.code == 2 and "expected no table yet" in refused.err
    for wrong, told in (
        (["xml", "run"], "unknown format of export: 'xml'"),
        (["ioh"], "a format and a folder of results, as ioh contest, got ioh"),
        (["mesurement"], "did you mean 'measurement'"),
    ):
        done = enter("export", *wrong)
        assert done.code == 2 and told in done.err and len(done.err.splitlines()) == 1


@pytest.mark.parametrize(
    "study, told", [("identify", "traces above a known maximum, got none"), ("diagnose", "records of another study")]
)
def test_an_experiment_without_traces_is_refused_in_one_line(study, told, plan, enter, tmp_path):
    cells = tuple(
        dataclasses.replace(each, settings={**each.settings, "study": {"name": study}}) for each in plan.cells
    )
    runs = all_runs(cells, 1, plan.versions)
    write_plan(dataclasses.replace(plan, cells=cells, runs=runs), tmp_path / "results" / "contest")
    done = enter("export", "ioh", "contest")
    assert done.code == 2 and told in done.err and len(done.err.splitlines()) == 1
    assert not (tmp_path / "results" / "contest" / "ioh").exists()
