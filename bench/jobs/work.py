"""A job's work: its share of the plan, in worker processes that can die without harm, into its record file."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tqdm import tqdm

from bench.jobs.execute import execute
from bench.jobs.lines import RESULTS, RunLine
from bench.jobs.log import experiment_log
from bench.jobs.pool import Limits, run_tasks
from bench.jobs.records import RecordWriter, finished_keys, read_records
from bench.plan.plan import Plan, Run, read_plan
from bench.plan.provenance import OURS, platform_name

JOURNALS = "journals"
GIGABYTE = 2**30
SLOW_TO_IMPORT = ("scipy.stats",)  # imported where it is first used, which would be in each worker


@dataclass(frozen=True)
class Job:
    """A share of a plan and what its runs may use. `share` names folders whose results of the same key are taken over."""

    output: Path
    batch: int = 0
    batches: int = 1
    workers: int | None = None
    timeout: float | None = None  # s
    memory: float | None = None  # GB
    journal: bool = False
    share: tuple[Path, ...] = ()

    @property
    def limits(self) -> Limits:
        return Limits(self.timeout, None if self.memory is None else int(self.memory * GIGABYTE))


def work(job: Job) -> None:
    """Do what `plan[batch::batches]` still lacks, one record per run."""
    plan = read_plan(job.output)
    todo = unfinished(plan.runs[job.batch :: job.batches], finished_keys(job.output, plan))
    if not todo:
        return
    with RecordWriter(job.output, job.batch, plan) as writer, experiment_log(job.output, plan.name, job.batch) as log:
        todo = _take_over(todo, job.share, writer, plan)
        n_worker = min(job.workers or available_cores(), len(todo))
        told = len(todo), n_worker, plan.commit, platform_name()
        log.info("%d runs to do with %d workers, commit %s, on %s", *told)
        # disable=None: silent where there is no terminal
        with tqdm(total=len(todo), desc=plan.name, unit="run", disable=None) as bar:
            tasks = ((run, (*_arguments(plan, run, job), len(todo) == 1)) for run in todo)
            for run, record in run_tasks(execute, tasks, n_worker, job.limits, writer.started, own_modules(plan)):
                writer.result(run, record)
                if job.journal and record["status"] in RESULTS:
                    _journal(run, job).unlink(missing_ok=True)  # only a run without a result needs it again
                bar.update()
                log.info("%s", _log_line(plan, run, record))
        log.info("job ended")


def available_cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def unfinished(runs: Iterable[Run], finished: set[str]) -> list[Run]:
    """Runs without a result, each key once."""
    return list({run.key: run for run in runs if run.key not in finished}.values())


def own_modules(plan: Plan) -> list[str]:
    """Modules that workers may find loaded: not those of outside plugins, which could harm all workers at once."""
    return [*SLOW_TO_IMPORT, *(name for name in plan.modules if name.partition(".")[0] in OURS)]


def _arguments(plan: Plan, run: Run, job: Job) -> tuple[Any, ...]:
    journal = _journal(run, job) if job.journal else None
    with_curves = run.repetition == 0  # enough for figures
    return plan.cells[run.cell].settings, plan.seeds(run), journal, with_curves


def _journal(run: Run, job: Job) -> Path:
    return job.output / JOURNALS / f"{run.key}.journal"


def _take_over(todo: list[Run], share: tuple[Path, ...], writer: RecordWriter, plan: Plan) -> list[Run]:
    """Copy results of the same key from other experiments' folders; the runs that remain to be done."""
    wanted = {run.key: run for run in todo}
    for folder in share:

        def wanted_line(line: RunLine) -> RunLine | None:
            return line if line.key in wanted and line.has_result else None

        for key, line in read_records(folder, wanted_line, plan).items():
            if line is not None:
                place = {"taken_from": str(folder), "platform": line.platform}
                writer.result(wanted.pop(key), {**line.content(), **place})
    return list(wanted.values())


def _log_line(plan: Plan, run: Run, record: dict[str, Any]) -> str:
    place = " ".join(f"{axis}={value}" for axis, value in plan.cells[run.cell].place.items())
    ending = f"{record['status']} after {record['elapsed']:.3f} s" if "elapsed" in record else record["status"]
    return f"run {run.key} ({place} repetition={run.repetition}) {ending} {record.get('error', '')}".rstrip()
