"""`status`, `explain` and `collect`: what they make of plan and records, and that they run nothing."""

import dataclasses
import json
import shutil

import pytest

from bench.commands import explain as commands
from bench.jobs.lines import SCHEMA
from bench.jobs.records import RecordWriter
from bench.plan.plan import all_runs, read_plan, write_plan
from bench.plan.provenance import code_digest, library_versions, platform_name, used_modules

STATES = ["done", "budget", "error", "timeout", None, "stale", "missing", "missing"]  # None: started and no more
TRACEBACK = "Traceback (most recent call last):\n  File \"mine.py\", line 3\nKeyError: 'no such thing'"


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "results" / "table3"


@pytest.fixture
def plan(plan):
    """The plan made by hand, of the code and the libraries that are here."""
    versions = library_versions()
    cells = tuple(dataclasses.replace(cell, code=code_digest(used_modules(cell.settings))) for cell in plan.cells)
    return dataclasses.replace(plan, cells=cells, versions=versions, runs=all_runs(cells, 4, versions))


def test_status_knows_results_of_code_that_is_no_longer_installed(plan, folder, enter):
    cells = tuple(dataclasses.replace(cell, code="0lder") for cell in plan.cells)
    older = dataclasses.replace(plan, cells=cells, runs=all_runs(cells, 4, plan.versions))
    write_plan(older, folder)
    with RecordWriter(folder, 0, older) as writer:
        for run in older.runs[:5]:
            writer.result(run, {"status": "done"})
    ended = enter("status", "table3")
    assert counts_of(ended) == {"planned": 8, "done": 0, "failed": 0, "stale": 5, "missing": 3} and ended.code == 1


@pytest.fixture
def eight(plan, folder):
    """The eight runs of the plan made by hand, each in another state."""
    write_plan(plan, folder)
    with RecordWriter(folder, 0, plan) as writer:
        for run, state in zip(plan.runs, STATES):
            if state == "stale":
                run = dataclasses.replace(run, key="0" * 16)
            if state != "missing":
                writer.started(run)
            if state not in (None, "missing"):
                writer.result(run, {"status": "done" if state == "stale" else state})
    return plan.runs


def counts_of(ended):
    """Counts that `status` prints, by their labels."""
    words = [line.split() for line in ended.out.splitlines()[1:]]
    return {label: int(count) for label, count, *_ in words}


@pytest.mark.parametrize("place", ["table3", "results/table3"])
def test_status_counts_every_state(place, eight, enter):
    ended = enter("status", place)
    assert ended.code == 1 and ended.err == ""
    assert counts_of(ended) == {"planned": 8, "done": 2, "interrupted": 1, "failed": 2, "stale": 1, "missing": 2}
    assert ended.out.splitlines()[0] == "table3 in results/table3"
    assert "(1 budget)" in ended.out and "(1 error, 1 timeout)" in ended.out


def test_status_of_what_is_all_done_is_a_success(plan, folder, enter):
    write_plan(plan, folder)
    with RecordWriter(folder, 0, plan) as writer:
        for run in plan.runs:
            writer.result(run, {"status": "done"})
    ended = enter("status", "table3")
    assert (ended.code, counts_of(ended)["done"], counts_of(ended)["missing"]) == (0, 8, 0)


def test_a_failure_of_other_code_is_no_stale_answer(plan, folder, enter):
    write_plan(plan, folder)
    with RecordWriter(folder, 0, plan) as writer:
        writer.result(dataclasses.replace(plan.runs[0], key="0" * 16), {"status": "error"})
    assert counts_of(enter("status", "table3")) == {"planned": 8, "done": 0, "failed": 0, "stale": 0, "missing": 8}


def test_status_and_explain_write_and_run_nothing(eight, enter, folder):
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    enter("status", "table3")
    for run in eight:
        assert enter("explain", run.key).code == 0
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


@pytest.fixture(scope="module")
def done(apart, cheapest, tmp_path_factory):
    """Two runs done by the bench itself."""
    ended = apart(*cheapest, "repetitions=2", cwd=tmp_path_factory.mktemp("done"), output="results/run")
    assert ended.code == 0, ended.err
    return ended


@pytest.fixture
def real(done, tmp_path):
    """A copy of them whose records a test may change."""
    return dataclasses.replace(done, output=shutil.copytree(done.output, tmp_path / "results" / "run"))


def rewrite_records(ended, change):
    """Every line of the record file as `change` has it."""
    path = ended.output / "records" / "batch-0000.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    lines = [change({name: line[name] for name in line if name != "crc32"}) for line in lines]  # as of an older version
    path.write_text("".join(json.dumps(line) + "\n" for line in lines if line is not None))


