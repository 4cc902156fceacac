"""From plan and records alone: runs.csv, the table, the figures, and the exit code."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from bench.cost import cost_figure, cost_frame
from bench.figures import png, summary_figure
from bench.files import replace_file
from bench.history_figures import mesh_figure, response_figure, updates_figure
from bench.plan import Plan, read_plan
from bench.records import RESULTS, read_records
from bench.tables import (
    as_text,
    csv_text,
    runs_frame,
    settings_frame,
    settings_text,
    slips,
    slips_text,
    summary_frame,
)


def collect(output: Path) -> int:
    """Write and print what the records of an experiment say; 0 where every planned run has a result, else 1."""
    plan = read_plan(output)
    if plan.report.table == "settings":
        return _collect_settings(plan, output)
    runs = runs_frame(plan, output)
    summary = summary_frame(plan, runs)
    files = {
        f"{plan.name}.csv": csv_text(summary).encode(),
        "runs.csv": csv_text(runs).encode(),
        f"{plan.name}.png": png(summary_figure(plan, runs, summary)),
        **_further_files(plan, runs, output),
    }
    print(f"{as_text(plan, summary)}\n{slips_text(slips(plan.report.paper))}")
    for name, content in files.items():
        replace_file(output / name, content)
    print(f"\n{_count_line(plan, runs)}\nwritten to {output}: {', '.join(files)}")
    return 0 if runs["status"].isin(RESULTS).all() else 1


def collect_all(output: Path, parts: Sequence[Path]) -> None:
    """One table of all tables, and the figure that needs two of them (13 against 21 elements, the paper's Fig. 5)."""
    frames, true_responses = [], {}
    for part in parts:
        plan = read_plan(part)
        if plan.report.table == "summary":
            frame = pd.read_csv(part / f"{plan.name}.csv")
            frames.append(frame.assign(table=plan.name))
            true_responses[plan.name] = _curves(plan, part)
    table = pd.concat(frames, ignore_index=True)
    table.insert(0, "table", table.pop("table"))
    files = {f"{output.name}.csv": csv_text(table).encode()}
    meshes = [curves[0] for name in ("table3", "table4") if (curves := true_responses.get(name))]
    if len(meshes) == 2:
        files["mesh.png"] = png(mesh_figure(*meshes))
    for name, content in files.items():
        replace_file(output / name, content)
    print(f"\nwritten to {output}: {', '.join(files)}")


def _collect_settings(plan: Plan, output: Path) -> int:
    frame = settings_frame(plan)
    replace_file(output / f"{plan.name}.csv", csv_text(frame).encode())
    print(f"{settings_text(frame)}\n\nwritten to {output}: {plan.name}.csv")
    return 0


def _further_files(plan: Plan, runs: pd.DataFrame, output: Path) -> dict[str, bytes]:
    """The figures that the experiment asks for, by file name; those that no record can make yet are left out."""
    files: dict[str, bytes] = {}
    if "updates" in plan.report.figures:
        histories = read_records(output, lambda record: record.get("history", []))
        if any(histories.values()):
            files[f"{plan.name}_updates.png"] = png(updates_figure(plan, histories))
    if "response" in plan.report.figures and (curves := _curves(plan, output)):
        files[f"{plan.name}_response.png"] = png(response_figure(plan, curves))
    if "cost" in plan.report.figures and runs["status"].isin(RESULTS).any():
        cost = cost_frame(plan, runs)
        files[f"{plan.name}_cost.csv"] = csv_text(cost).encode()
        files[f"{plan.name}_cost.png"] = png(cost_figure(cost))
    return files


def _curves(plan: Plan, output: Path) -> dict[int, dict[str, object]]:
    """Response curves by cell, of the repetition that keeps them."""
    kept = read_records(output, lambda record: record.get("curves"))
    return {run.cell: kept[run.key] for run in plan.runs if run.repetition == 0 and kept.get(run.key)}


def _count_line(plan: Plan, runs: pd.DataFrame) -> str:
    failed = runs[~runs["status"].isin(RESULTS)]
    if failed.empty:
        return f"all {len(runs)} runs of {plan.name} have a result"
    reasons = Counter(f"{row.status}: {row.error}" if row.error else row.status for row in failed.itertuples())
    shown = "; ".join(f"{count} × {' '.join(reason.split())}" for reason, count in reasons.most_common(3))
    return f"{len(failed)} of {len(runs)} failed ({shown})"
