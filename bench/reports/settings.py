"""Table 5: control parameters of the optimisers as printed, beside those in force here. There are no runs."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from bench.plan import Plan
from bench.reports.made import Made
from bench.tables import csv_text, settings_frame, settings_text


def settings_report(plan: Plan, output: Path) -> Made:
    frame = settings_frame(plan)
    no_runs = pd.DataFrame(columns=["status", "error"])
    return Made(settings_text(frame), {f"{plan.name}.csv": csv_text(frame).encode()}, no_runs)