@pytest.mark.slow
def test_explain_a_run_that_is_done(real, enter):
    run = read_plan(real.output).runs[1]
    ended = enter("explain", run.key)
    assert (ended.code, ended.err) == (0, "")
    first, *rest = ended.out.splitlines()
    assert first == f"run {run.key} of run in results/run: samples=25, seed 0, repetition 1"
    shown = {line.split()[0]: line for line in rest}
    assert shown["method:"].split()[1] == "ksmea," and "max_updates=1," in shown["method:"]
    assert shown["optimizer:"].split()[1] == "de," and "population=5," in shown["optimizer:"]
    assert rest[-1] == f"done on {platform_name()}"


def test_explain_a_run_by_the_beginning_of_its_key(real, enter):
    run = read_plan(real.output).runs[1]
    assert enter("explain", run.key[:6]).out == enter("explain", run.key, "run").out


def test_explain_a_failed_run_shows_its_traceback_and_all_attempts(real, enter):
    plan = read_plan(real.output)
    failure = {"status": "error", "error": "KeyError: 'no such thing'", "traceback": TRACEBACK}
    run = plan.runs[0]

    def failed(line):
        return {**line, **failure} if line["event"] == "result" and line["key"] == run.key else line

    rewrite_records(real, failed)
    with RecordWriter(real.output, 0, plan) as writer:
        writer.result(run, {"status": "timeout", "error": "the run did not end within 2 s"})
        writer.result(run, failure)
    ended = enter("explain", run.key)
    assert ended.code == 0
    assert "error: KeyError: 'no such thing'\n" in ended.out
    assert TRACEBACK in ended.out
    assert "3 attempts: error, timeout, error" in ended.out


def test_explain_a_run_that_was_started_and_no_more(real, enter):
    run = read_plan(real.output).runs[0]
    rewrite_records(real, lambda line: None if line["event"] == "result" else line)
    assert "interrupted: it was stopped before its end" in enter("explain", run.key).out


def test_explain_a_run_that_is_missing(real, enter):
    one, two = read_plan(real.output).runs
    rewrite_records(real, lambda line: None if line.get("key") == one.key else line)
    assert enter("explain", one.key).out.splitlines()[-1] == "missing: no attempt was made"
    assert enter("explain", two.key).out.splitlines()[-1] == f"done on {platform_name()}"


@pytest.mark.parametrize(
    "part, name, expected",
    [
        ("modules", "optimizers.de", "changed since: optimizers.de"),
        ("versions", "scipy", "changed since: scipy 0.1 → "),
    ],
)
def test_explain_a_stale_run_names_what_has_changed(part, name, expected, real, enter):
    """As if an older session had answered, before a module or a library changed."""
    run = read_plan(real.output).runs[0]

    def older(line):
        if line["event"] == "session":
            assert name in line[part]
            return {**line, part: {**line[part], name: "0.1"}, "commit": "0lder"}
        return {**line, "key": "0" * 16} if line["key"] == run.key else line

    rewrite_records(real, older)
    assert counts_of(enter("status", "run"))["stale"] == 1
    last = enter("explain", run.key).out.splitlines()[-1]
    assert last.startswith("stale: answered on ") and "at commit 0lder; " in last and expected in last
    others = set(read_plan(real.output).modules) - {name}
    assert not any(f"{other};" in last or last.endswith(other) for other in others)


@pytest.mark.parametrize(
    "function, changed, expected",
    [
        ("library_versions", {"numpy": "99.0"}, "numpy "),
        ("used_modules", {"problems.three_disk": "edited"}, "problems.three_disk"),
    ],
)
def test_explain_says_what_has_changed_since_the_plan(function, changed, expected, real, enter, monkeypatch):
    now = getattr(commands, function)
    run = read_plan(real.output).runs[0]
    assert "since it was planned" not in enter("explain", run.key).out
    monkeypatch.setattr(commands, function, lambda *arguments: {**now(*arguments), **changed})
    last = enter("explain", run.key).out.splitlines()[-1]
    assert last.startswith("since it was planned these have changed") and expected in last
    assert last.count(";") == 0  # that one alone


@pytest.mark.parametrize(
    "words, expected",
    [
        (["status", "tabel3"], "unknown results 'tabel3'; did you mean 'table3'? known: table3"),
        (["collect", "tabel3"], "unknown results 'tabel3'; did you mean 'table3'?"),
        (["explain", "0123", "tabel3"], "unknown results 'tabel3'; did you mean 'table3'?"),
        (["explain", "xyz"], "explain: expected the key of a planned run, found no 'xyz' in results/table3; runs.csv"),
        (["explain"], "explain: expected the key of a run (see runs.csv), got nothing"),
        (["status"], "status: expected one name or folder of results, got none"),
        (["status", "table3", "table4"], "status: expected one name or folder of results, got 2"),
    ],
)
def test_what_is_not_there_is_one_line_with_the_nearest(words, expected, eight, enter):
    ended = enter(*words)
    assert (ended.code, ended.out) == (2, "")
    [line] = ended.err.splitlines()
    assert line.startswith(f"error: {expected}")


