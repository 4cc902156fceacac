"""A balancing in sentences, as `balance.json`, as tables and as a figure."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd

from bench.jobs.lines import RunLine
from bench.jobs.records import read_records
from bench.plan.page import Drawn, Folded, Page, Prose, Section, Table
from bench.plan.plan import Cell, Plan
from bench.plan.report import Made, Report
from bench.reports.by_cell import only_result, result_runs
from bench.reports.tables import csv_text
from ksmea.records.balancing import BalanceRecord
from ksmea.show.balance_text import frame, left_out_frame, text
from ksmea.show.charts.balance_chart import balance_chart, coefficients_chart
from ksmea.show.json_units import with_units

OF_ONE_RUN = ("balance.json", "coefficients.csv", "weights.csv", "left_out.csv", "balance.png")


@dataclass(frozen=True)
class BalanceReport(Report):
    study: ClassVar[str] = "balance"

    def make(self, plan: Plan, output: Path) -> Made:
        lines = read_records(output, plan=plan)
        runs = balance_runs(plan, lines)
        files: dict[str, bytes] = {"runs.csv": csv_text(runs).encode()}
        if (found := only_result(plan, lines, BalanceRecord)) is None:
            n_done = sum(run.key in lines and lines[run.key].has_result for run in plan.runs)
            return Made(f"{n_done} of {len(plan.runs)} runs have a result", files, runs, outdated=OF_ONE_RUN)
        record = found[1].shown_in(plan.units)
        files["balance.json"] = (json.dumps(with_units(record), indent=1) + "\n").encode()
        files["coefficients.csv"] = csv_text(frame(record)).encode()
        if record.weights:
            files["weights.csv"] = csv_text(left_out_frame(record.weights)).encode()
        if record.left_out is not None:
            files["left_out.csv"] = csv_text(left_out_frame(record.left_out.weights)).encode()
        outdated = tuple(name for name in OF_ONE_RUN[:-1] if name not in files)
        written = ", ".join(name for name in OF_ONE_RUN if name not in outdated)
        return Made(
            f"{text(record)}\n\nwritten: {written}",
            files,
            runs,
            outdated=outdated,
            page=lambda: balance_page(record),
        )


def balance_runs(plan: Plan, lines: Mapping[str, RunLine]) -> pd.DataFrame:
    """A row per planned run with its correction weights."""
    return result_runs(plan, lines, BalanceRecord, _row)


def _row(record: BalanceRecord, _: Cell) -> dict[str, Any]:
    found = record.correction
    return {
        "n_used": record.n_used,
        "method": record.method,
        "misfits": "; ".join(each.run for each in record.run_misfits),
        "seconds": record.seconds,
        **{
            f"{column_unit(found.unit(index))}@{position:g}": weight.size
            for index, (position, weight) in enumerate(zip(found.position, found.weight))
        },
        **{f"angle_deg@{position:g}": weight.angle for position, weight in zip(found.position, found.weight)},
    }


def column_unit(unit: str) -> str:
    """The unit as a part of a column's name: g_mm, oz_in, and g of g at a radius."""
    return unit.partition(" @ ")[0].replace(" ", "_")


def balance_page(record: BalanceRecord) -> Page:
    """The page of a balancing."""
    sections = [
        Section("What was found", (Prose(text(record)),)),
        Section("Response", (Drawn(partial(balance_chart, record), "balance.png"),)),
    ]
    all_of_them = Folded(
        "The bare response and all coefficients", (Table(frame(record, record.notation), file="coefficients.csv"),)
    )
    sections.append(Section("Influence coefficients", (Drawn(partial(coefficients_chart, record)), all_of_them)))
    if record.weights:
        weights = Folded("All columns", (Table(left_out_frame(record.weights), file="weights.csv"),))
        sections.append(Section("Unknown weights", (weights,)))
    return Page(headline(record), tuple(sections))


def headline(record: BalanceRecord) -> str:
    """The correction weights in a line."""
    found = record.correction
    weights = [
        f"{weight.size:.4g} {found.unit(index)} at {weight.angle:.0f}° at {position:g} m".replace("-", "−")
        for index, (position, weight) in enumerate(zip(found.position, found.weight))
    ]
    if found.common:
        return f"Correction not determined, the planes are nearly dependent; by calculation {'; '.join(weights)}"
    return f"Correction: {'; '.join(weights)}"
