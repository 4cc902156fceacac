"""An array of Slurm by submitit, and what runs in a job of it.

Hydra's search for plugins passes files by that begin with '_': without submitit nothing else is the worse.
"""

from __future__ import annotations

import signal
from collections.abc import Mapping, Sequence
from types import FrameType
from typing import Any

from omegaconf import OmegaConf

from bench.jobs.slurm import own_job
from bench.jobs.submitted import note_ended, note_failed
from bench.jobs.work import Job, work
from ksmea.errors import SettingError, visible

try:
    from hydra_plugins.hydra_submitit_launcher.config import BaseQueueConf, SlurmQueueConf
    from submitit import AutoExecutor, helpers
    from submitit.core.utils import FailedJobError
except ImportError as error:
    raise SettingError(
        "hydra/launcher=submitit_slurm: expected hydra-submitit-launcher, which is not installed;"
        " pip install 'ksmea-bench[cluster]'"
    ) from error


def submitted(jobs: Sequence[Job], params: Mapping[str, Any]) -> list[str]:
    """Submit the jobs with the settings of the launcher; Slurm's numbers of them."""
    given = OmegaConf.to_container(OmegaConf.merge(OmegaConf.structured(SlurmQueueConf), params))  # types are checked
    folder, max_num_timeout = given.pop("submitit_folder"), given.pop("max_num_timeout")
    of_any_cluster = set(OmegaConf.structured(BaseQueueConf))
    own = {name: given[name] for name in params if name in given}
    try:
        executor = AutoExecutor(folder=folder, cluster="slurm", slurm_max_num_timeout=max_num_timeout)
        executor.update_parameters(
            **{name if name in of_any_cluster else f"slurm_{name}": value for name, value in own.items()}
        )
        return [job.job_id for job in executor.map_array(SlurmJob(), jobs)]
    except (RuntimeError, FailedJobError) as error:
        raise SettingError(
            f"hydra/launcher=submitit_slurm: expected Slurm to take the jobs, got: {' '.join(str(error).split())};"
            " docs/cluster.md explains the settings of hydra.launcher"
        ) from error


class SlurmJob:
    """Work of a job of Slurm.

    After the signal ahead of the time limit the job is requeued and goes on.
    """

    def __call__(self, job: Job) -> None:
        number = own_job() or "0"
        signal.signal(signal.SIGTERM, _end)
        try:
            work(job)
        except Cancelled:
            note_failed(job.output, number, "cancelled, or stopped at its time limit")
            raise
        except Exception as error:
            note_failed(job.output, number, visible(f"failed: {' '.join(str(error).split())}"))
            raise
        note_ended(job.output, number)

    def checkpoint(self, job: Job) -> helpers.DelayedSubmission:
        """Called at the signal.

        The claims are free again once the job has ended, whatever else Slurm signals meanwhile.
        """
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        return helpers.DelayedSubmission(self, job)


class Cancelled(SystemExit):
    """Slurm has asked the job to end."""


def _end(number: int, frame: FrameType | None) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    raise Cancelled(128 + number)
