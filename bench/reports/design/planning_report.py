"""Report `plan`: plans in sentences, one table, and a chart with a stack of panels per cell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd

from bench.jobs.lines import RunLine, ending
from bench.plan.assumed_values import assumed_note
from bench.plan.naming import cell_name, telling_axes
from bench.plan.page import Command
from bench.plan.plan import Plan, Run
from bench.plan.report import Made, Report
from bench.reports.by_cell import first_results, run_lines, said_once
from bench.reports.design.next_measurement import Next, next_measurement
from bench.reports.design.next_steps import after_plan, as_text, before_looking_ahead
from bench.reports.design.page import plan_page
from bench.reports.tables import csv_text
from ksmea.records.planning import PlanningRecord
from ksmea.show.planning_text import frame, text


@dataclass(frozen=True)
class PlanReport(Report):
    study: ClassVar[str] = "plan"

    def make(self, plan: Plan, output: Path) -> Made:
        lines = run_lines(plan, output)
        runs = pd.DataFrame([_run_row(plan, run, lines.get(run.key)) for run in plan.runs])
        found = first_results(plan, lines, PlanningRecord)
        following = {cell: next_measurement(plan, plan.cells[cell], found[cell].trial_run, output) for cell in found}
        if len(found) > 1:  # files of one name for all of them
            following = {cell: each for cell, each in following.items() if each and not each.files}
        first = said_once({cell: _first(plan, cell, record) for cell, record in found.items()})
        notes = said_once({cell: filter(None, [assumed_note(plan.cells[cell])]) for cell in found})
        sections = [
            _section(_said(record, notes[cell], _title(plan, cell, ":")), first[cell], following.get(cell))
            for cell, record in found.items()
        ]
        files = {f"{plan.name}.csv": csv_text(_frame(plan, found)).encode(), "runs.csv": csv_text(runs).encode()}
        files |= {name: content for each in following.values() if each for name, content in each.files.items()}
        return Made(
            "\n\n".join(sections),
            files,
            runs,
            page=lambda: plan_page(
                [(_title(plan, cell), _said(record, notes[cell]), record) for cell, record in found.items()],
                [
                    *(block for blocks in first.values() for block in blocks),
                    *(block for each in following.values() for block in after_plan(each)),
                ],
                _frame(plan, found),
                plan.name,
            ),
        )


def _section(said: str, first: Sequence[Command], following: Next | None) -> str:
    """Plan of one cell, cautions, and the consequences of the trial run that it recommends."""
    return "\n\n".join([said, *as_text(first), *([following.text] if following else [])])


def _said(record: PlanningRecord, notes: Sequence[str], title: str = "") -> str:
    """The text of a plan, and which values were assumed for it."""
    return "\n".join([text(record, title), *notes])


def _first(plan: Plan, cell: int, record: PlanningRecord) -> Iterator[Command]:
    yield from before_looking_ahead(plan, plan.cells[cell], record.lack_of_fit)


def _frame(plan: Plan, found: Mapping[int, PlanningRecord]) -> pd.DataFrame:
    """The rows of all cells, and where each cell stands."""
    return pd.DataFrame(
        [
            {**_cell_columns(plan, cell), **row}
            for cell, record in found.items()
            for row in frame(record).to_dict("records")
        ]
    )


def _run_row(plan: Plan, run: Run, line: RunLine | None) -> dict[str, Any]:
    status, error = ending(line)
    return {
        "key": run.key,
        "cell": run.cell,
        **_cell_columns(plan, run.cell),
        "seed": plan.cells[run.cell].seed,
        "repetition": run.repetition,
        "status": status,
        "error": error,
    }


def _cell_columns(plan: Plan, cell: int) -> dict[str, str | float | None]:
    """Values of a cell on the axes that distinguish it from others."""
    values = {axis: plan.cells[cell].place.get(axis) for axis in telling_axes(plan)}
    values = {axis: str(value) if isinstance(value, (list, dict)) else value for axis, value in values.items()}
    return {axis: value for axis, value in values.items() if axis != "samples" or value is not None}


def _title(plan: Plan, cell: int, end: str = "") -> str:
    """The cell's name where there are several."""
    return f"{cell_name(plan, plan.cells[cell])}{end}" if len(plan.cells) > 1 else ""
