"""Medians over the repetitions beside the paper's values, and the figures that an experiment asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd

from bench.jobs.records import RESULTS, read_records
from bench.plan.plan import Plan
from bench.plan.report import Made, Report
from bench.reports.cost import cost_figure, cost_frame
from bench.reports.figures import summary_figure
from bench.reports.history_figures import MOST_LINES, response_figure, updates_figure
from bench.reports.tables import as_text, csv_text, runs_frame, slips, slips_text, summary_frame
from ksmea.show.style import png


@dataclass(frozen=True)
class SummaryReport(Report):
    study: ClassVar[str] = "identify"

    def make(self, plan: Plan, output: Path) -> Made:
        runs = runs_frame(plan, output)
        summary = summary_frame(plan, runs)
        return Made(
            f"{as_text(plan, summary)}\n{slips_text(slips(plan.report.paper))}",
            {f"{plan.name}.csv": csv_text(summary).encode(), "runs.csv": csv_text(runs).encode()},
            runs,
            lambda: {f"{plan.name}.png": png(summary_figure(plan, runs, summary))} | _further_files(plan, runs, output),
        )


def _further_files(plan: Plan, runs: pd.DataFrame, output: Path) -> dict[str, bytes]:
    """The figures that the experiment asks for, by file name; those that no record can make yet are left out."""
    files: dict[str, bytes] = {}
    if {"updates", "response"} & set(plan.report.figures):
        shown = {run.key for run in plan.runs if run.repetition < MOST_LINES}
        kept = read_records(output, lambda record: for_figures(record) if record["key"] in shown else ([], None))
        if "updates" in plan.report.figures and any(history for history, _ in kept.values()):
            histories = {key: history for key, (history, _) in kept.items()}
            files[f"{plan.name}_updates.png"] = png(updates_figure(plan, histories))
        if "response" in plan.report.figures and (curves := curves_by_cell(plan, kept)):
            files[f"{plan.name}_response.png"] = png(response_figure(plan, curves))
    if "cost" in plan.report.figures and runs["status"].isin(RESULTS).any():
        cost = cost_frame(plan, runs)
        files[f"{plan.name}_cost.csv"] = csv_text(cost).encode()
        files[f"{plan.name}_cost.png"] = png(cost_figure(cost))
    return files


def for_figures(record: dict[str, Any]) -> tuple[list[Any], dict[str, Any] | None]:
    """The updating steps of a run, and its response curves where it keeps them."""
    return record.get("history", []), record.get("curves")


def curves_by_cell(plan: Plan, kept: Mapping[str, tuple[Any, dict[str, Any] | None]]) -> dict[int, dict[str, Any]]:
    """Response curves by cell, of the repetition that keeps them."""
    curves = {run.cell: kept.get(run.key, (None, None))[1] for run in plan.runs if run.repetition == 0}
    return {cell: found for cell, found in curves.items() if found}
