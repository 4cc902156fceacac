"""The kinds of processors that the results of an experiment were computed on.

Their last digits depend on it, their keys do not, so that a sweep can be spread over or resumed on others.
"""
# Shorter than 40 lines: one remark, which tables and `status` share.

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from bench.jobs.lines import RunLine
from bench.jobs.records import read_records
from bench.plan.plan import Plan


def processor(line: RunLine) -> str:
    """Kind of processor that computed a result (`bench.plan.provenance.platform_name`).

    Empty if its record does not name one, or the run has no result.
    """
    return line.platform if line.has_result else ""


def processors(output: Path, damaged: Counter[Path] | None = None) -> dict[str, str]:
    """Kind of processor of each result, by key; `damaged` counts unreadable lines of the record files."""
    return read_records(output, processor, damaged=damaged)


def counted_processors(known: Mapping[str, str], plan: Plan) -> Counter[str]:
    """Number of planned runs with a result computed on each processor, by known processors of their keys."""
    return Counter(known[key] for key in {run.key for run in plan.runs} if known.get(key))


def mixed_processors(counts: Counter[str]) -> str:
    """One line where the results of the planned runs were computed on several kinds of processors.

    Otherwise empty.
    """
    if len(counts) < 2:
        return ""
    counted = ", ".join(f"{processor}: {count}" for processor, count in counts.most_common())
    return f"runs were computed on several kinds of processors ({counted}): results may differ from the fifth digit"
