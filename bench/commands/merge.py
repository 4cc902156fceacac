"""`merge NAME|DIR NAME|DIR … --out DIR`: parts of one experiment in one folder.

An example is a contest that several people compute.

The new folder has one plan and the records of all, as they are; `collect` makes its tables. It is there whole or not at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bench.commands.folders import one_folder, with_option
from bench.jobs.merging import done_twice, merge_records
from bench.jobs.presence import numbers_at_work
from bench.jobs.records import damage_notes, damaged_lines, finished_keys, running_sessions
from bench.plan.merging import Part, merged_plan
from bench.plan.plan import read_plan, write_plan
from bench.plan.report import report_named
from bench.storage.files import new_folder
from ksmea.errors import SettingError, visible

OUT = "--out"


def merge(words: list[str]) -> int:
    """Write the new folder, and print what came from where."""
    names, out = with_option(words, OUT, "merge")
    if len(names) < 2 or out is None:
        raise SettingError("merge: expected two folders of results or more and --out DIR, got fewer; name them all")
    output = Path(out)
    with new_folder(output) as partial:
        parts = [_part(name) for name in names]
        plan = merged_plan(parts)
        report_named(plan.report.table).check_plan(plan)
        merge_records(parts, partial)
        write_plan(plan, partial)  # the last: what has no plan is taken for no results
    finished = {key for part in parts for key in part.finished}
    n_done = sum(run.key in finished for run in plan.runs)
    print(visible(f"{plan.name}: {len(plan.cells)} cells, {len(plan.runs)} runs, {n_done} with a result, in {output}"))
    for number, part in enumerate(parts):
        print(visible(f"  {_part_line(part, parts[:number])}"))
    for note in (*plan.notes, *(note for part in parts for note in damage_notes(damaged_lines(part.folder)))):
        print(visible(f"note: {note}"))
    print(visible(f"tables and figures: python -m bench collect {output}"))
    return 0


def _part(name: str) -> Part:
    folder = one_folder([name], "merge")
    if numbers_at_work(folder) or running_sessions(folder):
        raise SettingError(f"merge: jobs are at work in {folder}; wait for them to end")
    plan = read_plan(folder)
    return Part(folder, plan, {run.key for run in plan.runs} & finished_keys(folder, plan))


def _part_line(part: Part, before: Sequence[Part]) -> str:
    """Summary of one part: its results, how many an earlier part also has, and how many of these differ."""
    line = (
        f"{part.folder}: {len(part.finished)} of {len(part.plan.runs)} runs with a result (commit {part.plan.commit})"
    )
    twice = done_twice(before, part)
    if twice.n_run:
        line += f", {twice.n_run} of them in an earlier folder too, whose results are kept"
    if twice.differing:
        there, here = twice.processors
        line += (
            f"; {len(twice.differing)} of these differ by more than times, as {twice.differing[0]}: there on {there}, here on"
            f" {here}"
        )
    return line
