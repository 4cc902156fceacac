"""What Slurm says of its jobs: `squeue` alone is asked, which is there with every Slurm, with or without accounting."""
# Shorter than 40 lines: all that is known of Slurm's variables.

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable

QUEUED = ("PENDING", "REQUEUED", "REQUEUE_HOLD", "REQUEUE_FED", "SPECIAL_EXIT", "RESV_DEL_HOLD")
RUNNING = ("RUNNING", "COMPLETING", "CONFIGURING", "RESIZING", "SIGNALING", "STAGE_OUT", "STOPPED", "SUSPENDED")
UNKNOWN_JOB = "Invalid job id"
PATIENCE = 60  # s for an answer of squeue


def own_job() -> str | None:
    """The number of the Slurm job that this process belongs to, 12_3 in an array; None if it does not."""
    array, task = os.environ.get("SLURM_ARRAY_JOB_ID"), os.environ.get("SLURM_ARRAY_TASK_ID")
    return f"{array}_{task}" if array and task else os.environ.get("SLURM_JOB_ID")


def slurm_states(jobs: Iterable[str]) -> dict[str, str] | None:
    """Slurm's word on each of the jobs that it knows, such as PENDING; None if it cannot be asked."""
    states: dict[str, str] = {}
    for number in sorted({job.partition("_")[0] for job in jobs}):
        command = ["squeue", "--noheader", "--array", "--states=all", "--format=%i %T", f"--jobs={number}"]
        try:
            asked = subprocess.run(command, capture_output=True, text=True, check=False, timeout=PATIENCE)
        except (OSError, subprocess.TimeoutExpired):
            return None
        if asked.returncode and UNKNOWN_JOB not in asked.stderr:
            return None
        states |= {job: state for job, _, state in (line.partition(" ") for line in asked.stdout.splitlines())}
    return states
