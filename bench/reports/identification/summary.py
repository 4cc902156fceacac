"""Medians over the repetitions beside the paper's values, and the figures that an experiment asks for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pandas as pd

from bench.plan.page import Page
from bench.plan.plan import Plan
from bench.plan.report import Drawing, Made, Report
from bench.reports.by_cell import hidden_paragraph
from bench.reports.runs import runs_frame
from bench.reports.tables import as_text, csv_text, slips, slips_text, summary_frame


@dataclass(frozen=True)
class SummaryReport(Report):
    study: ClassVar[str] = "identify"

    def make(self, plan: Plan, output: Path) -> Made:
        runs = runs_frame(plan, output)
        summary = summary_frame(plan, runs)
        blocks = [
            as_text(plan, summary),
            slips_text(slips(plan.report.paper)),
            hidden_paragraph(plan, runs, "identification"),
        ]
        return Made(
            "\n\n".join(filter(None, blocks)),
            {f"{plan.name}.csv": csv_text(summary).encode(), "runs.csv": csv_text(runs).encode()},
            runs,
            lambda: _drawings(plan, runs, summary, output),
            page=lambda: _page(plan, runs, summary, "\n\n".join(filter(None, blocks)), output),
        )


def _drawings(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame, output: Path) -> dict[str, Drawing]:
    from bench.reports.identification.summary_drawings import drawings  # loads all of matplotlib

    return drawings(plan, runs, summary, output)


def _page(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame, text: str, output: Path) -> Page:
    from bench.reports.identification.summary_drawings import page  # loads all of matplotlib

    return page(plan, runs, summary, text, output)
