"""Jobs that wait in a cluster's queue or run there.

Each has a file in `claims/submitted/` until it has ended well, so that any machine that sees the folder can say what
became of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from bench.jobs.presence import CLAIMS, clusters_jobs_at_work
from bench.jobs.slurm import QUEUED, RUNNING, slurm_states
from bench.storage.files import replace_file
from ksmea.settings.regular_files import open_regular

FOLDER = "submitted"
ENDED = "ended"
NO_SIGN = "no sign of it (queued or lost; squeue cannot be asked here)"
WAITED_FOR = ("queued", "running", NO_SIGN)


def note_submitted(output: Path, jobs: Iterable[str]) -> None:
    """Remember the jobs with these numbers, except jobs that have already ended."""
    folder = output / CLAIMS / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    for job in jobs:
        try:
            open_regular(folder / job, "xb").close()
        except FileExistsError:
            if _said(folder / job) == ENDED:
                (folder / job).unlink()


def note_ended(output: Path, job: str) -> None:
    """A job has nothing left to do; it may be faster than who submitted it."""
    path = output / CLAIMS / FOLDER / job
    if not (output / CLAIMS).is_dir():  # all was done, and cleared
        return
    path.parent.mkdir(exist_ok=True)
    try:
        path.unlink()
    except FileNotFoundError:
        try:
            with open_regular(path, "xb") as file:
                file.write(ENDED.encode())
        except FileExistsError:
            path.unlink()


def note_failed(output: Path, job: str, reason: str) -> None:
    """A job has ended for another reason than that nothing was left."""
    path = output / CLAIMS / FOLDER / job
    path.parent.mkdir(parents=True, exist_ok=True)
    replace_file(path, reason.encode())


def job_states(output: Path) -> dict[str, str]:
    """Each submitted job that has not ended well: queued, running, lost, or why it failed.

    Slurm is asked where it can be: one that was ended there, for its node was lost or another job came first, may be
    queued again. Else the jobs themselves are, by what they renew in the folder.
    """
    paths = sorted((output / CLAIMS / FOLDER).glob("[0-9]*"))
    said = {path.name: text for path in paths if (text := _said(path)) != ENDED}
    if not said:
        return {}
    queue_states = slurm_states(said)
    at_work = clusters_jobs_at_work(output) if queue_states is None else set()
    return {job: _state(job, text, queue_states, at_work) for job, text in said.items()}


def forget_lost(output: Path) -> None:
    """Remove what is known of jobs that neither wait nor run."""
    for job, state in job_states(output).items():
        if state not in WAITED_FOR:
            (output / CLAIMS / FOLDER / job).unlink(missing_ok=True)


def _state(job: str, text: str, queue_states: dict[str, str] | None, at_work: set[str]) -> str:
    if queue_states is None:
        return text or ("running" if job in at_work else NO_SIGN)
    state = queue_states.get(job, "gone from the queue")
    if state in QUEUED:
        return "queued"
    if state in RUNNING:
        return "running"
    return text or f"lost ({state})"


def _said(path: Path) -> str:
    try:
        with open_regular(path) as file:
            return file.read().decode(errors="replace")
    except FileNotFoundError:
        return ENDED
