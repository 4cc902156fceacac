"""Runs shared among jobs without a server: ranges of runs are files, and renaming a file claims it.

In `claims/DEALT/` the file `todo` has the keys of all runs that were to be done. Every other file is a range of its
lines, named START-STOP.DEATHS.OWNER; the owner is a job or `free`. A rename has one winner on every file system. Runs
that no file names are done with. While ranges are split they overlap for a moment, so that a job that dies there loses
no run.

A job takes about as many runs at a time as it does in `HELD`, and of the last ones a small part. Runs that it has not
started go back once no range is free: so no run waits behind a long one. A dead job's ranges are freed by any idle job.
"""

from __future__ import annotations

import os
import secrets
import shutil
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from bench.jobs.presence import CLAIMS, JOBS, Presence, numbers_at_work
from bench.jobs.submitted import job_states
from ksmea.settings.regular_files import open_regular

TODO = "todo"
FREE = "free"
HELD = 5.0  # s of work that a job takes at a time: five file operations for each claim are nothing beside them
PER_JOB = 0.02  # s added for each job, so that a thousand of them do not keep the file server busy
LOOK = 0.5  # s between two looks at the folder
MAX_DEATHS = 3  # jobs that a range may outlive: a run that kills its job must not kill them all


@dataclass(frozen=True)
class Range:
    """Lines `start` to `stop` of the list, the jobs that have died with one of them, and who has them."""

    start: int
    stop: int
    deaths: int = 0
    owner: str = FREE

    @property
    def file_name(self) -> str:
        return f"{self.start:08d}-{self.stop:08d}.{self.deaths}.{self.owner}"

    @classmethod
    def of(cls, name: str) -> Range | None:
        """The range that a file name is; None for any other file."""
        try:
            lines, deaths, owner = name.split(".")
            start, stop = map(int, lines.split("-"))
            return cls(start, stop, int(deaths), owner)
        except ValueError:
            return None


