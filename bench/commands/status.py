"""`status NAME|DIR`: number of planned runs by status.

They are done, running, interrupted, failed, stale or missing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from bench.commands.folders import folders
from bench.jobs.lines import RESULTS, UNREADABLE, RunLine
from bench.jobs.processors import counted_processors, mixed_processors, processor
from bench.jobs.records import INTERRUPTED, RUNNING, damage_notes, read_records
from bench.jobs.submitted import job_states
from bench.plan.plan import Plan, Run, answered_by, key_of, read_plan
from bench.plan.provenance import code_digest, library_versions, used_modules
from ksmea.errors import SettingError, shortened, visible

UNKNOWN = "unknown"  # whether a result is stale cannot be said
NOT_ENDED = (RUNNING, INTERRUPTED, "stale", UNKNOWN, "missing")  # states of runs without a result that counts
WHY = {"stale": "answered by other code or libraries", INTERRUPTED: "the same command does them again"}
LONGEST = 1000  # characters of a note
WIDTH = len(INTERRUPTED)  # of labels


class _RunFacts(NamedTuple):
    """State, question and processor of a run, from its record."""

    state: str
    question: str
    processor: str


def status(words: list[str]) -> int:
    """Print the counts; 0 where all planned runs are done."""
    return max(_status(output) for output in folders(words, "status"))


def _status(output: Path) -> int:
    plan = read_plan(output)

    def facts(line: RunLine) -> _RunFacts:
        return _RunFacts(line.status, line.question, processor(line))

    damaged: Counter[Path] = Counter()
    records = read_records(output, facts, plan, damaged)
    answered = {each.question for each in records.values() if each.state in RESULTS}
    answering, untold = _answering(plan)
    counts = Counter(_state(run, answering, records, answered) for run in plan.runs)
    n_done = sum(counts[state] for state in RESULTS)
    n_failed = sum(count for state, count in counts.items() if state not in (*RESULTS, *NOT_ENDED))
    print(visible(f"{plan.name} in {output}"))
    counted = {
        "planned": len(plan.runs),
        "done": n_done,
        **{state: counts[state] for state in (RUNNING, INTERRUPTED) if counts[state]},
        "failed": n_failed,
        "stale": counts["stale"],
        **({UNKNOWN: counts[UNKNOWN]} if counts[UNKNOWN] else {}),
        "missing": counts["missing"],
    }
    for label, count in counted.items():
        reasons = "; ".join(untold) if label == UNKNOWN else _reasons(counts, label)
        print(visible(f"{label:>{WIDTH}} {count:6d}{f'  ({reasons})' if reasons else ''}"))
    if submitted := job_states(output):
        counted_states = Counter(shortened(state, LONGEST) for state in submitted.values()).most_common()
        print(visible(f"{'jobs':>{WIDTH}} " + "; ".join(f"{count:6d} {state}" for state, count in counted_states)))
    known = {key: each.processor for key, each in records.items()}
    if mixed := mixed_processors(counted_processors(known, plan)):
        print(visible(f"note: {mixed}"))
    for note in (*plan.notes, *damage_notes(damaged)):
        print(visible(f"note: {shortened(note, LONGEST)}"))
    return 0 if n_done == len(plan.runs) else 1


def _answering(plan: Plan) -> tuple[dict[int, str], list[str]]:
    """Digest of the current code and libraries for each cell, and the reasons why other cells lack one.

    Reasons: a plugin is not installed, or two packages register its name.
    """
    found: dict[int, str] = {}
    untold: dict[str, None] = {}
    for index, cell in enumerate(plan.cells):
        try:
            found[index] = answered_by(code_digest(used_modules(cell.settings, plan.plugins)), library_versions())
        except SettingError as error:
            untold[shortened(str(error), LONGEST)] = None
    return found, list(untold)


def _state(run: Run, answering: Mapping[int, str], records: Mapping[str, _RunFacts], answered: set[str]) -> str:
    """A result is stale once its run has another key, by what was planned or by what is installed."""
    state = records[run.key].state if run.key in records else None
    if state in RESULTS:
        now = answering.get(run.cell)
        return UNKNOWN if now is None else state if run.key == key_of(run.question, now) else "stale"
    return state or ("stale" if run.question in answered else "missing")


def _reasons(counts: Counter[str], label: str) -> str:
    if label in WHY:
        return WHY[label] if counts[label] else ""
    shown = {"done": ("budget",), "failed": ("error", "timeout", "killed", UNREADABLE)}.get(label, ())
    return ", ".join(f"{counts[state]} {state}" for state in shown if counts[state])
