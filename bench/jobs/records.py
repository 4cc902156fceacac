"""Records: append-only JSON lines, one file and one writer per batch.

A line that is not a record, torn by a killed writer or damaged since, is skipped and counted; its run is repeated.
"""

from __future__ import annotations

import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, BinaryIO, Self, TypeVar, overload

import msgspec

from bench.jobs.lines import RESULTS, SCHEMA, Ended, Line, RunLine, SessionLine, Started, line_text, read_line
from bench.jobs.presence import numbers_at_work
from bench.plan.plan import Cell, Plan, Run
from bench.plan.provenance import platform_name
from bench.storage.files import exclusive, is_held
from ksmea.plugins import registry
from ksmea.plugins.files import OURS
from ksmea.records.record import Record
from ksmea.settings.regular_files import open_regular

__all__ = [
    "INTERRUPTED",
    "NOT_FAILED",
    "NOT_RUN",
    "RESULTS",
    "RUNNING",
    "UNFINISHED",
    "RecordWriter",
    "RunLine",
    "ended_statuses",
    "finished_keys",
    "last_began",
    "read_lines",
    "read_records",
    "running_sessions",
]

INTERRUPTED = "interrupted"  # status of a run that was started and has no end: it did not fail
NOT_RUN = "not run"  # status of one that was planned and no more
RUNNING = "running"  # status of one that was started and whose session still writes
UNFINISHED = (RUNNING, INTERRUPTED, NOT_RUN)
NOT_FAILED = (*RESULTS, *UNFINISHED)
FOLDER = "records"
SESSION_BEGINS = b'{"event": "session"'  # as `line_text` writes it

Kept = TypeVar("Kept")


class RecordWriter:
    """The only writer of a batch's record file, for as long as the context lasts."""

    def __init__(self, output: Path, batch: int, plan: Plan) -> None:
        self._path = record_file(output, batch)
        self._plan = plan
        self._held = ExitStack()
        self._file: BinaryIO | None = None
        self._session = ""

    def __enter__(self) -> Self:
        with ExitStack() as held:
            held.enter_context(exclusive(self._path.with_suffix(".lock")))
            torn = _ends_within_a_line(self._path)
            self._file = held.enter_context(open_regular(self._path, "ab"))
            if torn:  # what a killed writer left unfinished gets a line of its own, that no reader accepts
                self._file.write(b"\n")
            self._held = held.pop_all()
        return self

    def __exit__(self, *exception: object) -> None:
        self._held.close()

    def started(self, run: Run) -> None:
        line = Started(schema=SCHEMA, key=run.key, question=run.question, session=self._begun_session())
        self._append(line_text(line, content={}))

    def result(self, run: Run, record: Mapping[str, Any]) -> None:
        """Write how a run ended: the JSON data of its study's record, or of a `FailedRun`, with a `status`."""
        line = Ended(
            schema=SCHEMA, key=run.key, question=run.question, session=self._begun_session(), status=record["status"]
        )
        self._append(line_text(line, record))

    def _begun_session(self) -> str:
        """The session, which says once, before the first run, what all runs of this writer are computed by."""
        if not self._session:
            self._session = f"{time.time_ns():x}-{os.getpid()}"
            plan = self._plan
            self._append(
                line_text(
                    SessionLine(
                        schema=SCHEMA,
                        session=self._session,
                        began=time.strftime("%Y-%m-%dT%H:%M:%S%z"),
                        commit=plan.commit,
                        platform=platform_name(),
                        versions=dict(plan.versions),
                        modules=dict(plan.modules),
                    )
                )
            )
        return self._session

    def _append(self, text: bytes) -> None:
        """One write per line: what is on the disk is whole lines, and at most one torn one at the end."""
        assert self._file is not None, "a writer writes inside its context"
        self._file.write(text)
        self._file.flush()


def record_file(output: Path, batch: int) -> Path:
    return output / FOLDER / f"batch-{batch:04d}.jsonl"


def _ends_within_a_line(path: Path) -> bool:
    try:
        with open_regular(path) as file:
            if not file.seek(0, os.SEEK_END):
                return False
            file.seek(-1, os.SEEK_END)
            return file.read(1) != b"\n"
    except FileNotFoundError:
        return False


def finished_keys(output: Path, plan: Plan | None = None) -> set[str]:
    """Keys of all runs that have a result; with a plan, one that its study can read."""
    found = read_records(output, lambda line: line.has_result, plan)
    return {key for key, has_result in found.items() if has_result}


def record_types(plan: Plan) -> dict[str, type[Record]]:
    """The type of record that the study of each planned run finds, by the run's key.

    A study of another package is not imported because a folder names it: unless this process has loaded it, any record
    of it is one.
    """
    of_cell = []
    for cell in plan.cells:
        named = cell.settings.get("study") is not None  # plans older than studies name none
        study = registry.plugin_class("study", cell.chosen("study")) if named and _is_loaded(cell) else None
        of_cell.append(getattr(study, "record", Record))
    return {run.key: of_cell[run.cell] for run in plan.runs}


