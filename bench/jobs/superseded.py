"""Results of an earlier plan in a folder that a new plan no longer shows, and how to show them again."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

from bench.jobs.records import FOLDER as RECORDS
from bench.jobs.records import finished_keys
from bench.plan.folder import FILE, planned_before
from bench.plan.plan import Cell, Plan
from bench.plan.setup import FINGERPRINTS


def earlier_notes(plan: Plan, output: Path) -> list[str]:
    """Notes on earlier results in a folder that a new plan no longer shows, and how to show them again.

    Their own command shows them again, unless a file that it names has other content by now. Empty if the plan shows
    all.
    """
    found = planned_before(output)
    if found is None:
        return []
    asked = {run.question for run in plan.runs}
    left_out = {run.key: found.cells[run.cell] for run in found.runs if run.question not in asked}
    finished = finished_keys(output) & left_out.keys() if left_out else set()
    contents = _contents(plan)
    changed = {key: _changed(left_out[key], contents) for key in finished}
    lost = [key for key in finished if changed[key] or found.command == plan.command]
    notes = [
        _can_be_shown(len(finished) - len(lost), found.command),
        _of_earlier_contents(len(lost), sorted({file for key in lost for file in changed[key]})),
    ]
    return [f"note: {each}" for each in notes if each]


def _can_be_shown(n: int, command: Sequence[str]) -> str:
    if not n:
        return ""
    again = (
        "its record is kept, and its command shows it"
        if n == 1
        else "their records are kept, and their command shows them"
    )
    words = shlex.join(["python", "-m", "bench", *command])
    return f"{_left_out(n, 'of other settings or files')}: {again} again: {words} (another output=DIR keeps both side by side)"


def _of_earlier_contents(n: int, files: Sequence[str]) -> str:
    """Note on `n` results computed from earlier contents of `files`; '' if `n` is 0.

    `files` is empty if the difference is not known, although the command is the same.
    """
    if not n:
        return ""
    kept = "its record is" if n == 1 else "their records are"
    if not files:
        return f"{_left_out(n, 'of this command with earlier files or another version of the bench')}: {kept} kept in {RECORDS}/"
    which = _left_out(n, f"of an earlier content of {', '.join(files)}")
    return f"{which}: {kept} kept in {RECORDS}/, and shown again only with that content (another output=DIR keeps both side by side)"


def _left_out(n: int, which: str) -> str:
    return f"{n} earlier result{'s' * (n > 1)} in this folder, {which}, {'is' if n == 1 else 'are'} no longer shown"


def _contents(plan: Plan) -> dict[str, set[str]]:
    """Hashes of what each file of a plan holds, by the file as its command names it."""
    held: dict[str, set[str]] = {}
    for cell in plan.cells:
        for file, fingerprint in _files(cell):
            held.setdefault(file, set()).add(fingerprint)
    return held


def _changed(cell: Cell, contents: Mapping[str, Collection[str]]) -> list[str]:
    """The files of an earlier cell that hold something else now."""
    return [file for file, fingerprint in _files(cell) if file in contents and fingerprint not in contents[file]]


def _files(cell: Cell) -> Iterator[tuple[str, str]]:
    """Rotor file, measurement file and tables of a rotor file, with their hashes at planning."""
    for group, name in FILE.items():
        file, fingerprint = (cell.settings.get(group) or {}).get(name), cell.settings.get(FINGERPRINTS[group])
        if file and fingerprint:
            own, *named = str(fingerprint).split("; ")
            yield str(file), own
            for content, _, path in (each.partition(" ") for each in named):
                yield str(Path(file).parent / path), content
