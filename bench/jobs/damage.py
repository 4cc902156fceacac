"""Lines of record files that are no records: torn by a killed writer, or damaged since. They are passed over, and told."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from bench.jobs.records import read_lines


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
