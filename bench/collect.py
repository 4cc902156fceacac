"""From plan and records alone: runs.csv, the table, the figure, and the exit code."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pandas as pd

from bench.figures import png, summary_figure
from bench.files import replace_file
from bench.plan import Plan, read_plan
from bench.records import RESULTS
from bench.tables import as_text, csv_text, runs_frame, summary_frame


def collect(output: Path) -> int:
    """Write and print what the records of an experiment say; 0 where every planned run has a result, else 1."""
    plan = read_plan(output)
    runs = runs_frame(plan, output)
    summary = summary_frame(plan, runs)
    replace_file(output / "runs.csv", csv_text(runs).encode())
    replace_file(output / f"{plan.name}.csv", csv_text(summary).encode())
    replace_file(output / f"{plan.name}.png", png(summary_figure(plan, runs, summary)))
    print(as_text(plan, summary))
    print(f"\n{_count_line(plan, runs)}\nwritten to {output}: {plan.name}.csv, runs.csv, {plan.name}.png")
    return 0 if runs["status"].isin(RESULTS).all() else 1


def _count_line(plan: Plan, runs: pd.DataFrame) -> str:
    failed = runs[~runs["status"].isin(RESULTS)]
    if failed.empty:
        return f"all {len(runs)} runs of {plan.name} have a result"
    reasons = Counter(f"{row.status}: {row.error}" if row.error else row.status for row in failed.itertuples())
    shown = "; ".join(f"{count} × {' '.join(reason.split())}" for reason, count in reasons.most_common(3))
    return f"{len(failed)} of {len(runs)} failed ({shown})"
