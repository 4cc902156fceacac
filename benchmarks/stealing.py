"""Idle share of eight jobs' time if runs take very different times.

Claimed runs are compared with fixed shares.

    python benchmarks/stealing.py [runs] [seconds per job]

Jobs are real ones, with worker processes and records, but a run only sleeps: for a lognormal time, whose logarithm has a
standard deviation of 1.5. The idle share is that of all jobs between the first run's start and the last one's end; that of
fixed shares follows from the same times.
"""

from __future__ import annotations

import multiprocessing
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from bench.jobs import work as work_module
from bench.jobs.claims import Claims, deal
from bench.jobs.presence import at_work
from bench.jobs.records import read_records
from bench.jobs.work import Job, work
from bench.plan.plan import Cell, Plan, ReportSettings, all_runs, write_plan

N_JOB = 8
SIGMA = 1.5


def nap(settings: dict[str, Any], *others: Any) -> dict[str, Any]:
    began = time.monotonic()
    time.sleep(settings["seconds"])
    return {"status": "done", "began": began, "ended": time.monotonic()}


def job(output: Path, batch: int) -> None:
    """A job of the bench whose runs sleep."""
    work_module.execute = nap
    work_module.require_planned_code = lambda plan: None
    work_module.own_modules = lambda plan: ["stealing"]
    work(Job(output, batch, workers=1))


def plan_of(seconds: np.ndarray) -> Plan:
    cells = tuple(Cell({"samples": i}, {"seconds": float(each)}, 0, (), "") for i, each in enumerate(seconds))
    report = ReportSettings("summary", None, (), None)
    return Plan("stealing", report, ("samples",), (), "?", {}, "?", {}, cells, all_runs(cells, 1, {}))


def measured(seconds: np.ndarray) -> tuple[float, float]:
    """The idle share, and how long the sweep took."""
    with tempfile.TemporaryDirectory() as folder:
        output, plan = Path(folder), plan_of(seconds)
        write_plan(plan, output)
        deal(output, [run.key for run in plan.runs], N_JOB)
        jobs = [multiprocessing.Process(target=job, args=(output, batch)) for batch in range(N_JOB)]
        for each in jobs:
            each.start()
        for each in jobs:
            each.join()
        contents = [line.content() for line in read_records(output).values()]
        assert len(contents) == len(seconds), "runs are missing"
        lines = sum(path.read_text().count('"result"') for path in (output / "records").glob("*.jsonl"))
        assert lines == len(seconds), "runs were done twice"
    took = max(each["ended"] for each in contents) - min(each["began"] for each in contents)
    return 1 - sum(each["ended"] - each["began"] for each in contents) / (N_JOB * took), took


def claim_cost() -> float:
    """Seconds that claiming a range and ending it takes on this disk."""
    with tempfile.TemporaryDirectory() as folder, at_work(Path(folder), 0) as here:
        deal(Path(folder), [str(number) for number in range(1000)], 1)
        here.path.parent.mkdir(exist_ok=True)
        here.path.touch()
        claims = Claims(Path(folder), here)
        began, count = time.perf_counter(), 0
        while (taken := claims.take(None, 1)) is not None:
            claims.done(taken[1][0])
            count += 1
        return (time.perf_counter() - began) / count


def main(n_run: int = 1500, seconds_per_job: float = 40.0) -> None:
    drawn = np.random.default_rng(0).lognormal(0.0, SIGMA, n_run)
    seconds = drawn * (seconds_per_job * N_JOB / drawn.sum())
    fixed = max(seconds[share::N_JOB].sum() for share in range(N_JOB))
    idle, took = measured(seconds)
    print(f"{n_run} runs of {np.median(seconds):.3f} s (median) to {seconds.max():.1f} s, {N_JOB} jobs of one worker")
    print(f"claimed runs: {took:6.1f} s, idle {100 * idle:4.1f} %")
    print(f"fixed shares: {fixed:6.1f} s, idle {100 * (1 - seconds.sum() / (N_JOB * fixed)):4.1f} %")
    print(f"nothing idle: {max(seconds_per_job, seconds.max()):6.1f} s")
    print(f"a claim of one run costs {1e3 * claim_cost():.2f} ms on this disk")


if __name__ == "__main__":
    from stealing import main  # workers find `nap` in a module of that name

    main(*map(int, sys.argv[1:2]), *map(float, sys.argv[2:3]))
