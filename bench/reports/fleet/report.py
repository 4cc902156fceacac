"""A fleet in one table and one page.

A row per measured file, with what was found of its machine or why nothing was.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import pandas as pd

from bench.jobs.lines import ending
from bench.plan.fleet import MEASURED
from bench.plan.naming import place_columns, place_text, telling_axes
from bench.plan.page import Page
from bench.plan.plan import Plan, Run
from bench.plan.report import Made
from bench.reports.by_cell import Lines
from bench.reports.fleet.page import fleet_page
from bench.reports.fleet.rows import MachineRow
from bench.reports.pages.experiment import PAGE
from bench.reports.runs import without_class
from bench.reports.tables import csv_text
from ksmea.errors import shortened
from ksmea.records.in_notation import InNotation
from ksmea.show.text import aligned

AnyRecord = TypeVar("AnyRecord", bound=InNotation)
FILE = "file"
VALUES = "values.csv"
LONGEST_REMARK = 200  # characters of what the terminal tells of one file; the page has all
MOST_ROWS = 100  # that the terminal shows


def fleet_report(
    plan: Plan,
    runs: pd.DataFrame,
    lines: Lines,
    record_type: type[AnyRecord],
    row: Callable[[AnyRecord], MachineRow],
    values_in_text: bool = True,
    outdated: tuple[str, ...] = (),
) -> Made:
    """The report of a plan over measured files, of a `row` of each run's record; `runs` goes to runs.csv.

    Text and page show each machine in the units and names of its own file, or in the units of the plan's command. Without
    `values_in_text` the unknowns are in the files and on the page alone.
    """
    ended = {run.key: lines[run.key] for run in plan.runs if run.key in lines}
    found = {key: row(line.record(record_type).shown_in(plan.units)) for key, line in ended.items() if line.has_result}
    table = pd.DataFrame([_columns(plan, run, lines, found.get(run.key)) for run in plan.runs])
    shown = pd.DataFrame([_shown(plan, run, lines, found.get(run.key)) for run in plan.runs]).fillna("")
    values = values_frame(plan, found)
    about = _about(plan, lines, found)
    files = {
        f"{plan.name}.csv": csv_text(table).encode(),
        VALUES: csv_text(values).encode(),
        "runs.csv": csv_text(runs).encode(),
    }

    def shown_page() -> Page:
        details = [(_name(plan, run), found[run.key].text) for run in plan.runs if run.key in found]
        return fleet_page(about, shown, values, details, f"{plan.name}.csv", f"{plan.name}.png")

    unknowns = [] if values_in_text else [name for row in found.values() for name in row.shown_values()]
    printed = shown.drop(columns=["remarks", *dict.fromkeys(unknowns)]).head(MOST_ROWS)
    blocks = [about, aligned(list(printed.columns), printed.to_numpy().tolist())]
    blocks += [f"and {len(shown) - MOST_ROWS} more in {plan.name}.csv"] if len(shown) > MOST_ROWS else []
    remarks = shown[shown["remarks"] != ""].head(MOST_ROWS)
    blocks += [
        "\n".join(f"{file}: {shortened(each, LONGEST_REMARK)}" for file, each in remarks[[FILE, "remarks"]].to_numpy())
    ]
    return Made(
        "\n\n".join(filter(None, [*blocks, f"all machines on a page: {PAGE}"])),
        files,
        runs,
        outdated=outdated,
        page=shown_page,
    )


def values_frame(plan: Plan, found: Mapping[str, MachineRow]) -> pd.DataFrame:
    """Tidy table: a row per file and unknown, in its unit; the ends of intervals are empty if open."""
    rows = [
        {**_place(plan, run), "name": name, **vars(value)}
        for run in plan.runs
        if run.key in found
        for name, value in found[run.key].values.items()
    ]
    return pd.DataFrame(rows, columns=[*_place(plan, plan.runs[0]), "name", "unit", "value", "low", "high"])


def _about(plan: Plan, lines: Lines, found: Mapping[str, MachineRow]) -> str:
    """For example '12 files: 9 adequate, 2 named, 1 error'."""
    findings = [found[run.key].finding if run.key in found else ending(lines.get(run.key))[0] for run in plan.runs]
    counted = ", ".join(f"{count} {finding}" for finding, count in Counter(findings).most_common())
    return f"{len({cell.place[MEASURED] for cell in plan.cells})} files: {counted}"


def _place(plan: Plan, run: Run) -> dict[str, Any]:
    """The file, and what else tells the run from the others."""
    place = place_columns(plan, plan.cells[run.cell])
    others = {axis: place[axis] for axis in telling_axes(plan) if axis != MEASURED}
    repetition = {"repetition": run.repetition} if any(other.repetition for other in plan.runs) else {}
    return {FILE: place[MEASURED], **others, **repetition}


def _name(plan: Plan, run: Run) -> str:
    return ", ".join(place_text(value) for value in _place(plan, run).values())


def _columns(plan: Plan, run: Run, lines: Lines, row: MachineRow | None) -> dict[str, Any]:
    """A row of the CSV file."""
    status, error = ending(lines.get(run.key))
    return {**_place(plan, run), "status": status, **({} if row is None else row.columns()), "error": error}


def _shown(plan: Plan, run: Run, lines: Lines, row: MachineRow | None) -> dict[str, str]:
    """A row for people, all of it text."""
    status, error = ending(lines.get(run.key))
    place = {name: place_text(value) for name, value in _place(plan, run).items()}
    return {**place, "status": status, **({"remarks": without_class(error)} if row is None else row.shown())}