def _is_loaded(cell: Cell) -> bool:
    """Whether the study of a cell is one of this project, of none at all, or loaded."""
    point = registry.registered("study").get(cell.chosen("study"))
    return point is None or point.module.partition(".")[0] in OURS or point.module in sys.modules


def running_sessions(output: Path) -> set[str]:
    """The sessions that still write.

    They are the last session of each record file whose lock is held, or whose job is at work.
    """
    sessions = set()
    at_work = {record_file(output, number) for number in numbers_at_work(output)}
    for path in (output / FOLDER).glob("*.jsonl"):
        if path in at_work or is_held(path.with_suffix(".lock")):
            began = [line.session for line in _lines_of(path) if isinstance(line, SessionLine)]
            sessions.update(began[-1:])
    return sessions


def ended_statuses(output: Path, plan: Plan) -> dict[str, str]:
    """Status of ended runs, by key.

    A run that was started and has no end is being computed, or was interrupted: it is left out.
    """
    found = read_records(output, lambda line: None if isinstance(line, Started) else line.status, plan)
    return {key: status for key, status in found.items() if status is not None}


@overload
def read_records(output: Path, *, plan: Plan | None = None) -> dict[str, RunLine]: ...


@overload
def read_records(
    output: Path, keep: Callable[[RunLine], Kept], plan: Plan | None = None, damaged: Counter[Path] | None = None
) -> dict[str, Kept]: ...


def read_records(
    output: Path,
    keep: Callable[[RunLine], Any] = lambda line: line,
    plan: Plan | None = None,
    damaged: Counter[Path] | None = None,
) -> dict[str, Any]:
    """Last line of each key, or the first one with a result, each passed through `keep`.

    The line shows how a run ended, or that it was started and is running or was interrupted. A result is never replaced
    by a later failure. A line without a `platform` of its own gets the platform of its session.

    With a plan, a result whose record its study cannot read does not count, and the run is done again. `keep` picks
    what is needed while the file is read: a hundred thousand whole records would fill the memory. `damaged` counts, by
    file, lines that are no records.
    """
    type_of_run = {} if plan is None else record_types(plan)
    with_result: set[str] = set()
    platforms: dict[str, str] = {}
    running = running_sessions(output)  # before the lines are read: what ends meanwhile has its end among them
    kept: dict[str, Any] = {}
    for line in read_lines(output, damaged):
        if isinstance(line, SessionLine):
            platforms[line.session] = line.platform
            continue
        if line.key in with_result:
            continue
        known = line.checked(type_of_run[line.key]) if line.has_result and line.key in type_of_run else line
        known = known.computed_on(platforms.get(line.session, ""))
        if isinstance(known, Started):
            known = _unfinished(known, is_running=line.session in running)
        if known.has_result:
            with_result.add(line.key)
        kept[line.key] = keep(known)
    return kept


def _unfinished(line: Started, *, is_running: bool) -> Started:
    """A line of a run without an end, with what became of the run as its status."""
    if is_running:
        return msgspec.structs.replace(line, status=RUNNING, error="")
    return msgspec.structs.replace(line, status=INTERRUPTED)


def last_began(output: Path) -> str:
    """When the last of all sessions began, '' where none is there. Only the lines of sessions are decoded."""
    began = [""]
    for path in (output / FOLDER).glob("*.jsonl"):
        with open_regular(path) as file:
            lines = (read_line(text, path) for text in file if text.startswith(SESSION_BEGINS))
            began += [line.began for line in lines if isinstance(line, SessionLine)]
    return max(began)


def read_lines(output: Path, damaged: Counter[Path] | None = None) -> Iterator[Line]:
    """All lines of all record files.

    Lines that are not records are ignored, and counted by file if `damaged` is given.
    """
    for path in sorted((output / FOLDER).glob("*.jsonl")):
        yield from _lines_of(path, damaged)


def _lines_of(path: Path, damaged: Counter[Path] | None = None) -> Iterator[Line]:
    with open_regular(path) as file:
        for text in file:
            line = read_line(text, path)
            if line is not None:
                yield line
            elif (
                damaged is not None
                and text.strip()
                and (text.endswith(b"\n") or not is_held(path.with_suffix(".lock")))
            ):
                damaged[path] += 1  # and not the line that a job is writing just now


def damaged_lines(output: Path) -> Counter[Path]:
    """How many lines of each record file of a folder are no records."""
    found: Counter[Path] = Counter()
    for _ in read_lines(output, found):
        pass
    return found


def damage_notes(damaged: Counter[Path]) -> list[str]:
    """A line for the user on each file that has some."""
    return [
        f"{count} damaged line{'' if count == 1 else 's'} in {path} passed over: a run whose result stood there counts as not"
        " done, and the experiment's command does it again"
        for path, count in sorted(damaged.items())
    ]
