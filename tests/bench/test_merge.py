"""`merge`: parts of one experiment in one folder, as if all of it had been done there."""

import dataclasses
import json
import shutil

import pandas as pd
import pytest

from bench.jobs.claims import CLAIMS
from bench.jobs.records import RecordWriter, read_lines, read_records
from bench.plan.plan import all_runs, read_plan, write_plan
from bench.plan.provenance import code_digest, library_versions, used_modules

TIMES = ("time", "time_model", "time_surrogate", "time_search")


def written(folder, plan, ends):
    """A folder of a plan whose runs end so, by cell and repetition: a status, or a status with further content."""
    write_plan(plan, folder)
    with RecordWriter(folder, 0, plan) as writer:
        for run in plan.runs:
            end = ends.get((run.cell, run.repetition))
            if end is not None:
                writer.started(run)
                writer.result(run, {"status": end} if isinstance(end, str) else end)
    return folder


def of(plan, cells=None, repetitions=4, **changes):
    """The plan made by hand with some of its cells, repetitions, or otherwise changed."""
    plan = dataclasses.replace(plan, **{name: value for name, value in changes.items() if name != "seed"})
    cells = plan.cells if cells is None else tuple(plan.cells[number] for number in cells)
    if "seed" in changes:
        cells = tuple(dataclasses.replace(cell, seed=changes["seed"]) for cell in cells)
    return dataclasses.replace(plan, cells=cells, runs=all_runs(cells, repetitions, plan.versions))


@pytest.fixture
def merge(enter, tmp_path):
    def call(*folders, out="all"):
        return enter("merge", *map(str, folders), "--out", out, output=out)

    return call


def statuses(folder):
    """Status of each planned run that has a record, by samples and repetition."""
    plan, records = read_plan(folder), read_records(folder)
    return {
        (plan.cells[run.cell].place["samples"], run.repetition): records[run.key].status
        for run in plan.runs
        if run.key in records
    }


def test_the_merged_folder_is_that_of_the_whole_experiment(enter, merge, cheapest):
    """Merged runs are the ones of one command, in their order; a part without the axis is put on it."""
    words = [*cheapest, "workers=1", "repetitions=2", "method.polish=true"]  # which a comparison leaves out else
    whole = enter(*words, "optimizer=de,pso", "output=results/whole", output="results/whole")
    one = enter(*words, "output=results/one", output="results/one")
    other = enter(*words, "optimizer=pso", "output=results/other", output="results/other")
    assert [each.code for each in (whole, one, other)] == [0, 0, 0]
    merged = merge(one.output, other.output)
    assert merged.code == 0, merged.err
    assert "2 cells, 4 runs, 4 with a result" in merged.out
    collected = enter("collect", str(merged.output), output="all")
    assert collected.code == 0
    runs = [each.runs() for each in (whole, collected)]
    pd.testing.assert_frame_equal(*(frame.drop(columns=[*TIMES]) for frame in runs))
    # without an axis of its own a part has its setting there: both plans are the same but for where they were made
    assert read_plan(merged.output).cells == read_plan(whole.output).cells
    assert enter("status", "all").code == 0


def test_what_several_parts_have_is_there_once_and_what_failed_in_one_is_done_by_another(plan, merge, tmp_path):
    ends = {(0, 0): "done", (0, 1): "error", (1, 0): "done"}
    one = written(tmp_path / "one", plan, ends)
    two = written(tmp_path / "two", of(plan, [1, 0], 6), {(1, 1): "done", (0, 0): "error", (0, 5): "budget"})
    done = merge(one, two)
    assert done.code == 0, done.err
    assert statuses(done.output) == {(40, 0): "done", (40, 1): "done", (70, 0): "done", (70, 5): "budget"}
    merged = read_plan(done.output)
    assert [cell.place["samples"] for cell in merged.cells] == [40, 70]
    assert [(run.repetition, run.cell) for run in merged.runs] == [(n, cell) for n in range(6) for cell in (0, 1)]
    sessions = [line.session for line in read_lines(done.output) if not hasattr(line, "key")]
    assert len(sessions) == 2  # each keeps saying what code made its runs
    again = merge(done.output, two, one, out="again")
    assert statuses(again.output) == statuses(done.output)
    size = [sum(path.stat().st_size for path in (each.output / "records").glob("*")) for each in (done, again)]
    assert size[0] == size[1]  # merged a second time, a part adds nothing


