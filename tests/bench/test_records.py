"""Record files: what a reader makes of them, whatever became of their writers."""

import json
import subprocess
import sys

import pytest

from bench.jobs.lines import RESULTS
from bench.jobs.records import RecordWriter, finished_keys, read_records
from ksmea.errors import SettingError


@pytest.fixture
def file(tmp_path):
    return tmp_path / "records" / "batch-0000.jsonl"


def write(tmp_path, plan, *events, batch=0):
    """Events (run, None) for a start and (run, status) for a result, by a writer that ends in peace."""
    with RecordWriter(tmp_path, batch, plan) as writer:
        for run, status in events:
            if status is None:
                writer.started(run)
            else:
                writer.result(run, {"status": status, "answer": f"{status} of {run.key}"})


def statuses(tmp_path):
    return read_records(tmp_path, lambda line: line.status)


def test_a_result_is_read_as_it_was_written(tmp_path, plan):
    run = plan.runs[0]
    with RecordWriter(tmp_path, 0, plan) as writer:
        writer.started(run)
        writer.result(run, {"status": "done", "values": [0.1 + 0.2, 1e-300, None], "unit": "µm – \n“line”"})
    record = read_records(tmp_path)[run.key].content()
    assert record["values"] == [0.1 + 0.2, 1e-300, None] and record["unit"] == "µm – \n“line”"
    assert finished_keys(tmp_path) == {run.key}


def test_a_session_says_what_code_and_versions_compute(tmp_path, plan, file):
    write(tmp_path, plan, (plan.runs[0], None), (plan.runs[0], "done"), (plan.runs[1], None))
    write(tmp_path, plan, (plan.runs[1], None))
    lines = [json.loads(line) for line in file.read_text().splitlines()]
    sessions = [line for line in lines if line["event"] == "session"]
    assert len(sessions) == 2 and all(session["commit"] == "c0de" for session in sessions)
    assert all(session["versions"] == {"numpy": "2.0"} for session in sessions)
    first, second = (session["session"] for session in sessions)
    assert [line["session"] for line in lines] == [first] * 4 + [second] * 2
    assert all("\n" not in line and line["schema"] == lines[0]["schema"] for line in lines)


def test_a_line_is_read_with_the_processor_of_its_session_or_with_its_own(tmp_path, plan, monkeypatch):
    one, two = plan.runs[:2]
    for run, processor, own in ((one, "abacus", {}), (two, "slide rule", {"platform": "quipu"})):
        monkeypatch.setattr("bench.jobs.records.platform_name", lambda processor=processor: processor)
        with RecordWriter(tmp_path, 0, plan) as writer:
            writer.result(run, {"status": "done", **own})
    assert read_records(tmp_path, lambda line: line.platform) == {one.key: "abacus", two.key: "quipu"}


def test_a_writer_without_runs_leaves_nothing_to_read(tmp_path, plan):
    write(tmp_path, plan)
    assert read_records(tmp_path) == {}


def test_no_folder_is_no_records(tmp_path):
    assert read_records(tmp_path / "nowhere") == {} and finished_keys(tmp_path) == set()


def test_started_without_a_result_is_interrupted(tmp_path, plan):
    one, two = plan.runs[:2]
    write(tmp_path, plan, (one, None), (two, None), (two, "done"))
    assert statuses(tmp_path) == {one.key: "interrupted", two.key: "done"}
    assert "stopped before its end" in read_records(tmp_path)[one.key].error


def test_started_is_running_while_its_session_writes(tmp_path, plan):
    one, two = plan.runs[:2]
    write(tmp_path, plan, (one, None))  # by a session that has ended
    with RecordWriter(tmp_path, 0, plan) as writer:
        writer.started(two)
        assert statuses(tmp_path) == {one.key: "interrupted", two.key: "running"}
        writer.result(two, {"status": "error", "error": "singular"})
        assert statuses(tmp_path) == {one.key: "interrupted", two.key: "error"}


def test_every_length_of_a_torn_last_line_is_ignored_and_the_file_goes_on(tmp_path, plan, file):
    one, two, three = plan.runs[:3]
    write(tmp_path, plan, (one, "done"))
    whole = file.read_bytes()
    write(tmp_path, plan, (two, "done"))
    last = file.read_bytes().splitlines(keepends=True)[-1]
    for length in range(1, len(last) - 1, 7):
        file.write_bytes(whole + last[:length])
        assert statuses(tmp_path) == {one.key: "done"}
        write(tmp_path, plan, (three, "done"))
        assert statuses(tmp_path) == {one.key: "done", three.key: "done"}
        assert file.read_bytes().startswith(whole + last[:length])  # nothing is ever cut away
    file.write_bytes(whole + last[:-1])  # whole but for its end of line: a record
    write(tmp_path, plan, (three, "done"))
    assert statuses(tmp_path) == {one.key: "done", two.key: "done", three.key: "done"}


