"""Presence of jobs in a folder that they share: each renews a numbered file there.

A job that does not renew it is dead.

No lock is requested, which network file systems may lack. A number is taken by creating its file (O_EXCL), and ages are
differences of times that the file server itself has written: the clocks of the machines need not agree.
"""

from __future__ import annotations

import json
import os
import secrets
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

from bench.jobs.slurm import own_job
from ksmea.errors import SettingError
from ksmea.settings.regular_files import open_regular

CLAIMS = "claims"  # the folder, in that of an experiment, that its jobs share
JOBS = "jobs"
BEAT = 20.0  # s between renewals
LEASE = 120.0  # s without a renewal after which a job counts as dead; a client of NFS may see times that are 60 s old


class TakenForDead(SettingError):
    """This job was not heard of for longer than its lease, and others have taken its runs."""


@dataclass
class Presence:
    """Job at work: its number, which also names its record file, and a unique name."""

    path: Path
    name: str
    renewed: float  # on this machine's monotonic clock

    @property
    def number(self) -> int:
        return int(self.path.name)

    def renew(self) -> None:
        """Say that this job lives, if it has not for a while; `TakenForDead` where others hold it for dead."""
        if time.monotonic() - self.renewed < BEAT:
            return
        try:
            os.utime(self.path)  # without a time of its own: the server's
        except FileNotFoundError:
            raise self.taken_for_dead() from None
        self.renewed = time.monotonic()

    def taken_for_dead(self) -> TakenForDead:
        return TakenForDead(
            f"{self.path.parent}: this job was not heard of for {LEASE:g} s and others have taken its runs;"
            " give the experiment's command again"
        )

    def n_job(self) -> int:
        """Number of jobs at work, including jobs that died without removing their file."""
        return sum(1 for _ in os.scandir(self.path.parent))

    def is_alive(self, name: str) -> bool:
        """Whether the job of that name is, by the clock of the server that both write to."""
        os.utime(self.path)
        who = _who_lives(self.path.with_name(name.partition("-")[0]), self.path.stat().st_mtime)
        return who is not None and who.get("name", name) == name


@contextmanager
def at_work(output: Path, first: int) -> Iterator[Presence]:
    """Be at work on an experiment, under the first number from `first` on that no job has, dead or alive."""
    name = secrets.token_hex(4)
    who = {"place": _place(), "process": os.getpid(), "host": socket.gethostname(), "cluster": own_job()}
    folder = output / CLAIMS / JOBS
    folder.mkdir(parents=True, exist_ok=True)
    for number in count(first):
        path = folder / f"{number:04d}"
        try:
            with open_regular(path, "xb") as file:
                file.write(json.dumps({"name": f"{number:04d}-{name}", **who}).encode())
        except FileExistsError:
            continue
        break
    try:
        yield Presence(path, f"{number:04d}-{name}", time.monotonic())
    finally:
        path.unlink(missing_ok=True)


def numbers_at_work(output: Path) -> set[int]:
    """Numbers of the jobs that live, asked by one who has no file there: by this machine's clock."""
    return {number for number, _ in _living(output)}


def clusters_jobs_at_work(output: Path) -> set[str]:
    """Cluster job numbers of the living jobs, by this machine's clock; 'None' for a job outside a cluster."""
    return {str(who.get("cluster")) for _, who in _living(output)}


def _living(output: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    for path in (output / CLAIMS / JOBS).glob("*"):
        if path.name.isdecimal() and (who := _who_lives(path, time.time())) is not None:
            yield int(path.name), who


def _who_lives(path: Path, now: float) -> dict[str, Any] | None:
    """Data in the file of a living job; None if the job is dead.

    A job is dead when its lease has ended, or at once if its process ran at this place and is gone.
    """
    try:
        with open_regular(path) as file:  # opened, so that a client of NFS asks the server
            age = now - os.fstat(file.fileno()).st_mtime
            who = json.loads(file.read() or b"{}")  # empty: it is just being written
    except (FileNotFoundError, ValueError, RecursionError):
        return None
    if not isinstance(who, dict):
        return None
    process = who.get("process")
    is_gone = who.get("place") == _place() and isinstance(process, int) and not Path(f"/proc/{process}").exists()
    return who if age < LEASE and not is_gone else None


def _place() -> str:
    """Scope of process numbers: this start of the machine, and the namespace of the process numbers."""
    try:
        started = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        return f"{started} {os.readlink('/proc/self/ns/pid')}"
    except OSError:
        return secrets.token_hex(8)  # no such thing here: nobody is at the same place, and leases decide