def test_results_that_differ_by_more_than_times_are_told_and_the_first_is_kept(plan, merge, tmp_path):
    def ends(misfit, seconds):
        return {(0, 0): {"status": "done", "misfit": misfit, "trace": {"seconds": [seconds]}, "elapsed": seconds}}

    one = written(tmp_path / "one", plan, ends(1.0, 0.1))
    same = written(tmp_path / "same", plan, ends(1.0, 0.2))
    other = written(tmp_path / "other", plan, ends(1.5, 0.1))
    assert "differ by" not in merge(one, same, out="alike").out
    done = merge(one, other)
    key = plan.runs[0].key
    [line] = [line for line in done.out.splitlines() if "differ by more than times" in line]
    assert "1 of these differ" in line and key in line and str(other) in line
    assert read_records(done.output)[key].content()["misfit"] == 1.0


def test_parts_of_other_code_are_put_together_and_it_is_said(plan, merge, enter, tmp_path):
    """Their runs keep their keys, so that the one of the second part answers where the first has none."""
    one = of(plan, modules={"ksmea.problem.counted": "a", "ksmea.identification.ksmea": "c"})
    cells = tuple(dataclasses.replace(cell, code="0ther") for cell in plan.cells)
    two = of(plan, cells=None, commit="d0de", modules={"ksmea.problem.counted": "b"}, versions={"numpy": "2.1"})
    two = dataclasses.replace(two, cells=cells, runs=all_runs(cells, 4, two.versions))
    parts = written(tmp_path / "one", one, {(0, 0): "done"}), written(tmp_path / "two", two, {(0, 1): "done"})
    done = merge(*parts)
    told = "different code or libraries (commits c0de, d0de), which differ in numpy 2.0 and 2.1, ksmea.problem.counted"
    assert told in done.out and told in enter("status", "all").out
    merged = read_plan(done.output)
    keys = {(run.cell, run.repetition): run.key for run in merged.runs}
    assert keys[0, 0] == one.runs[0].key and keys[0, 1] == two.runs[2].key
    assert merged.commit == "c0de, d0de" and keys[0, 2] == one.runs[4].key


def test_of_merged_runs_those_of_other_code_than_is_installed_are_stale(plan, merge, enter, tmp_path):
    """Also where they are of the same cell: a run of the second part in a cell of the first."""
    cells = tuple(dataclasses.replace(cell, code=code_digest(used_modules(cell.settings))) for cell in plan.cells)
    here = dataclasses.replace(plan, cells=cells, versions=library_versions())
    here = dataclasses.replace(here, runs=all_runs(cells, 4, here.versions))
    done = merge(
        written(tmp_path / "here", here, {(0, 0): "done", (1, 0): "done"}),
        written(tmp_path / "older", plan, {(0, 1): "done"}),
    )
    states = {words[0]: int(words[1]) for words in map(str.split, enter("status", "all").out.splitlines()[1:6])}
    assert done.code == 0 and states == {"planned": 8, "done": 2, "failed": 0, "stale": 1, "missing": 5}


def test_another_seed_is_another_draw_told_apart_by_its_column(plan, merge, tmp_path):
    one, two = written(tmp_path / "one", plan, {(0, 0): "done"}), written(tmp_path / "two", of(plan, seed=7), {})
    merged = read_plan(merge(one, two).output)
    assert merged.axes == ("samples", "seed")
    assert [tuple(cell.place.values()) for cell in merged.cells] == [(40, 0), (70, 0), (40, 7), (70, 7)]


def with_first_cell(plan, **changes):
    cells = (dataclasses.replace(plan.cells[0], **changes), plan.cells[1])
    return dataclasses.replace(plan, cells=cells, runs=all_runs(cells, 4, plan.versions))


def with_another_truth(plan):
    kxx, u = plan.cells[0].parameters
    return with_first_cell(plan, parameters=(dataclasses.replace(kxx, truth=60e6), u))


