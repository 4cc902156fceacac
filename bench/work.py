"""A job's work: its share of the plan, in worker processes that can die without harm, into its record file."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, wait
from pathlib import Path
from typing import Any

from pebble import ProcessExpired, ProcessFuture, ProcessPool
from tqdm import tqdm

from bench.execute import execute
from bench.plan import Plan, Run, read_plan
from bench.records import RESULTS, RecordWriter, read_records

LOOK_AHEAD = 2  # runs handed out per worker: one in work, one waiting, so that no worker idles


def work(output: Path, batch: int, batches: int, workers: int | None, timeout: float | None) -> None:
    """Do what `plan[batch::batches]` still lacks, one record per run."""
    plan = read_plan(output)
    with RecordWriter(output, batch) as writer:
        todo = list(_unfinished(plan, plan.runs[batch::batches], output))
        if not todo:
            return
        n_worker = min(workers or available_cores(), len(todo))
        # disable=None: silent where there is no terminal
        with tqdm(total=len(todo), desc=plan.name, unit="run", disable=None) as bar:
            for run, record in _computed(plan, todo, n_worker, timeout, writer):
                writer.result(run.key, record)
                bar.update()


def available_cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _unfinished(plan: Plan, runs: tuple[Run, ...], output: Path) -> Iterator[Run]:
    """Runs without a result, each key once."""
    finished = {key for key, record in read_records(output).items() if record["status"] in RESULTS}
    for run in runs:
        if run.key not in finished:
            finished.add(run.key)
            yield run


def _computed(
    plan: Plan, todo: list[Run], workers: int, timeout: float | None, writer: RecordWriter
) -> Iterator[tuple[Run, dict[str, Any]]]:
    waiting = iter(todo)
    pool = ProcessPool(
        max_workers=workers, context=multiprocessing.get_context("spawn"), initializer=_ignore_interrupts
    )
    futures: dict[ProcessFuture, Run] = {}
    try:
        while True:
            while len(futures) < LOOK_AHEAD * workers and (run := next(waiting, None)) is not None:
                writer.started(run.key)
                futures[pool.schedule(execute, (plan.cells[run.cell].settings, plan.seeds(run)), timeout=timeout)] = run
            if not futures:
                return
            for future in wait(futures, return_when=FIRST_COMPLETED).done:
                yield futures.pop(future), _record_of(future, timeout)
    finally:
        pool.stop()
        pool.join()


def _record_of(future: ProcessFuture, timeout: float | None) -> dict[str, Any]:
    try:
        return future.result()
    except TimeoutError:
        return {"status": "timeout", "error": f"the run did not end within {timeout:g} s"}
    except ProcessExpired as expired:
        return {"status": "killed", "error": f"the worker process ended with exit code {expired.exitcode}"}


def _ignore_interrupts() -> None:
    """Ctrl-C goes to the whole process group; the parent alone decides."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
