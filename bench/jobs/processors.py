"""The kinds of processors that the results of an experiment were computed on: their last digits depend on it, their keys
do not, so that a sweep can be spread over or resumed on others."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from bench.jobs.lines import SessionLine
from bench.jobs.records import read_lines
from bench.plan.plan import Plan


def processors(output: Path) -> dict[str, str]:
    """What each result was computed on (`bench.plan.provenance.platform_name`), by key, where its record says so."""
    sessions: dict[str, str] = {}
    found: dict[str, str] = {}
    for line in read_lines(output):
        if isinstance(line, SessionLine):
            sessions[line.session] = line.platform
        elif line.has_result and (processor := line.platform or sessions.get(line.session)):
            found.setdefault(line.key, processor)
    return found


def counted_processors(output: Path, plan: Plan) -> Counter[str]:
    """How many of the planned runs have a result that was computed on each."""
    known = processors(output)
    return Counter(known[key] for key in {run.key for run in plan.runs} if key in known)


def mixed_processors(output: Path, plan: Plan) -> str:
    """One line where the results of the planned runs were computed on several kinds of processors; else empty."""
    counts = counted_processors(output, plan)
    if len(counts) < 2:
        return ""
    counted = ", ".join(f"{processor}: {count}" for processor, count in counts.most_common())
    return f"runs were computed on several kinds of processors ({counted}): results may differ from the fifth digit"
