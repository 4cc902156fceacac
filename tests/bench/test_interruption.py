"""Ctrl-C and SIGKILL in the middle of an experiment: finished runs are kept, the same command does the rest."""

import os
import shutil
import signal
import time
from pathlib import Path

import pandas as pd
import pytest

RUNS = 8
ATTEMPTS = 5


@pytest.fixture
def interrupted(tmp_path, quick, start, heeds_sigint):
    """Start the experiment that `table3` did undisturbed, in a session of its own; signal all of it once a run is done."""

    def call(number):
        for _ in range(ATTEMPTS):
            process = start([*quick, "repetitions=4", "workers=1"], tmp_path)
            record_file = tmp_path / "results" / "table3" / "records" / "batch-0000.jsonl"
            try:
                wait_for_a_result(record_file, process)
                os.killpg(process.pid, number)
                out, err = process.communicate(timeout=30)
            finally:
                if process.poll() is None:
                    os.killpg(process.pid, signal.SIGKILL)
            wait_for_the_end_of_the_group(process.pid)
            if results_in(record_file) < RUNS:
                return process.returncode, out, err, record_file
            shutil.rmtree(tmp_path / "results")  # on a busy machine all runs were done before the signal was sent
        raise AssertionError(f"the experiment ended before the signal in each of {ATTEMPTS} attempts")

    return call


def wait_for_a_result(record_file, process):
    deadline = time.monotonic() + 60
    while results_in(record_file) < 1:
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.005)


def results_in(record_file):
    return record_file.read_text().count('"event": "result"') if record_file.exists() else 0


def wait_for_the_end_of_the_group(group):
    deadline = time.monotonic() + 20
    while is_alive(group):
        assert time.monotonic() < deadline, "processes of the experiment go on"
        time.sleep(0.02)


def is_alive(group):
    """Whether a process of the group runs; one that has ended and that nobody has asked about yet does not."""
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, of_group = status.read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue
        if int(of_group) == group and state not in "ZX":
            return True
    return False


def assert_completed_as_undisturbed(ended, table3, kept):
    assert ended.code == 0, ended.err
    assert ended.records().startswith(kept)
    assert len(ended.events()) == RUNS and len({event["key"] for event in ended.events()}) == RUNS  # none done twice
    table, whole = ended.table(), table3.table()
    pd.testing.assert_frame_equal(
        table[table["parameter"] != "time"], whole[whole["parameter"] != "time"], check_exact=True
    )
    runs, all_runs = (
        frame.loc[:, ~frame.columns.str.startswith(("time", "interval_seconds"))]
        for frame in (ended.runs(), table3.runs())
    )
    pd.testing.assert_frame_equal(runs, all_runs, check_exact=True)


def test_ctrl_c_keeps_what_is_finished_and_the_next_call_does_the_rest(interrupted, table3, quick, enter):
    code, out, err, record_file = interrupted(signal.SIGINT)
    assert code == 130
    assert "Traceback" not in err + out
    assert err.splitlines()[-1].startswith("interrupted: finished runs are kept")
    kept = record_file.read_text()
    assert 1 <= results_in(record_file) < RUNS
    assert kept.endswith("\n")
    ended = enter(*quick, "repetitions=4", "workers=2", output="results/table3")
    assert_completed_as_undisturbed(ended, table3, kept)


@pytest.mark.slow
def test_sigkill_keeps_what_is_finished_and_the_next_call_does_the_rest(interrupted, table3, quick, enter):
    code, _, _, record_file = interrupted(signal.SIGKILL)
    assert code == -signal.SIGKILL
    kept = record_file.read_text()
    assert 1 <= results_in(record_file) < RUNS
    ended = enter(*quick, "repetitions=4", "workers=2", output="results/table3")
    assert_completed_as_undisturbed(ended, table3, kept)


@pytest.mark.slow
def test_a_second_call_into_the_same_output_is_refused(tmp_path, enter, quick, start):
    first = start([*quick, "repetitions=4", "workers=1"], tmp_path)
    record_file = tmp_path / "results" / "table3" / "records" / "batch-0000.jsonl"
    try:
        wait_for_a_result(record_file, first)
        os.killpg(first.pid, signal.SIGSTOP)
        before = record_file.read_bytes()
        second = enter(*quick, "repetitions=4")
    finally:
        os.killpg(first.pid, signal.SIGKILL)
        first.communicate()
    assert second.code == 2
    [line] = second.err.splitlines()
    assert line.startswith("error: ") and "another process is working there" in line
    assert record_file.read_bytes() == before
