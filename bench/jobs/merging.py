"""Records of several folders in one.

Lines stay as they are in their files; runs that an earlier folder has done are left out.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

from bench.jobs.lines import RunLine, SessionLine, read_line
from bench.jobs.processors import processor
from bench.jobs.records import FOLDER, read_records, record_file
from bench.plan.merging import Part
from ksmea.settings.regular_files import open_regular

# What may differ between two computations of one run: times, and where it was done.
OF_ONE_COMPUTATION = ("seconds", "elapsed", "taken_from", "platform")


class Twice(NamedTuple):
    """Runs that two parts have done both.

    How many, those whose results differ otherwise than by times, and on what kinds of processors these were computed in
    each.
    """

    n_run: int
    differing: tuple[str, ...]
    processors: tuple[str, str]


def merge_records(parts: Sequence[Part], output: Path) -> None:
    """Write the lines of all parts.

    Lines of a run that an earlier part has done are left out, and so are lines that an earlier part has too.
    """
    numbers = count()
    done: set[str] = set()
    written: set[bytes] = set()  # digests of lines
    for part in parts:
        for path in sorted((part.folder / FOLDER).glob("*.jsonl")):
            target = record_file(output, next(numbers))
            target.parent.mkdir(parents=True, exist_ok=True)
            with open_regular(target, "xb") as file:
                for text in _wanted(path, done, written):
                    file.write(text)
        done |= part.finished


def _wanted(path: Path, done: set[str], written: set[bytes]) -> Iterator[bytes]:
    """The lines of a file that are not there yet, each session before the first of its runs."""
    sessions: dict[str, bytes] = {}
    with open_regular(path) as file:
        for text in file:
            line = read_line(text, path)
            if isinstance(line, SessionLine):
                sessions[line.session] = text
            elif line is not None and line.key not in done and (digest := hashlib.sha256(text).digest()) not in written:
                written.add(digest)
                yield sessions.pop(line.session, b"")
                yield text if text.endswith(b"\n") else text + b"\n"


def done_twice(before: Sequence[Part], part: Part) -> Twice:
    """The runs of a part that parts before it have done too, compared with the first of these."""
    earlier: dict[str, tuple[str, str]] = {}
    for other in before:
        keys = other.finished & part.finished - earlier.keys()
        earlier |= _results(other, keys)
    now = _results(part, part.finished & earlier.keys())
    differing = tuple(key for key in now if now[key][0] != earlier[key][0])
    there, here = ({results[key][1] for key in differing} for results in (earlier, now))
    return Twice(len(now), differing, (", ".join(sorted(there)), ", ".join(sorted(here))))


def _results(part: Part, keys: AbstractSet[str]) -> dict[str, tuple[str, str]]:
    """Digest of each result, and the processor that it was computed on, by key.

    The digest leaves out the parts that belong to one computation.
    """
    if not keys:
        return {}

    def digest_and_processor(line: RunLine) -> tuple[str, str] | None:
        return (_digest(line), processor(line)) if line.key in keys and line.has_result else None

    found = read_records(part.folder, digest_and_processor, part.plan)
    return {key: each for key, each in found.items() if each is not None}


def _digest(line: RunLine) -> str:
    return hashlib.sha256(json.dumps(_lasting(line.content()), sort_keys=True).encode()).hexdigest()


def _lasting(content: Any) -> Any:
    """JSON data without what belongs to one computation."""
    if isinstance(content, Mapping):
        return {name: _lasting(value) for name, value in content.items() if name not in OF_ONE_COMPUTATION}
    return [_lasting(each) for each in content] if isinstance(content, list) else content
