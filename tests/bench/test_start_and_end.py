"""How an experiment says what goes on, and how it ends: full disks, too many workers, SIGTERM, progress where nobody looks at a terminal."""

import errno
import io
import os
import signal
import subprocess
import sys
import time

import pytest

from bench import main
from bench.jobs import progress
from bench.jobs.progress import EVERY, Lines, experiment_log, progress_bar


def test_a_log_on_a_full_disk_says_nothing(tmp_path, capsys, monkeypatch):
    """The records say what happened, and that the disk is full; a log that fails has no traceback of logging's own."""

    def full(self, record):
        raise OSError(errno.ENOSPC, "No space left on device")

    with experiment_log(tmp_path, "mine", 0) as log:
        [handler] = log.handlers
        log.info("first")
        monkeypatch.setattr(type(handler), "format", full, raising=False)
        log.info("second")
    assert capsys.readouterr().err == ""
    assert "first" in (tmp_path / "mine.log").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("limit", ["-n 32", "-n 48"])
def test_too_many_workers_for_the_limits_of_the_system(limit, tmp_path):
    words = ["method=direct", "optimizer=random_search", "study.intervals=none", "repetitions=40", "workers=40"]
    command = ["bash", "-c", f'ulimit {limit}; exec "$@"', "bash", sys.executable, "-m", "bench", *words]
    ended = subprocess.run(command, check=False, cwd=tmp_path, capture_output=True, text=True, timeout=200)
    assert ended.returncode == 2 and ended.stderr.count("\n") == 1, ended.stderr
    assert ended.stderr.startswith("error: workers: expected fewer workers with at most ")
    command[-1] = ended.stderr.partition("give ")[2].partition(",")[0]
    again = subprocess.run(command, check=False, cwd=tmp_path, capture_output=True, text=True, timeout=200)
    assert again.returncode == 0, again.stderr


def test_an_error_of_the_system_asks_for_fewer_workers(monkeypatch, capsys):
    def fails(words):
        raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    monkeypatch.setattr(main, "_experiment", fails)
    assert main.run(["samples=40"]) == 1
    assert "with fewer workers, such as workers=2" in capsys.readouterr().err


@pytest.mark.slow
def test_sigterm_leaves_the_word_that_ctrl_c_leaves(quick, start, tmp_path):
    process = start([*quick, "repetitions=20", "workers=1"], tmp_path)
    records = tmp_path / "results" / "table3" / "records" / "batch-0000.jsonl"
    deadline = time.monotonic() + 60
    while not (records.exists() and '"result"' in records.read_text()):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 143
    assert err.splitlines()[-1] == "interrupted: finished runs are kept, the same command does the rest"


def test_a_line_a_minute_into_a_file(monkeypatch, capsys):
    clock = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    with progress_bar("mine", 100) as bar:
        assert isinstance(bar, Lines)
        for _ in range(10):
            clock[0] += 15.0
            bar.update()
        clock[0] += 61.0
        bar.tick()
        clock[0] += 1.0
        bar.tick()
    assert capsys.readouterr().err.splitlines() == [
        "mine: 4 of 100 runs after 1 min, about 24 min left",
        "mine: 8 of 100 runs after 2 min, about 23 min left",
        "mine: 10 of 100 runs after 4 min, about 32 min left",
    ]
    assert EVERY == 60


def test_a_short_run_or_a_quiet_one_prints_no_line(monkeypatch, capsys):
    clock = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    with progress_bar("mine", 2) as bar:
        clock[0] += 59.0
        bar.update()
    monkeypatch.setenv("BENCH_QUIET", "1")
    with progress_bar("mine", 2) as bar:
        clock[0] += 1000.0
        bar.update()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("columns", "is_bar"), [(80, True), (0, False)])
def test_a_terminal_without_a_size_gets_lines_too(columns, is_bar, monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

        def fileno(self):
            return 2

    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setattr(os, "get_terminal_size", lambda number: os.terminal_size((columns, columns // 3)))
    with progress_bar("mine", 3) as bar:
        assert isinstance(bar, Lines) is not is_bar
