"""Folders of results that came from elsewhere: damaged plans and records, pipes and links, and what terminals must not get."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from bench.jobs.progress import experiment_log
from bench.jobs.records import finished_keys, read_records
from bench.plan.plan import read_plan
from bench.storage.files import is_held, remove_partial, replace_file
from ksmea.errors import SettingError
from ksmea.problem.journal import Journal
from ksmea.settings.regular_files import open_regular


@pytest.fixture
def folder(table3, tmp_path):
    return Path(shutil.copytree(table3.output, tmp_path / "table3"))


def change_plan(folder, line_type, change):
    """Change the first line of a type in the plan."""
    lines = [json.loads(line) for line in (folder / "plan.jsonl").read_text().splitlines()]
    change(next(line for line in lines if line["line"] == line_type))
    (folder / "plan.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))


def change_record(folder, change):
    """Change the first result; its key."""
    path = folder / "records" / "batch-0000.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    for line in lines:
        line.pop("crc32")  # as of an older version, whose lines may be any
    line = next(line for line in lines if line["event"] == "result")
    change(line)
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    return line["key"]


@pytest.mark.parametrize(
    ("line_type", "field", "value"),
    [
        ("plan", "versions", 1.5),
        ("plan", "name", "../../up"),
        ("plan", "name", "a\nb"),
        ("plan", "axes", [1]),
        ("plan", "report", []),
        ("cell", "settings", []),
        ("cell", "settings", {"study": {"level": "x"}}),
        ("cell", "place", {"samples": []}),
        ("cell", "parameters", [5]),
        ("cell", "parameters", [{"name": "k", "unit": "", "si_per_unit": 0, "truth": None}]),
        ("run", "cell", 99),
        ("run", "cell", "x"),
        ("run", "key", "../up"),
        ("run", "repetition", -1),
    ],
)
@pytest.mark.parametrize("command", ["collect", "status", "explain"])
def test_a_plan_with_a_field_of_another_type_is_refused_in_one_line(command, line_type, field, value, folder, enter):
    change_plan(folder, line_type, lambda line: line.update({field: value}))
    ended = enter(command, *(["0"] if command == "explain" else []), str(folder))
    assert ended.code == 2 and ended.err.count("\n") == 1 and "expected a plan of schema 2" in ended.err


CELLS = slice(1, 3)  # lines of the first two cells


def reversed_cells(lines):
    lines[CELLS] = lines[CELLS][::-1]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (reversed_cells, "is not of its cell"),
        (lambda lines: lines.insert(1, lines[2]), "is not of its cell"),
        (lambda lines: lines.__setitem__(1, re.sub(r'"seed": \d+', '"seed": 77', lines[1])), "is not of its cell"),
        (lambda lines: lines.pop(), "8 runs are planned, and 7 lines are of runs"),
        (lambda lines: lines.append(lines[-1]), "8 runs are planned, and 9 lines are of runs"),
    ],
)
def test_lines_of_a_plan_that_do_not_belong_together_are_refused(change, reason, folder, enter):
    """A number would stand beside the settings of another cell."""
    lines = (folder / "plan.jsonl").read_text().splitlines()
    assert [json.loads(line)["line"] for line in lines[CELLS]] == ["cell", "cell"]
    before = list(lines)
    change(lines)
    assert lines != before
    (folder / "plan.jsonl").write_text("\n".join(lines) + "\n")
    for command in ("collect", "status"):
        ended = enter(command, str(folder))
        assert ended.code == 2 and ended.err.count("\n") == 1 and reason in ended.err, ended.err


@pytest.mark.parametrize(
    "change",
    [
        lambda line: line.pop("parameters"),
        lambda line: line.update(parameters=5),
        lambda line: line.update(parameters=[]),
        lambda line: line.update(seconds="x"),
        lambda line: line.update(history=[{"x": [1.0]}]),
        lambda line: line["curves"].update(measured=[[1.0], [1.0, 2.0]]),
    ],
)
def test_a_result_that_its_study_cannot_read_is_none(change, folder, enter):
    key = change_record(folder, change)
    plan = read_plan(folder)
    line = read_records(folder, plan=plan)[key]
    assert line.status == "unreadable" and line.error.isprintable() and key not in finished_keys(folder, plan)
    ended = enter("status", str(folder))
    assert ended.code == 1 and "(1 unreadable)" in ended.out
    ended = enter("collect", str(folder))
    assert ended.code == 1 and "1 of 8 failed (1 × unreadable: " in ended.out and ended.err == ""


def test_what_cannot_be_read_is_done_again(enter, cheapest):
    done = enter("repetitions=2", "workers=1", *cheapest)
    key = change_record(done.output, lambda line: line.pop("parameters"))
    assert key not in finished_keys(done.output, read_plan(done.output))
    assert enter("repetitions=2", "workers=1", *cheapest).code == 0
    assert key in finished_keys(done.output, read_plan(done.output)) and enter("status", "run").code == 0


def test_no_control_characters_reach_the_terminal(folder, enter):
    change_plan(folder, "plan", lambda line: line["versions"].update({"\x1b[2J": "\x07"}))
    key = change_record(folder, lambda line: line.update(event="result", status="error", error="\x1b[31m\u202e\nb"))
    for words in (["status"], ["explain", key], ["collect"]):
        ended = enter(*words, str(folder))
        assert (ended.out + ended.err).replace("\n", "").isprintable()


@pytest.mark.parametrize("name", ["plan.jsonl", "records/batch-0000.jsonl", "records/batch-0000.lock", ".drawn"])
@pytest.mark.parametrize("file_type", ["pipe", "link"])
def test_pipes_and_links_are_refused(file_type, name, folder, tmp_path):
    path = folder / name
    path.unlink(missing_ok=True)
    target = tmp_path / "target"
    target.write_text("mine")
    os.mkfifo(path) if file_type == "pipe" else path.symlink_to(target)
    modes = ("rb", "ab", "w+b")
    for mode in modes:
        with pytest.raises(SettingError, match=f"expected a regular file, got a {file_type}; remove it"):
            open_regular(path, mode)
    if name.endswith(".lock"):
        with pytest.raises(SettingError, match="regular file"):
            is_held(path)
    elif name != ".drawn":
        with pytest.raises(SettingError, match="regular file"):
            read_records(folder, plan=read_plan(folder))
    assert target.read_text() == "mine"


def test_tables_logs_and_journals_are_not_written_through_links(folder, tmp_path):
    target = tmp_path / "target"
    target.write_text("mine")
    for name in ("table3.csv", "log.log", "journal"):
        (folder / name).unlink(missing_ok=True)
        (folder / name).symlink_to(target)
    replace_file(folder / "table3.csv", b"new")
    assert (folder / "table3.csv").read_bytes() == b"new" and not (folder / "table3.csv").is_symlink()
    with pytest.raises(SettingError, match="got a link"), experiment_log(folder, "log", 0):
        pass
    with pytest.raises(SettingError, match="got a link"):
        Journal(folder / "journal")
    assert target.read_text() == "mine"


def test_what_killed_processes_left_is_removed(folder, enter):
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    left, running = folder / f".table3.csv.{gone.pid}", folder / f".table3.csv.{os.getppid()}"
    other = folder / f".mine.{gone.pid}"
    for path in (left, running, other):
        path.write_text("x")
    assert enter("collect", str(folder)).code == 0
    assert not left.exists() and running.exists() and other.exists()
    remove_partial(folder)
    assert running.exists()
