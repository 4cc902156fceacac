"""Table 5: control parameters of the optimisers as printed, next to those in force here.

There are no runs.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pandas as pd

from bench.plan.page import Page, Section, Table
from bench.plan.plan import Plan
from bench.plan.report import Made, Report
from bench.reports.tables import csv_text
from bench.storage.own_files import PAPER
from ksmea.show.text import aligned

OUR_NAMES = {  # of settings that Table 5 prints under other names
    "cooperative_factor": "social",
    "cognitive_learning_factor": "cognitive",
    "crossover_probability": "crossover_rate",
    "mutation_probability": "mutation_rate",
}


@dataclass(frozen=True)
class SettingsReport(Report):
    study: ClassVar[str] = "identify"

    def make(self, plan: Plan, output: Path) -> Made:
        frame = settings_frame(plan)
        no_runs = pd.DataFrame(columns=["status", "error"])
        files = {f"{plan.name}.csv": csv_text(frame).encode()}
        return Made(settings_text(frame), files, no_runs, page=lambda: _page(frame))


def _page(frame: pd.DataFrame) -> Page:
    found = f"{int(frame['agrees'].sum())} of {len(frame)} settings are as printed"
    return Page(found, (Section("Settings next to the paper's", (Table(frame),)),))


def settings_frame(plan: Plan) -> pd.DataFrame:
    """Table 5: the settings of each optimiser as printed and as they are here."""
    printed = pd.read_csv(PAPER / "table5.csv")
    here = {cell.chosen("optimizer").upper(): cell.settings["optimizer"] for cell in plan.cells}
    rows = []
    for row in printed.itertuples(index=False):
        name = OUR_NAMES.get(row.setting, row.setting)
        value = here.get(row.optimizer, {}).get(name)
        rows.append(
            {"optimizer": row.optimizer, "printed_as": row.setting, "setting": name, "paper": row.value, "here": value}
        )
    frame = pd.DataFrame(rows)
    frame["agrees"] = frame["paper"] == frame["here"]
    return frame


def settings_text(frame: pd.DataFrame) -> str:
    lines = [[str(value) for value in row] for row in frame.itertuples(index=False)]
    return aligned([str(column) for column in frame.columns], lines)
