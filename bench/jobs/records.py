"""Records: append-only JSON lines, one file and one writer per batch; a torn line is ignored and its run redone.

Three kinds of lines: a `session` says what code, versions and commit the following ones were computed by; `started`
and `result` belong to a run's key.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self, TextIO, TypeVar

import orjson

from bench.plan.plan import Plan, Run
from bench.storage.locks import exclusive, is_held
from ksmea.errors import SettingError

SCHEMA = 2
FOLDER = "records"
RESULTS = ("done", "budget")  # statuses that are results; all others are failures

Kept = TypeVar("Kept")


class RecordWriter:
    """The only writer of a batch's record file, for as long as the context lasts."""

    def __init__(self, output: Path, batch: int, plan: Plan) -> None:
        self._path = output / FOLDER / f"batch-{batch:04d}.jsonl"
        self._plan = plan
        self._held = ExitStack()
        self._file: TextIO | None = None
        self._session = ""

    def __enter__(self) -> Self:
        with ExitStack() as held:
            held.enter_context(exclusive(self._path.with_suffix(".lock")))
            torn = _ends_within_a_line(self._path)
            self._file = held.enter_context(self._path.open("a", encoding="utf-8"))
            if torn:  # what a killed writer left unfinished gets a line of its own, that no reader accepts
                self._file.write("\n")
            self._held = held.pop_all()
        return self

    def __exit__(self, *exception: object) -> None:
        self._held.close()

    def started(self, run: Run) -> None:
        self._append({"event": "started", **self._identity(run)})

    def result(self, run: Run, record: dict[str, Any]) -> None:
        self._append({"event": "result", **self._identity(run), **record})

    def _identity(self, run: Run) -> dict[str, Any]:
        return {"key": run.key, "question": run.question, "session": self._session or self._begin_session()}

    def _begin_session(self) -> str:
        """Say once, before the first run, what all runs of this writer are computed by."""
        self._session = f"{time.time_ns():x}-{os.getpid()}"
        plan = self._plan
        facts = {
            "commit": plan.commit,
            "platform": plan.platform,
            "versions": dict(plan.versions),
            "modules": dict(plan.modules),
        }
        self._append(
            {"event": "session", "session": self._session, "began": time.strftime("%Y-%m-%dT%H:%M:%S%z"), **facts}
        )
        return self._session

    def _append(self, line: dict[str, Any]) -> None:
        """One write per line: what is on the disk is whole lines, and at most one torn one at the end."""
        self._file.write(json.dumps({"schema": SCHEMA, **line}) + "\n")
        self._file.flush()


def _ends_within_a_line(path: Path) -> bool:
    if not path.exists() or path.stat().st_size == 0:
        return False
    with path.open("rb") as file:
        file.seek(-1, os.SEEK_END)
        return file.read(1) != b"\n"


def finished_keys(output: Path) -> set[str]:
    """Keys of all runs that have a result."""
    return {key for key, status in read_records(output, lambda line: line["status"]).items() if status in RESULTS}


def running_sessions(output: Path) -> set[str]:
    """The sessions that still write: of each record file whose lock is held, the last."""
    sessions = set()
    for path in (output / FOLDER).glob("*.jsonl"):
        if is_held(path.with_suffix(".lock")):
            began = [line["session"] for line in _lines_of(path) if line["event"] == "session"]
            sessions.update(began[-1:])
    return sessions


def read_records(output: Path, keep: Callable[[dict[str, Any]], Kept] = lambda line: line) -> dict[str, Kept]:
    """The last word on each key, as `keep` has it of the line: its result, or status 'killed' where a run was started
    and no more. A result is never replaced by a later failure.

    `keep` picks what is needed while the file is read: a hundred thousand whole records would fill the memory.
    """
    statuses: dict[str, str] = {}
    kept: dict[str, Kept] = {}
    for line in read_lines(output):
        if line["event"] == "session" or statuses.get(line["key"]) in RESULTS:
            continue
        if line["event"] == "started":
            line = {**line, "status": "killed", "error": "the run was started and never ended"}
        statuses[line["key"]] = line["status"]
        kept[line["key"]] = keep(line)
    return kept


def read_lines(output: Path) -> Iterator[dict[str, Any]]:
    """All lines of all record files in the present schema; what is not a record is passed over."""
    for path in sorted((output / FOLDER).glob("*.jsonl")):
        yield from _lines_of(path)


def _lines_of(path: Path) -> Iterator[dict[str, Any]]:
    with path.open("rb") as file:
        for text in file:
            line = _parsed(text)
            if line is not None:
                yield _upgraded(line, path)


def _parsed(text: bytes) -> dict[str, Any] | None:
    """A line that is a whole record, else None."""
    try:
        line = _loaded(text)
    except ValueError:
        return None
    if not isinstance(line, dict) or not isinstance(line.get("schema"), int):
        return None
    needed = {"session": {"session"}, "started": {"key"}, "result": {"key", "status"}}.get(line.get("event"))
    return line if needed is not None and needed <= line.keys() else None


def _loaded(text: bytes) -> Any:
    try:
        return orjson.loads(text)
    except ValueError:
        return json.loads(text)  # slower, and it reads the NaN that a curve may hold


def _upgraded(line: dict[str, Any], path: Path) -> dict[str, Any]:
    """A line of any schema that ever was, in the present one. Schema 1 knew neither questions nor sessions."""
    if line["schema"] > SCHEMA:
        raise SettingError(
            f"{path}: expected records up to schema {SCHEMA}, found {line['schema']}: a newer version wrote them;"
            " install that one, or choose another output=DIR"
        )
    return {"question": "", "session": "", **line}
