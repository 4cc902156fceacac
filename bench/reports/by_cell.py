"""Records of studies without random numbers, one result per cell; effects hidden in synthetic data."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd

from bench.jobs.lines import RunLine, ending
from bench.jobs.records import read_records
from bench.plan.naming import cell_name, run_columns
from bench.plan.plan import Cell, Plan, Run
from ksmea.records.record import Record
from ksmea.show.text import HIDDEN_COLUMN, hidden_text

AnyRecord = TypeVar("AnyRecord", bound=Record)
Said = TypeVar("Said", bound=Hashable)
Lines = Mapping[str, RunLine]  # what became of each run, by its key


def run_lines(plan: Plan, output: Path) -> Lines:
    """The last word on each run in the folder of an experiment."""
    return read_records(output, plan=plan)


def plain_runs(plan: Plan, lines: Lines) -> pd.DataFrame:
    """A row per planned run: its cell and axes, repetition, status and error."""
    return pd.DataFrame([_place(plan, run, lines) for run in plan.runs])


def result_runs(
    plan: Plan, lines: Lines, record_type: type[AnyRecord], row: Callable[[AnyRecord, Cell], dict[str, Any]]
) -> pd.DataFrame:
    """A row per planned run as in `plain_runs`, extended by `row(record, cell)` if the run has a result."""
    rows = []
    for run in plan.runs:
        line, cell = lines.get(run.key), plan.cells[run.cell]
        found = row(line.record(record_type), cell) if line is not None and line.has_result else {}
        rows.append(_place(plan, run, lines) | found)
    return pd.DataFrame(rows)


def _place(plan: Plan, run: Run, lines: Lines) -> dict[str, Any]:
    return run_columns(plan, run, *ending(lines.get(run.key)))


def first_results(plan: Plan, lines: Lines, record_type: type[AnyRecord]) -> dict[int, AnyRecord]:
    """The record of each cell that has a result, in the order of the cells."""
    found: dict[int, AnyRecord] = {}
    for run in plan.runs:
        line = lines.get(run.key)
        if run.cell not in found and line is not None and line.has_result:
            found[run.cell] = line.record(record_type)
    return dict(sorted(found.items()))


def only_result(plan: Plan, lines: Lines, record_type: type[AnyRecord]) -> tuple[Cell, AnyRecord] | None:
    """Cell and record of the only run of a plan; None if it has several runs, or no result."""
    line = lines.get(plan.runs[0].key) if len(plan.runs) == 1 else None
    if line is None or not line.has_result:
        return None
    return plan.cells[plan.runs[0].cell], line.record(record_type)


def said_once(by_cell: Mapping[int, Iterable[Said]]) -> dict[int, list[Said]]:
    """Statements about each cell, without repeating any made about an earlier cell.

    >>> said_once({0: ["a", "b"], 2: ["b", "c"]})
    {0: ['a', 'b'], 2: ['c']}
    """
    first: dict[Said, int] = {}
    for cell, said in by_cell.items():
        for each in said:
            first.setdefault(each, cell)
    return {cell: [each for each, at in first.items() if at == cell] for cell in by_cell}


def hidden_by_cell(runs: pd.DataFrame) -> dict[int, str]:
    """By cell, names, locations and values, of cells with one run: of several, each draws its own."""
    with_hidden = runs[runs[HIDDEN_COLUMN].notna()] if HIDDEN_COLUMN in runs else runs[:0]
    return {
        int(str(cell)): str(mine[HIDDEN_COLUMN].item()) for cell, mine in with_hidden.groupby("cell") if len(mine) == 1
    }


def hidden_paragraph(plan: Plan, runs: pd.DataFrame, study: str) -> str:
    """Hidden effects as text below a table, or a reference to runs.csv; empty if nothing is hidden."""
    hidden = hidden_by_cell(runs)
    if not hidden and HIDDEN_COLUMN in runs and runs[HIDDEN_COLUMN].notna().any():
        return hidden_text([f"drawn by each run: {HIDDEN_COLUMN} in runs.csv"], study)
    names = {cell: f"{cell_name(plan, plan.cells[cell])}: " if len(plan.cells) > 1 else "" for cell in hidden}
    return hidden_text([names[cell] + text for cell, text in hidden.items()], study)