def deal(output: Path, todo: Sequence[str], shares: int) -> None:
    """Offer the runs of these keys to all jobs, in as many free ranges as jobs are expected.

    All offers before are replaced.

    Whoever deals makes sure before that no job is at work.
    """
    folder = output / CLAIMS
    shutil.rmtree(folder / JOBS, ignore_errors=True)
    older = [path for path in folder.glob("*") if _is_dealt(path)]
    new = folder / f".{secrets.token_hex(4)}"
    new.mkdir(parents=True)
    (new / TODO).write_text("".join(f"{key}\n" for key in todo))
    ends = [len(todo) * share // shares for share in range(shares + 1)]
    for start, stop in pairwise(ends):
        if start < stop:
            (new / Range(start, stop).file_name).touch(exist_ok=False)
    new.rename(folder / f"{time.time_ns():x}")
    for path in older:
        shutil.rmtree(path, ignore_errors=True)


def clear(output: Path) -> None:
    """Remove the claims where no job is at work any more and none was submitted that has not ended."""
    if not numbers_at_work(output) and not job_states(output):
        shutil.rmtree(output / CLAIMS, ignore_errors=True)


def are_offered(output: Path) -> bool:
    """Whether runs were dealt out in this folder, and have not been cleared since."""
    return bool(_offers(output))


def _offers(output: Path) -> list[Path]:
    """The folders of runs that were dealt out; the last one counts."""
    return [path for path in (output / CLAIMS).glob("[0-9a-f]*") if _is_dealt(path)]


def _is_dealt(path: Path) -> bool:
    return path.is_dir() and (path / TODO).is_file()


class Claims:
    """A job's view of the ranges: what it holds, and what others offer."""

    def __init__(self, output: Path, presence: Presence) -> None:
        self._folder = max(_offers(output), default=None)
        self._presence = presence
        self._held: dict[Range, set[str]] = {}  # with the keys that have no result yet
        self._idle_since: float | None = None
        self._looked = time.monotonic()
        self._n_job = 1
        self.todo: list[str] = []
        if self._folder is not None:
            with open_regular(self._folder / TODO) as file:
                self.todo = file.read().decode().split()

    def are_done(self) -> bool:
        """Whether nothing is left, with this job or any other."""
        return not self._ranges()

    def take(self, seconds_per_run: float | None, at_least: int) -> tuple[Range, list[str]] | None:
        """Claim a free range of runs and return it with their keys; None if no range is free now.

        `seconds_per_run` is what this job has needed so far, with all its workers; None before it has done any.
        """
        ranges = self._ranges()
        free = [each for each in ranges if each.owner == FREE]
        if not free:
            free = self._freed_of_the_dead(ranges)
        first = self._presence.number % len(free) if free else 0
        for offered in [*free[first:], *free[:first]]:
            mine = self._renamed(offered, owner=self._presence.name)
            if mine is not None:
                wanted = self._wanted(mine, sum(each.stop - each.start for each in free), seconds_per_run, at_least)
                if wanted < mine.stop - mine.start:
                    mine = self._split(mine, mine.start + wanted)
                keys = self.todo[mine.start : mine.stop]
                self._held[mine] = set(keys)
                self._idle_since = None
                return mine, keys
        return None

    def _wanted(self, mine: Range, n_free: int, seconds_per_run: float | None, at_least: int) -> int:
        self._n_job = self._presence.n_job()
        if mine.deaths > 1:
            return 1  # whichever run it is that kills jobs, it is to be alone
        seconds = HELD + PER_JOB * self._n_job
        wanted = at_least if seconds_per_run is None else max(at_least, int(seconds / max(seconds_per_run, 1e-9)))
        if self._n_job == 1:
            return wanted
        return min(wanted, max(1, n_free // (2 * self._n_job)))  # of the last ones a small part: all jobs end together

    def done(self, key: str) -> None:
        """A run of a held range has ended, however it did."""
        for held, keys in self._held.items():
            keys.discard(key)
            if not keys:
                del self._held[held]
                self._path(held).unlink(missing_ok=True)
                return

    def give_back(self, waiting: Sequence[str]) -> bool:
        """Offer the last of the held runs, which nobody has started, where other jobs have nothing to do.

        Returns whether that was done.
        """
        if not waiting or time.monotonic() - self._looked < self._pause:
            return False
        self._looked = time.monotonic()
        self._n_job = self._presence.n_job()
        if self._n_job < 2 or any(each.owner == FREE for each in self._ranges()):
            return False
        self._return(waiting)
        return True

    def release(self, waiting: Sequence[str]) -> None:
        """Give back whatever is held: this job ends before its runs have."""
        if waiting:
            self._return(waiting)
        for held in [*self._held]:
            self._renamed(held, owner=FREE, deaths=max(held.deaths, 1))
        self._held.clear()

    def may_come_back(self) -> bool:
        """Whether runs may yet be offered.

        Others hold some, and have not had the time to give them back, or are dead.
        """
        ranges = [each for each in self._ranges(anew=True) if each.owner != self._presence.name]
        now = time.monotonic()
        self._idle_since = now if self._idle_since is None else self._idle_since
        if not all(self._presence.is_alive(each.owner) for each in ranges if each.owner != FREE):
            return True
        is_last = all(each.stop - each.start == 1 and each.owner != FREE for each in ranges)  # all have been started
        return not is_last and now - self._idle_since < 3 * self._pause

    @property
    def _pause(self) -> float:
        """Seconds between two looks at the folder."""
        return LOOK + PER_JOB * self._n_job

    def _return(self, waiting: Sequence[str]) -> None:
        """The end of a range, from the first of its runs that wait on, is free again."""
        held = next(each for each, keys in self._held.items() if waiting[0] in keys)
        start = self.todo.index(waiting[0], held.start, held.stop)
        keys = self._held.pop(held)
        if start == held.start:
            self._renamed(held, owner=FREE)
            return
        left = self._split(held, start)
        self._held[left] = keys.difference(waiting)
        if not self._held[left]:
            del self._held[left]
            self._path(left).unlink(missing_ok=True)

    def _split(self, held: Range, at: int) -> Range:
        """The first part of a held range, the rest of which is free from now on."""
        rest, left = Range(at, held.stop, held.deaths), Range(held.start, at, held.deaths, held.owner)
        self._path(rest).touch()
        try:
            self._path(held).rename(self._path(left))
        except FileNotFoundError:
            self._path(rest).unlink(missing_ok=True)
            raise self._presence.taken_for_dead() from None
        return left

    def _freed_of_the_dead(self, ranges: Iterable[Range]) -> list[Range]:
        freed = []
        for each in ranges:
            if each.owner in (FREE, self._presence.name) or self._presence.is_alive(each.owner):
                continue
            if each.deaths + 1 < MAX_DEATHS:
                freed.append(self._renamed(each, owner=FREE, deaths=each.deaths + 1))
            else:
                self._path(each).unlink(missing_ok=True)
        return [each for each in freed if each is not None]

    def _renamed(self, old: Range, owner: str, deaths: int | None = None) -> Range | None:
        """The range under another name; None if someone else was first."""
        new = Range(old.start, old.stop, old.deaths if deaths is None else deaths, owner)
        try:
            os.rename(self._path(old), self._path(new))
        except FileNotFoundError:  # of a lost answer, a client of NFS asks again, and finds its own work
            return new if owner != FREE and self._path(new).exists() else None
        return new

    def _ranges(self, anew: bool = False) -> list[Range]:
        if self._folder is None:
            return []
        try:
            if (
                anew
            ):  # a client of NFS asks the server once it has changed a folder itself; else it may see one 60 s old
                changed = self._folder / f".{self._presence.name}"
                changed.touch()
                changed.unlink()
            names = sorted(os.listdir(self._folder))
        except FileNotFoundError:
            return []
        return [each for name in names if (each := Range.of(name)) is not None]

    def _path(self, of: Range) -> Path:
        assert self._folder is not None
        return self._folder / of.file_name
