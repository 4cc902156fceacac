"""Workers that no run needs share the runs that there are."""

import dataclasses
import os
import signal

import pytest

from bench.jobs.claims import deal
from bench.jobs.work import Job, work
from bench.plan.plan import write_plan
from bench.reports.collect import draw
from ksmea.numerics.parallel import cpu_seconds, for_each


@pytest.mark.parametrize(("n_run", "workers", "each"), [(1, 4, 4), (2, 5, 2), (3, 2, 1), (8, 8, 1)])
def test_each_run_may_use_what_is_left_when_all_have_a_worker(plan, n_run, workers, each, tmp_path, monkeypatch):
    given = []

    def run_tasks(function, tasks, n_worker, *others):
        for task in tasks:
            *_, each_worker, _ = task.arguments
            given.append((n_worker, each_worker))
            yield task.task, {"status": "done"}

    monkeypatch.setattr("bench.jobs.work.require_planned_code", lambda plan: None)
    monkeypatch.setattr("bench.jobs.work.run_tasks", run_tasks)
    write_plan(dataclasses.replace(plan, runs=plan.runs[:n_run]), tmp_path)
    deal(tmp_path, [run.key for run in plan.runs[:n_run]], 1)
    work(Job(tmp_path, workers=workers))
    assert given == [(min(n_run, workers), each)] * n_run


def test_cpu_time_counts_what_others_have_done_of_the_work():
    def busy(_):
        start = sum(os.times()[:2])
        while sum(os.times()[:2]) - start < 0.2:
            pass

    start = cpu_seconds()
    for_each(busy, range(2), 2)
    assert cpu_seconds() - start >= 0.4 - 0.02  # the clock ticks in hundredths of a second


class TwoWords(Exception):
    """One that no other process can make again from what it says."""

    def __init__(self, one, other):
        super().__init__(f"{one} {other}")


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("fault", ["raises", "dies"])
def test_a_figure_that_cannot_be_drawn_costs_no_other(fault, workers, tmp_path, monkeypatch, capsys):
    caller = os.getpid()

    def bad():
        if fault == "dies" and os.getpid() != caller:
            os.kill(os.getpid(), signal.SIGKILL)
        raise TwoWords("no", "room")

    monkeypatch.setattr("bench.reports.collect.available_cores", lambda: workers)
    (tmp_path / "bad.png").write_bytes(b"of another table")
    drawings = {"a.png": lambda: b"a", "bad.png": bad, "c.png": b"c"}
    assert draw(lambda: drawings, tmp_path) == ({"a.png": b"a", "c.png": b"c"}, False)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "c.png"]
    assert "bad.png: cannot be drawn (TwoWords: no room)" in capsys.readouterr().err