RUBBISH = [
    b"",
    b"not json",
    b'{"schema": 1, "event": "result", "key": "abc"',
    b"\xff\xfe\x00\x00 \x80",
    b"[1, 2]",
    b"null",
    b"17",
    b'"text"',
    b"{}",
    b'{"schema": 1, "event": "result", "key": "abc"}',
    b'{"schema": 1, "event": "party", "key": "abc"}',
    b'{"schema": "new", "event": "started", "key": "abc"}',
    b'{"event": "result", "key": "abc", "status": "done"}',
]


@pytest.mark.parametrize("rubbish", RUBBISH)
def test_rubbish_between_records_is_ignored(rubbish, tmp_path, plan, file):
    one, two = plan.runs[:2]
    write(tmp_path, plan, (one, "done"))
    with file.open("ab") as stream:
        stream.write(rubbish + b"\n")
    write(tmp_path, plan, (two, "done"))
    assert statuses(tmp_path) == {one.key: "done", two.key: "done"}


@pytest.mark.parametrize("result", RESULTS)
@pytest.mark.parametrize("failure", [None, "error", "timeout", "killed"])
def test_a_result_is_not_replaced_by_a_later_failure(result, failure, tmp_path, plan):
    run = plan.runs[0]
    write(tmp_path, plan, (run, None), (run, result))
    write(tmp_path, plan, (run, failure))
    write(tmp_path, plan, (run, failure), batch=1)
    assert read_records(tmp_path)[run.key].content()["answer"] == f"{result} of {run.key}"
    assert finished_keys(tmp_path) == {run.key}


@pytest.mark.parametrize("failure", ["error", "timeout", "killed"])
def test_a_failure_is_replaced_by_a_later_result(failure, tmp_path, plan):
    run = plan.runs[0]
    write(tmp_path, plan, (run, None), (run, failure))
    assert statuses(tmp_path) == {run.key: failure} and finished_keys(tmp_path) == set()
    write(tmp_path, plan, (run, None), (run, "done"))
    assert statuses(tmp_path) == {run.key: "done"}


def test_records_of_all_batches_are_read(tmp_path, plan):
    for batch, run in enumerate(plan.runs):
        write(tmp_path, plan, (run, "done"), batch=batch)
    assert len(list((tmp_path / "records").glob("*.jsonl"))) == len(plan.runs)
    assert finished_keys(tmp_path) == {run.key for run in plan.runs}


def test_a_second_writer_of_the_same_file_is_refused_in_one_line(tmp_path, plan, file):
    with RecordWriter(tmp_path, 0, plan) as writer:
        writer.started(plan.runs[0])
        before = file.read_bytes()
        with pytest.raises(SettingError, match="another process") as caught, RecordWriter(tmp_path, 0, plan):
            pass
        assert "\n" not in str(caught.value) and str(file.parent) in str(caught.value)
        assert file.read_bytes() == before
        with RecordWriter(tmp_path, 1, plan) as other:  # another batch has a file of its own
            other.started(plan.runs[1])
        writer.result(plan.runs[0], {"status": "done"})
    write(tmp_path, plan, (plan.runs[2], "done"))  # free again
    assert finished_keys(tmp_path) == {plan.runs[0].key, plan.runs[2].key}


def test_a_writer_in_another_process_is_refused_too(tmp_path, plan, file):
    code = "import sys; from pathlib import Path; from bench.storage.files import exclusive; exclusive(Path(sys.argv[1])).__enter__()"
    locks = [str(path) for path in _locks_while_writing(tmp_path, plan)]
    with RecordWriter(tmp_path, 0, plan):
        done = subprocess.run([sys.executable, "-c", code, *locks], check=False, capture_output=True, text=True)
    assert done.returncode == 1 and "SettingError" in done.stderr
    assert subprocess.run([sys.executable, "-c", code, *locks], check=False, capture_output=True).returncode == 0


def _locks_while_writing(tmp_path, plan):
    with RecordWriter(tmp_path, 0, plan):
        return list((tmp_path / "records").glob("*.lock"))


def test_records_of_a_newer_schema_are_refused_in_one_line(tmp_path, plan, file):
    write(tmp_path, plan, (plan.runs[0], "done"))
    with file.open("a") as stream:
        stream.write('{"schema": 999, "event": "started", "key": "abc"}\n')
    with pytest.raises(SettingError, match=r"found 999: a newer version wrote them") as caught:
        read_records(tmp_path)
    assert "\n" not in str(caught.value)


def test_a_reader_keeps_only_what_it_asks_for(tmp_path, plan):
    write(tmp_path, plan, (plan.runs[0], None), (plan.runs[1], "done"))
    assert read_records(tmp_path, lambda line: line.status.upper()) == {
        plan.runs[0].key: "INTERRUPTED",
        plan.runs[1].key: "DONE",
    }