REFUSED = {
    "another experiment": (lambda plan: dataclasses.replace(plan, name="mine"), "name=table3 in"),
    "another table": (
        lambda plan: dataclasses.replace(plan, report=dataclasses.replace(plan.report, table="settings")),
        "table=summary in",
    ),
    "other settings at the same place": (
        lambda plan: with_first_cell(plan, settings={"method": {"name": "ksmea", "budget": 9}, "samples": 40}),
        "method.budget=None",
    ),
    "another truth": (with_another_truth, "the same true values at samples=40"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_parts_that_cannot_be_compared_are_refused_in_a_line_that_says_why(case, plan, merge, tmp_path):
    changed, told = REFUSED[case]
    other = changed(plan)
    done = merge(written(tmp_path / "one", plan, {}), written(tmp_path / "two", other, {}))
    assert done.code == 2 and told in done.err and len(done.err.splitlines()) == 1, done.err
    assert str(tmp_path / "one") in done.err and str(tmp_path / "two") in done.err
    assert not done.output.exists()


def test_one_name_for_the_plugins_of_two_files_is_refused(plan, merge, tmp_path):
    parts = [
        dataclasses.replace(
            plan,
            plugins={"optimizer=mine": f"/{who}/mine.py"},
            modules={"file mine.py": digest, "ksmea.problem.counted": "a"},
        )
        for who, digest in (("ann", "1"), ("bob", "2"), ("cyd", "1"))
    ]
    ann, bob, cyd = (written(tmp_path / str(number), part, {}) for number, part in enumerate(parts))
    done = merge(ann, bob)
    assert done.code == 2 and "expected one file of optimizer=mine" in done.err
    assert merge(ann, cyd).code == 0  # the same file at another place; neither is there, and nothing asks for it


def test_folders_that_are_worked_in_or_are_there_are_left_alone(plan, merge, tmp_path):
    one, two = (written(tmp_path / name, plan, {(0, 0): "done"}) for name in ("one", "two"))
    with RecordWriter(two, 1, plan) as writer:
        writer.started(plan.runs[1])
        refused = merge(one, two)
        assert refused.code == 2 and f"jobs are at work in {two}" in refused.err
    kept = tmp_path / "all" / "kept"
    kept.mkdir(parents=True)
    refused = merge(one, two)
    assert refused.code == 2 and "choose another --out" in refused.err and [*kept.parent.iterdir()] == [kept]
    shutil.rmtree(kept.parent)
    assert merge(one, two).code == 0 and not (tmp_path / "all" / CLAIMS).exists()


def test_what_is_interrupted_leaves_nothing_half_written(plan, merge, tmp_path, monkeypatch):
    one, two = (written(tmp_path / name, plan, {(0, 0): "done"}) for name in ("one", "two"))

    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("bench.commands.merge.write_plan", interrupted)
    assert merge(one, two).code == 130
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "two"]


@pytest.mark.parametrize(
    "words, told",
    [
        (["one", "--out", "all"], "two folders of results or more"),
        (["one", "one"], "--out DIR"),
        (["one", "one", "--out"], "expected a value after --out"),
        (["one", "one", "--into", "all"], "unknown option of merge: '--into'"),
    ],
)
def test_words_that_cannot_be_done_are_refused_in_one_line(words, told, plan, enter, tmp_path):
    written(tmp_path / "one", plan, {})
    done = enter("merge", *words)
    assert done.code == 2 and told in done.err and len(done.err.splitlines()) == 1, done.err


def test_damaged_lines_and_stale_results_are_taken_along_as_they_are_read(plan, merge, tmp_path):
    """A torn line is no record and is left out; what other code has answered keeps answering as stale."""
    one = written(tmp_path / "one", plan, {(0, 0): "done"})
    with RecordWriter(one, 1, plan) as writer:
        writer.result(dataclasses.replace(plan.runs[1], key="0" * 16), {"status": "done"})
    with (one / "records" / "batch-0001.jsonl").open("ab") as file:
        file.write(json.dumps({"event": "result", "key": "torn"}).encode()[:-5])
    done = merge(one, written(tmp_path / "two", plan, {}))
    lines = [line.key for line in read_lines(done.output) if hasattr(line, "key")]
    assert lines == [plan.runs[0].key, plan.runs[0].key, "0" * 16]
