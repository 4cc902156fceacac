"""What is drawn of an experiment of identifications: its figures and its page.

All of matplotlib is loaded with it. So it is loaded where something is drawn, not where an experiment is planned or has all its
figures already.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from bench.jobs.lines import RESULTS, RunLine
from bench.jobs.records import read_records
from bench.plan.page import Page
from bench.plan.plan import Plan
from bench.plan.report import Drawing
from bench.reports.identification.cost import cost_figure, cost_frame
from bench.reports.identification.figures import summary_figure
from bench.reports.identification.history_figures import MAX_LINES, response_figure, updates_figure
from bench.reports.identification.summary_page import summary_page
from bench.reports.identification.trace_figure import trace_figure
from bench.reports.identification.trace_table import read_traces, stages_frame, trace_frame
from bench.reports.tables import csv_text
from ksmea.records.curves import ResponseCurves
from ksmea.records.identification import IdentificationRecord, UpdateRecord
from ksmea.show.figures.style import png


def drawings(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame, output: Path) -> dict[str, Drawing]:
    """The figure of the table and those that the experiment asks for, by file name; those that no record can make yet are
    left out."""
    files: dict[str, Drawing] = {f"{plan.name}.png": lambda: png(summary_figure(plan, runs, summary))}
    if {"updates", "response"} & set(plan.report.figures):
        kept = _kept(plan, output)
        if "updates" in plan.report.figures and any(part.history for part in kept.values()):
            histories = {key: part.history for key, part in kept.items()}
            files[f"{plan.name}_updates.png"] = lambda: png(updates_figure(plan, histories))
        if "response" in plan.report.figures and (curves := curves_by_cell(plan, kept)):
            files[f"{plan.name}_response.png"] = lambda: png(response_figure(plan, curves))
    if "cost" in plan.report.figures and runs["status"].isin(RESULTS).any():
        files[f"{plan.name}_cost.csv"] = lambda: csv_text(cost_frame(plan, runs)).encode()
        files[f"{plan.name}_cost.png"] = lambda: png(cost_figure(cost_frame(plan, runs)))
    if "trace" in plan.report.figures and (traces := read_traces(plan, output)):
        by_cost, by_stage = trace_frame(plan, traces), stages_frame(plan, traces)
        files[f"{plan.name}_trace.csv"] = csv_text(by_cost).encode()
        files[f"{plan.name}_stages.csv"] = csv_text(by_stage).encode()
        files[f"{plan.name}_trace.png"] = lambda: png(trace_figure(plan, by_cost, by_stage))
    return files


def page(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame, text: str, output: Path) -> Page:
    """What the page shows, curves among it where the experiment asks for their figures."""
    asked = set(plan.report.figures)
    kept = _kept(plan, output) if {"updates", "response"} & asked else {}
    histories = {key: part.history for key, part in kept.items()} if "updates" in asked else {}
    traces = read_traces(plan, output) if "trace" in asked else {}
    reached = trace_frame(plan, traces) if traces else None
    return summary_page(
        plan, text, runs, summary, curves_by_cell(plan, kept) if "response" in asked else {}, histories, reached
    )


def _kept(plan: Plan, output: Path) -> dict[str, ForFigures]:
    """Updating steps and curves of the runs that figures show."""
    shown = {run.key for run in plan.runs if run.repetition < MAX_LINES}
    return read_records(output, lambda line: for_figures(line) if line.key in shown else ForFigures(), plan)


@dataclass(frozen=True)
class ForFigures:
    """The updating steps of a run, and its response curves where it keeps them."""

    history: tuple[UpdateRecord, ...] = ()
    curves: ResponseCurves | None = None


def for_figures(line: RunLine) -> ForFigures:
    if not line.has_result:
        return ForFigures()
    record = line.record(IdentificationRecord)
    return ForFigures(record.history, record.curves)


def curves_by_cell(plan: Plan, kept: Mapping[str, ForFigures]) -> dict[int, ResponseCurves]:
    """Response curves by cell, of the repetition that keeps them."""
    of_first = {run.cell: kept[run.key].curves for run in plan.runs if run.repetition == 0 and run.key in kept}
    return {cell: curves for cell, curves in of_first.items() if curves is not None}
