"""Identifications of measurements, each in plain sentences, and a table of all.

A figure shows data, fit and residuals.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pandas as pd

from bench.jobs.lines import RunLine
from bench.jobs.records import read_records
from bench.plan.fleet import is_of_fleet
from bench.plan.naming import cell_name, place_columns
from bench.plan.page import Block
from bench.plan.plan import Plan, Run
from bench.plan.report import Made, Report
from bench.reports.by_cell import run_lines
from bench.reports.design.next_steps import after_identification
from bench.reports.fleet.report import fleet_report
from bench.reports.fleet.rows import identified
from bench.reports.identification.page import identification_page
from bench.reports.runs import of_identifications
from bench.reports.tables import csv_text
from ksmea.records.identification import IdentificationRecord
from ksmea.show.identification_text import COLUMNS, frame, text
from ksmea.show.text import HIDDEN_COLUMN, hidden_in_one_line
from ksmea.show.weights_text import influence_frame

MAX_BLOCKS = 4  # runs with sentences and a figure; the tables have all


@dataclass(frozen=True)
class IdentificationReport(Report):
    study: ClassVar[str] = "identify"

    def make(self, plan: Plan, output: Path) -> Made:
        if is_of_fleet(plan):
            lines = run_lines(plan, output)
            return fleet_report(plan, of_identifications(plan, output), lines, IdentificationRecord, identified)
        records = read_records(output, lambda line: _record(line, plan.units), plan)
        runs = of_identifications(plan, output)
        found = {run: record for run in plan.runs if (record := records.get(run.key)) is not None}
        shown = dict(list(found.items())[:MAX_BLOCKS])
        blocks = [text(record, _title(plan, run, record)) for run, record in shown.items()]
        if len(found) > len(shown):
            blocks.append(f"and {len(found) - len(shown)} more in {plan.name}.csv")
        influence = _influence(found)
        drawn = _names(plan, shown)
        return Made(
            "\n\n".join(blocks) or "nothing was identified",
            {
                f"{plan.name}.csv": csv_text(identification_frame(plan, found)).encode(),
                "runs.csv": csv_text(runs).encode(),
                **({} if influence is None else {"influence.csv": csv_text(influence).encode()}),
            },
            runs,
            page=lambda: identification_page(
                [(_title(plan, run, record), record, drawn.get(run, "")) for run, record in shown.items()],
                _following(plan, shown),
            ),
        )


def _record(line: RunLine, units: str) -> IdentificationRecord | None:
    """The result of a run, shown in these units; None without one."""
    return line.record(IdentificationRecord).shown_in(units) if line.has_result else None


def identification_frame(plan: Plan, found: Mapping[Run, IdentificationRecord]) -> pd.DataFrame:
    """Tables of all runs, one below the other, with the place of each run.

    They are of `ksmea.show.identification_text.frame`.
    """
    frames = []
    for run, record in found.items():
        place = {"cell": run.cell, "repetition": run.repetition, **place_columns(plan, plan.cells[run.cell])}
        hidden = {HIDDEN_COLUMN: hidden_in_one_line(record.hidden)} if record.hidden else {}
        frames.append(frame(record).assign(**place, **hidden))
    if not frames:
        return pd.DataFrame(columns=[*COLUMNS, "cell", "repetition", *plan.axes])
    return pd.concat(frames, ignore_index=True)


def _influence(found: Mapping[Run, IdentificationRecord]) -> pd.DataFrame | None:
    """Influence coefficients of all runs of campaigns with weights; None without any."""
    frames = [
        influence_frame(record.weights).assign(cell=run.cell, repetition=run.repetition)
        for run, record in found.items()
        if record.weights is not None
    ]
    return pd.concat(frames, ignore_index=True) if frames else None


def _names(plan: Plan, shown: Mapping[Run, IdentificationRecord]) -> dict[Run, str]:
    """The name of each figure."""
    drawn = [run for run, record in shown.items() if record.fit is not None]
    return {run: f"{plan.name}{'' if index == 0 else f'_{index + 1}'}.png" for index, run in enumerate(drawn)}


def _following(plan: Plan, shown: Mapping[Run, IdentificationRecord]) -> list[Block]:
    """Next step; empty for several identifications."""
    if len(shown) != 1 or len(plan.runs) != 1:
        return []
    ((run, record),) = shown.items()
    return list(after_identification(plan, plan.cells[run.cell], record))


def _title(plan: Plan, run: Run, record: IdentificationRecord) -> str:
    """For example 'three_disk, run.csv', and what tells the run from the others."""
    parts = [plan.cells[run.cell].chosen("problem")]
    parts += [] if record.data is None else [record.data.source]
    parts += [cell_name(plan, plan.cells[run.cell])] if len(plan.cells) > 1 else []
    parts += [f"repetition {run.repetition}"] if any(other.repetition for other in plan.runs) else []
    return ", ".join(parts)
