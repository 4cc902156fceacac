"""Table 5: control parameters of the optimisers as printed, beside those in force here. There are no runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pandas as pd

from bench.plan.plan import Plan
from bench.plan.report import Made, Report
from bench.reports.tables import csv_text, settings_frame, settings_text


@dataclass(frozen=True)
class SettingsReport(Report):
    study: ClassVar[str] = "identify"

    def make(self, plan: Plan, output: Path) -> Made:
        frame = settings_frame(plan)
        no_runs = pd.DataFrame(columns=["status", "error"])
        return Made(settings_text(frame), {f"{plan.name}.csv": csv_text(frame).encode()}, no_runs)
