"""The runs of an experiment offered to jobs.

These are the runs that are still to do, with their overrides, which a launcher passes on.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from omegaconf import DictConfig

from bench.command_line.overrides import override
from bench.jobs.claims import deal
from bench.jobs.lines import RunLine
from bench.jobs.presence import numbers_at_work
from bench.jobs.records import RecordWriter, finished_keys, read_records
from bench.jobs.work import Job, unfinished
from bench.plan.experiment import Experiment
from bench.plan.plan import Plan, Run, read_plan, write_plan
from ksmea.errors import SettingError


def dealt(experiment: Experiment) -> list[list[str]]:
    """Write the plan and offer its runs, after results are taken over.

    The overrides of each job that may find work.

    Where jobs of the same plan are at work, the new ones join them. Jobs of another plan are an error.
    """
    output, plan = experiment.output, experiment.plan
    if numbers_at_work(output):
        _require_same_runs(output, plan)
        n_job = experiment.batches
    else:
        write_plan(plan, output)
        todo = unfinished(plan.runs, finished_keys(output, plan))
        todo = _take_over(todo, experiment.share, output, plan)
        n_job = min(experiment.batches, len(todo))
        if todo:
            deal(output, [run.key for run in todo], n_job)
    return [[override("output", str(output)), override("batch", batch), *experiment.working] for batch in range(n_job)]


def job_of(config: DictConfig) -> Job:
    """The job that a job's configuration describes."""
    return Job(
        output=Path(config.output),
        batch=config.batch,
        workers=config.workers,
        timeout=config.timeout,
        memory=config.memory,
        journal=config.journal,
    )


def _require_same_runs(output: Path, plan: Plan) -> None:
    if read_plan(output).runs != plan.runs:
        raise SettingError(
            f"{output}: jobs of another plan are at work there; wait for them to end or cancel them, or choose another"
            " output=DIR"
        )


def _take_over(todo: list[Run], share: Sequence[Path], output: Path, plan: Plan) -> list[Run]:
    """Copy results of the same key from other experiments' folders; the runs that remain to be done."""
    wanted = {run.key: run for run in todo}
    for folder in share:

        def wanted_line(line: RunLine) -> RunLine | None:
            return line if line.key in wanted and line.has_result else None

        with RecordWriter(output, 0, plan) as writer:
            for key, line in read_records(folder, wanted_line, plan).items():
                if line is not None:
                    place = {"taken_from": str(folder), "platform": line.platform}
                    writer.result(wanted.pop(key), {**line.content(), **place})
    return list(wanted.values())
