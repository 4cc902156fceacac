"""Workers that no run needs share the runs that there are."""

import dataclasses
import os

import pytest

from bench.jobs.claims import deal
from bench.jobs.work import Job, work
from bench.plan.plan import write_plan
from ksmea.processes import cpu_seconds, for_each


@pytest.mark.parametrize(("n_run", "workers", "each"), [(1, 4, 4), (2, 5, 2), (3, 2, 1), (8, 8, 1)])
def test_each_run_may_use_what_is_left_when_all_have_a_worker(plan, n_run, workers, each, tmp_path, monkeypatch):
    given = []

    def run_tasks(function, tasks, n_worker, *others):
        for run, arguments in tasks:
            given.append((n_worker, arguments[-1]))
            yield run, {"status": "done"}

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
