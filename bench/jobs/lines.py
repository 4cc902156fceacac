"""Lines of record files as typed data: the session that computes runs, a run's start and its end.

In a file a line is one JSON object: the fields of a run's line together with the fields of its study's record. Of a
run's line only the former are read; the record is read when it is requested. The last field is the CRC-32 of all before
it, so that a line with a changed byte is damaged and no other value. Lines of older versions lack it.
"""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from ksmea.errors import SettingError
from ksmea.records.record import Record

SCHEMA = 3
UNREADABLE = "unreadable"  # status of a result whose record is none of the study that was asked for
RESULTS = ("done", "budget")  # statuses that are results; all others are failures
IDENTITY = ("schema", "event", "key", "question", "session")  # of a line, not of what stands in it
CHECKSUM = "crc32"
CHECKED = re.compile(rb'(.*), "crc32": "([0-9a-f]{8})"\}\s*', re.DOTALL)

AnyRecord = TypeVar("AnyRecord", bound=Record)


class SessionLine(msgspec.Struct, frozen=True, kw_only=True, tag_field="event", tag="session"):
    """Session in which one writer computes runs: commit, processor, library versions, module digests."""

    schema: int
    session: str
    began: str = "?"
    commit: str = "?"
    platform: str = ""
    versions: dict[str, str] = {}
    modules: dict[str, str] = {}


class RunLine(msgspec.Struct, frozen=True, kw_only=True, tag_field="event"):
    """Fields that every run has, in any study. Schema 1 had neither questions nor sessions."""

    schema: int
    key: str
    question: str = ""
    session: str = ""
    status: str
    error: str = ""  # why there is no result
    traceback: str = ""
    elapsed: float | None = None  # s
    taken_from: str = ""  # the folder of another experiment, which did this run
    platform: str = ""  # kind of processor that it was done on
    raw: bytes = b""  # the line as it stands in its file
    body: Any = None  # its record, where it was read before

    @property
    def has_result(self) -> bool:
        return self.status in RESULTS

    def record(self, record_type: type[AnyRecord]) -> AnyRecord:
        """The record of the run's study; `SettingError` if the line holds another one."""
        if type(self.body) is record_type:
            return self.body
        try:
            data = _loaded(self.raw)
        except (ValueError, RecursionError) as error:
            raise SettingError(f"{record_type.__name__}: expected JSON, could not read it: {error}") from error
        return record_type.from_data(data)

    def checked(self, record_type: type[Record]) -> RunLine:
        """This line with its record read, or as one without a result where the record cannot be."""
        try:
            return msgspec.structs.replace(self, body=self.record(record_type))
        except SettingError as error:
            return msgspec.structs.replace(self, status=UNREADABLE, error=str(error))

    def computed_on(self, platform: str) -> RunLine:
        """This line with the kind of processor that its session ran on.

        A line that was taken over and names its own is unchanged.
        """
        return self if self.platform else msgspec.structs.replace(self, platform=platform)

    def content(self) -> dict[str, Any]:
        """Status, error and the study's record as JSON data, without what identifies the line."""
        known = {"status": self.status} | ({"error": self.error} if self.error else {})
        return known | {name: value for name, value in _loaded(self.raw).items() if name not in (*IDENTITY, CHECKSUM)}


class Started(RunLine, frozen=True, kw_only=True, tag_field="event", tag="started"):
    """A run was started. As the last word on it, that it was killed."""

    status: str = "killed"
    error: str = "it was stopped before its end, by Ctrl-C, a kill or a crash; the same command does it again"


class Ended(RunLine, frozen=True, kw_only=True, tag_field="event", tag="result"):
    """A run has a result, or has failed."""


Line = SessionLine | Started | Ended
EVENTS = ("session", "started", "result")
_decoder = msgspec.json.Decoder(Line)
_encoder = msgspec.json.Encoder(enc_hook=lambda value: value.tolist())  # numbers of numpy


@dataclass(frozen=True)
class FailedRun(Record):
    """Outcome of a run without a result; `status` is error, timeout or killed."""

    status: str
    error: str
    traceback: str = ""


def ending(line: RunLine | None) -> tuple[str, str]:
    """Status and error of a planned run, whose line is None if no attempt was made."""
    return ("not run", "") if line is None else (line.status, line.error)


def line_text(line: Line, content: Mapping[str, Any] | None = None) -> bytes:
    """A line as its file has it; `content` stands in the place of status and error.

    Values that are not finite become null.
    """
    data: dict[str, Any] = msgspec.to_builtins(line)
    for name in ("raw", "body"):
        data.pop(name, None)
    if content is not None:
        data = {**{name: data[name] for name in IDENTITY}, **content}
    text = msgspec.json.format(_encoder.encode(data), indent=0).removesuffix(b"}")
    return text + f', "{CHECKSUM}": "{zlib.crc32(text):08x}"}}\n'.encode()


def read_line(text: bytes, path: Path) -> Line | None:
    """Parse a line of a record file; None if damaged, `SettingError` if a newer version wrote it."""
    if (checked := CHECKED.fullmatch(text)) and zlib.crc32(checked[1]) != int(checked[2], 16):
        return None
    try:
        line = _decoder.decode(text)
    except (msgspec.MsgspecError, RecursionError, ValueError):
        line = _read_slowly(text, path)
    if line is None:
        return None
    _check_schema(line.schema, path)
    return line if isinstance(line, SessionLine) else msgspec.structs.replace(line, raw=text, body=None)


def _read_slowly(text: bytes, path: Path) -> Line | None:
    """A line that holds a NaN, as a curve may in older files, or is of a newer schema."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if isinstance(data, dict) and data.get("event") in EVENTS and isinstance(data.get("schema"), int):
        _check_schema(data["schema"], path)
    try:
        line: Line = msgspec.convert(data, Line)
    except (msgspec.ValidationError, ValueError, OverflowError):
        return None
    return line


def _check_schema(schema: int, path: Path) -> None:
    if schema > SCHEMA:
        raise SettingError(
            f"{path}: expected records up to schema {SCHEMA}, found {schema}: a newer version wrote them;"
            " install that one, or choose another output=DIR"
        )


def _loaded(text: bytes) -> Any:
    try:
        return msgspec.json.decode(text)
    except msgspec.DecodeError:
        return json.loads(text)  # slower, and it reads the NaN that a curve may hold
