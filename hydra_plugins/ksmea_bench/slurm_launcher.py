"""`hydra/launcher=submitit_slurm`: jobs of an experiment as an array of Slurm.

They are waited for unless `wait=false`.

What jobs find is in the results folder, where the sweeper collects it. So one that is lost, cancelled or out of time keeps
neither the others nor whoever waits.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hydra.core.utils import JobReturn, JobStatus
from hydra.plugins.launcher import Launcher
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig, OmegaConf

from bench.jobs.offers import job_of
from bench.jobs.submitted import WAITED_FOR, forget_lost, job_states, note_submitted
from ksmea.errors import visible

LOOK = 2.0  # s between two questions to squeue while the jobs are waited for


class SlurmJobs(Launcher):
    """Submits all jobs as one array, with the settings of `hydra.launcher`."""

    def __init__(self, **params: Any) -> None:
        self.params = params

    def setup(self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig) -> None:
        from hydra_plugins.ksmea_bench._slurm_array import submitted  # submitit is loaded where it is chosen

        self.hydra_context, self.config, self.submitted = hydra_context, config, submitted

    def launch(self, job_overrides: Sequence[Sequence[str]], initial_job_idx: int) -> list[JobReturn]:
        loader = self.hydra_context.config_loader
        jobs = [job_of(loader.load_sweep_config(self.config, list(words))) for words in job_overrides]
        output = jobs[0].output
        forget_lost(output)
        plain = OmegaConf.to_container(OmegaConf.create(self.params), resolve=True)
        numbers = self.submitted(jobs, plain)
        note_submitted(output, numbers)
        array = numbers[0].partition("_")[0]
        print(
            f"submitted {len(numbers)} jobs, Slurm's {array}: python -m bench status {visible(str(output))}", flush=True
        )
        if not self.config.wait:
            return [JobReturn(status=JobStatus.UNKNOWN) for _ in numbers]
        _wait_for(output, numbers, array)
        return [JobReturn(status=JobStatus.COMPLETED) for _ in numbers]


def _wait_for(output: Path, numbers: Sequence[str], array: str) -> None:
    """Until none of the jobs waits or runs; says which of them did not end well."""
    try:
        while any(state in WAITED_FOR for state in _states(output, numbers).values()):
            time.sleep(LOOK)
    except KeyboardInterrupt:
        print(f"the jobs go on; `scancel {array}` stops them", file=sys.stderr)
        raise
    for number, state in _states(output, numbers).items():
        print(visible(f"note: job {number} did not end well: {state}"), file=sys.stderr)


def _states(output: Path, numbers: Sequence[str]) -> dict[str, str]:
    return {number: state for number, state in job_states(output).items() if number in numbers}
