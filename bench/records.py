"""Records: append-only JSON lines, one file and one writer per batch; a torn line is ignored and its run redone."""

from __future__ import annotations

import fcntl
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Self, TextIO

from ksmea.errors import SettingError

SCHEMA = 1
FOLDER = "records"
RESULTS = ("done", "budget")  # statuses that are results; all others are failures


class RecordWriter:
    """The only writer of a batch's record file, for as long as the context lasts."""

    def __init__(self, output: Path, batch: int) -> None:
        self._path = output / FOLDER / f"batch-{batch:04d}.jsonl"
        self._file: TextIO | None = None

    def __enter__(self) -> Self:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._file = self._path.open("a+", encoding="utf-8")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise SettingError(
                f"output: another process is writing {self._path}; wait for it to end or choose another output=DIR"
            ) from None
        self._end_torn_line()
        return self

    def __exit__(self, *exception: object) -> None:
        self._file.close()

    def started(self, key: str) -> None:
        self._append({"event": "started", "key": key})

    def result(self, key: str, record: dict[str, Any]) -> None:
        self._append({"event": "result", "key": key, **record})

    def _append(self, line: dict[str, Any]) -> None:
        self._file.write(json.dumps({"schema": SCHEMA, **line}) + "\n")
        self._file.flush()

    def _end_torn_line(self) -> None:
        """What a killed writer left unfinished gets a line of its own, that no reader accepts."""
        text = self._path.read_bytes()
        if text and not text.endswith(b"\n"):
            self._file.write("\n")


def read_records(output: Path) -> dict[str, dict[str, Any]]:
    """The last word on each key: its result, or {'status': 'killed'} where a run was started and no more.

    A result is never replaced by a later failure.
    """
    latest: dict[str, dict[str, Any]] = {}
    for line in _lines(output):
        known = latest.get(line["key"])
        if known is not None and known["status"] in RESULTS:
            continue
        if line["event"] == "result":
            latest[line["key"]] = line
        else:
            latest[line["key"]] = {
                "key": line["key"],
                "status": "killed",
                "error": "the run was started and never ended",
            }
    return latest


def _lines(output: Path) -> Iterator[dict[str, Any]]:
    for path in sorted((output / FOLDER).glob("*.jsonl")):
        with path.open(encoding="utf-8", errors="replace") as file:
            for text in file:
                try:
                    line = json.loads(text)
                except ValueError:
                    continue
                if isinstance(line, dict) and {"key", "event"} <= line.keys():
                    yield line
