"""The runs of an experiment dealt out to jobs, as overrides that a launcher passes on, and a job made of these again."""

from __future__ import annotations

from pathlib import Path

from omegaconf import DictConfig

from bench.command_line.overrides import override
from bench.jobs.records import finished_keys
from bench.jobs.work import Job, unfinished
from bench.plan.experiment import Experiment
from bench.plan.plan import write_plan


def dealt(experiment: Experiment) -> list[list[str]]:
    """Write the plan; the overrides of each job that has work left."""
    write_plan(experiment.plan, experiment.output)
    finished = finished_keys(experiment.output, experiment.plan)
    return [
        [override("output", str(experiment.output)), override("batch", batch), *experiment.working]
        for batch in range(experiment.batches)
        if unfinished(experiment.plan.runs[batch :: experiment.batches], finished)
    ]


def job_of(config: DictConfig) -> Job:
    """The job that a job's configuration describes."""
    return Job(
        output=Path(config.output),
        batch=config.batch,
        batches=config.batches,
        workers=config.workers,
        timeout=config.timeout,
        memory=config.memory,
        journal=config.journal,
        share=tuple(Path(folder) for folder in config.share),
    )
