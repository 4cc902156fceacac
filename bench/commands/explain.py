"""`explain KEY [NAME|DIR]`: a run's settings, what became of it and why it is stale or failed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bench.commands.folders import folders
from bench.jobs.lines import SCHEMA, Ended, SessionLine
from bench.jobs.processors import processor
from bench.jobs.records import read_lines, read_records
from bench.plan.naming import place_text
from bench.plan.outside import is_distribution, is_file
from bench.plan.plan import PLAN_FILE, Plan, Run, read_plan
from bench.plan.provenance import code_digest, library_versions, used_modules
from ksmea.errors import SettingError, shortened, visible_lines

MOST_ATTEMPTS = 20
LONGEST, LONGEST_TRACEBACK = 2000, 20_000  # characters that are shown


def explain(words: list[str]) -> int:
    """Print what is known of the run that a key, or the beginning of one, belongs to."""
    if not words:
        raise SettingError("explain: expected the key of a run (see runs.csv), got nothing")
    key, *name = words
    searched = (
        folders(name, "explain") if name else sorted(path.parent for path in Path("results").glob(f"**/{PLAN_FILE}"))
    )
    for folder in searched:
        try:
            plan = read_plan(folder)
        except SettingError:
            if name:
                raise
            continue  # the plan of another experiment, which nobody asked for
        for run in plan.runs:
            if run.key.startswith(key):
                print(visible_lines(_explanation(plan, run, folder)))
                return 0
    looked = ", ".join(map(str, searched)) or "results/*"
    raise SettingError(
        f"explain: expected the key of a planned run, found no {shortened(repr(key))} in {looked}; runs.csv lists them"
    )


def _explanation(plan: Plan, run: Run, folder: Path) -> str:
    cell = plan.cells[run.cell]
    place = ", ".join(f"{axis}={place_text(value)}" for axis, value in cell.place.items())
    try:
        used: Mapping[str, str] = used_modules(cell.settings, plan.plugins)
        changed = _what_changed_since_the_plan(plan, cell.code, used)
    except SettingError as error:  # a plugin that is no longer there
        used = plan.modules
        changed = [f"the changes since it was planned are not known: {error}"]
    lines = [f"run {run.key} of {plan.name} in {folder}: {place}, seed {cell.seed}, repetition {run.repetition}"]
    for part, settings in cell.settings.items():
        lines.append(f"  {part}: {_in_words(settings)}")
    attempts = [line.status for line in read_lines(folder) if isinstance(line, Ended) and line.key == run.key]
    last = read_records(folder, lambda line: line if line.key == run.key else None, plan).get(run.key)
    if last is None:
        lines += _why_stale(plan, run, folder, used) or ["missing: no attempt was made"]
    else:
        done_on = processor(last)
        why = _beginning(last.error)
        lines.append(f"{_beginning(last.status)}{': ' + why if why else ''}{f' on {done_on}' if done_on else ''}")
        if last.traceback:
            lines.append(_end(last.traceback.rstrip()))
        if len(attempts) > 1:
            lines.append(f"{len(attempts)} attempts: {', '.join(map(_beginning, attempts[-MOST_ATTEMPTS:]))}")
        if last.taken_from:
            lines.append(_beginning(f"taken over from {last.taken_from}"))
    lines += changed
    return "\n".join(lines)


def _beginning(text: str) -> str:
    return text if len(text) <= LONGEST else text[:LONGEST] + "…"


def _end(text: str) -> str:
    """The last lines of a traceback, which say what was wrong."""
    return text if len(text) <= LONGEST_TRACEBACK else "…" + text[-LONGEST_TRACEBACK:]


def _in_words(settings: Any) -> str:
    return _beginning(_said(settings))


def _said(settings: Any) -> str:
    if not isinstance(settings, Mapping):
        return "makes no difference" if settings is None else str(settings)
    return ", ".join(
        [str(settings.get("name", "?")), *(f"{key}={value}" for key, value in settings.items() if key != "name")]
    )


def _why_stale(plan: Plan, run: Run, folder: Path, used: Mapping[str, str]) -> list[str]:
    """Differences between the plan and the session that answered its question."""
    sessions: dict[str, SessionLine] = {}
    answered_in: str | None = None
    for line in read_lines(folder):
        if isinstance(line, SessionLine):
            sessions[line.session] = line
        elif line.question == run.question and line.has_result:
            answered_in = line.session
    if answered_in is None:
        return []
    session = sessions.get(answered_in, SessionLine(schema=SCHEMA, session=""))
    changed = _differences(session.versions, plan.versions)
    changed += _code_differences(session.modules, plan.modules, used)
    reason = "; ".join(changed) or "the set of modules that it uses"
    place = f" by {session.platform}" if session.platform else ""
    return [f"stale: answered on {session.began}{place} at commit {session.commit}; changed since: {reason}"]


def _what_changed_since_the_plan(plan: Plan, code: str, used: Mapping[str, str]) -> list[str]:
    changed = _differences(plan.versions, library_versions())
    if code_digest(used) != code:
        changed += _code_differences(plan.modules, used, used)
    return (
        [f"since it was planned these have changed, the next call plans it anew: {'; '.join(changed)}"]
        if changed
        else []
    )


def _code_differences(before: Mapping[str, str], after: Mapping[str, str], used: Mapping[str, str]) -> list[str]:
    """Differing modules, files and distributions of a run, and missing files from outside."""
    tops = {name.partition("/")[0] for name in used if is_file(name)}
    gone = [name for name in before if is_file(name) and name not in after and name.partition("/")[0] in tops]
    changed = []
    for name in dict.fromkeys([*used, *gone]):
        if before.get(name) != after.get(name):
            versions = f" {before.get(name)} → {after.get(name)}" if is_distribution(name) else ""
            changed.append(name + versions)
    return changed


def _differences(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    """Entries of `before` that `after` has otherwise."""
    return [f"{name} {value} → {after.get(name)}" for name, value in before.items() if value != after.get(name)]