def test_collect_remakes_all_tables_from_plan_and_records_alone(table3, enter, tmp_path):
    folder = tmp_path / "results" / "table3"
    folder.joinpath("records").mkdir(parents=True)
    for name in ("plan.jsonl", "records/batch-0000.jsonl"):
        folder.joinpath(name).write_bytes((table3.output / name).read_bytes())
    ended = enter("collect", "table3", output="results/table3")
    assert ended.code == 0
    for name in ("table3.csv", "runs.csv"):
        assert (folder / name).read_bytes() == (table3.output / name).read_bytes()
    made = {path.name for path in folder.iterdir() if path.is_file()}
    assert {"table3.png", "table3_updates.png", "table3_response.png"} <= made
    assert ended.events() == table3.events() and ended.events("started") == table3.events("started")


def test_collect_fails_where_a_run_has_failed(real, enter):
    assert enter("collect", "run").code == 0
    run = read_plan(real.output).runs[0]

    def failed(line):
        is_result = line["event"] == "result" and line["key"] == run.key
        return {**line, "status": "error", "error": "ValueError: singular"} if is_result else line

    rewrite_records(real, failed)
    (real.output / "run.csv").unlink()
    ended = enter("collect", "run")
    assert ended.code == 1 and "1 of 2 failed (1 × error: ValueError: singular)" in ended.out
    assert ended.table("run")["failed"].eq(1).all()


@pytest.mark.slow
def test_commands_reach_the_experiments_that_one_includes(real, enter, cheapest):
    ended = enter("+experiment=paper", "includes=[table3,table4]", *cheapest, "repetitions=1", output="results/paper")
    assert ended.code == 0, ended.err
    printed = enter("status", "paper").out
    assert "table3 in results/paper/table3" in printed and "table4 in results/paper/table4" in printed
    run = read_plan(ended.output / "table4").runs[0]
    assert f"run {run.key} of table4 in results/paper/table4" in enter("explain", run.key).out
    (ended.output / "paper.csv").unlink()
    again = enter("collect", "paper", output="results/paper")
    assert again.code == 0 and set(again.table("paper")["table"]) == {"table3", "table4"}
    (ended.output / "table3" / "records" / "batch-0000.jsonl").unlink()
    assert enter("status", "paper").code == enter("collect", "paper").code == 1


def as_schema_1(line):
    """Line as it was before there were questions and sessions."""
    if line["event"] == "session":
        return None
    return {**{key: value for key, value in line.items() if key not in ("question", "session")}, "schema": 1}


def test_records_of_the_first_schema_stay_readable(real, enter, cheapest):
    runs = real.runs()
    rewrite_records(real, as_schema_1)
    assert '"question"' not in real.records() and '"schema": 1' in real.records()
    assert (enter("status", "run").code, counts_of(enter("status", "run"))["done"]) == (0, 2)
    assert enter("explain", runs["key"][0]).out.splitlines()[-1] == "done"
    (real.output / "runs.csv").unlink()
    assert enter("collect", "run").code == 0 and real.runs().equals(runs)
    kept = real.records()
    assert enter(*cheapest, "repetitions=2").records() == kept  # and nothing is computed again


@pytest.mark.parametrize("words", [["status", "run"], ["collect", "run"], ["explain", "KEY", "run"]])
def test_records_of_a_newer_schema_are_refused_in_one_line(words, real, enter):
    rewrite_records(real, lambda line: {**line, "schema": SCHEMA + 1})
    key = read_plan(real.output).runs[0].key
    ended = enter(*[key if word == "KEY" else word for word in words])
    assert (ended.code, ended.out) == (2, "")
    [line] = ended.err.splitlines()
    assert line.startswith("error: ") and f"found {SCHEMA + 1}: a newer version wrote them" in line


def test_a_record_with_a_curve_that_is_not_finite_stays_readable(real, enter, cheapest):
    """As of a surrogate that predicts NaN somewhere; unread, its run would be done again at every call."""

    def without_a_value(line):
        return {**line, "curves": {**line["curves"], "predicted": [[float("nan")]]}} if line.get("curves") else line

    rewrite_records(real, without_a_value)
    kept = real.records()
    assert "NaN" in kept
    assert enter("status", "run").code == 0
    assert enter(*cheapest, "repetitions=2").records() == kept


def test_a_run_that_is_being_computed_is_not_a_failed_one(plan, folder, enter):
    """While its writer lives it is running; once the writer is gone it was interrupted."""
    write_plan(plan, folder)
    with RecordWriter(folder, 0, plan) as writer:
        writer.started(plan.runs[0])
        during = counts_of(enter("status", "table3"))
    after = counts_of(enter("status", "table3"))
    assert (during["running"], during["failed"], during["missing"]) == (1, 0, 7)
    assert "running" not in after and (after["interrupted"], after["failed"], after["missing"]) == (1, 0, 7)
