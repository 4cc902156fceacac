"""The report `identifiability`: a section per cell, one table of all, and figures of the first cells."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pandas as pd

from bench.plan.assumed_values import assumed_note
from bench.plan.naming import cell_name, place_columns
from bench.plan.page import Block, Command, Prose
from bench.plan.plan import Plan
from bench.plan.report import Made, Report
from bench.reports.by_cell import first_results, plain_runs, run_lines, said_once
from bench.reports.design.next_steps import as_text, before_looking_ahead
from bench.reports.design.page import identifiability_page
from bench.reports.tables import csv_text
from ksmea.records.identifiability import IdentifiabilityRecord
from ksmea.show.identifiability_text import COLUMNS, frame, text

MAX_CELLS = 4  # with a figure and a table of variations each; the file has all


@dataclass(frozen=True)
class IdentifiabilityReport(Report):
    study: ClassVar[str] = "identifiability"

    def make(self, plan: Plan, output: Path) -> Made:
        lines = run_lines(plan, output)
        runs = plain_runs(plan, lines)
        found = first_results(plan, lines, IdentifiabilityRecord)
        notes = said_once({cell: filter(None, [assumed_note(plan.cells[cell])]) for cell in found})
        first = said_once({cell: _first(plan, cell, record) for cell, record in found.items()})
        sections = [
            "\n\n".join(
                [
                    text(record, _title(plan, cell), with_variations=index < MAX_CELLS),
                    *notes[cell],
                    *as_text(first[cell]),
                ]
            )
            for index, (cell, record) in enumerate(found.items())
        ]
        table = csv_text(_frame(plan, found))
        return Made(
            "\n\n".join(sections),
            {f"{plan.name}.csv": table.encode(), "runs.csv": csv_text(runs).encode()},
            runs,
            page=lambda: identifiability_page(
                {_title(plan, cell): record for cell, record in found.items()},
                [_names(plan, found).get(cell, "") for cell in found],
                _frame(plan, found),
                f"{plan.name}.csv",
                [block for cell in found for block in _following(notes[cell], first[cell])],
            ),
        )


def _following(notes: Sequence[str], first: Sequence[Command]) -> Iterator[Block]:
    """Values to give in place of assumed ones, and what to do before this is relied on."""
    yield from map(Prose, notes)
    yield from first


def _first(plan: Plan, cell: int, record: IdentifiabilityRecord) -> Iterator[Command]:
    """Steps before the result is used."""
    yield from before_looking_ahead(plan, plan.cells[cell], record.lack_of_fit)


def _frame(plan: Plan, found: Mapping[int, IdentifiabilityRecord]) -> pd.DataFrame:
    """The rows of all cells, and where each cell stands."""
    rows = [
        {"cell": cell, **place_columns(plan, plan.cells[cell]), **row}
        for cell, record in found.items()
        for row in frame(record).to_dict("records")
    ]
    return pd.DataFrame(rows, columns=None if rows else ["cell", *plan.axes, *COLUMNS])


def _names(plan: Plan, found: Mapping[int, IdentifiabilityRecord]) -> dict[int, str]:
    """The names of pictures, one for each of the first cells whose data were varied."""
    drawn = [cell for cell, record in found.items() if record.variations][:MAX_CELLS]
    return {cell: f"{plan.name}{'' if index == 0 else f'_{index + 1}'}.png" for index, cell in enumerate(drawn)}


def _title(plan: Plan, cell: int) -> str:
    problem = plan.cells[cell].chosen("problem")
    return problem if len(plan.cells) == 1 else f"{problem}: {cell_name(plan, plan.cells[cell])}"
