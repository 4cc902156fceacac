"""From plan and records alone: runs.csv, the table, the figures, and the exit code."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from bench.cost import cost_figure, cost_frame
from bench.figures import png, summary_figure
from bench.files import replace_file
from bench.history_figures import MOST_LINES, mesh_figure, response_figure, updates_figure
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

DRAWN = ".drawn"  # holds a digest of what the figures beside it were drawn from


def collect(output: Path, redraw: bool = True) -> int:
    """Write and print what the records of an experiment say; 0 where every planned run has a result, else 1.

    Without `redraw`, figures that were drawn from the same runs by the same code are left as they are.
    """
    plan = read_plan(output)
    if plan.report.table == "settings":
        return _collect_settings(plan, output)
    runs = runs_frame(plan, output)
    summary = summary_frame(plan, runs)
    files = {f"{plan.name}.csv": csv_text(summary).encode(), "runs.csv": csv_text(runs).encode()}
    drawn_from = hashlib.sha256(files["runs.csv"] + plan.commit.encode()).hexdigest().encode()
    if redraw or not _is_drawn(output, plan, drawn_from):
        files[f"{plan.name}.png"] = png(summary_figure(plan, runs, summary))
        files |= _further_files(plan, runs, output)
        (output / DRAWN).unlink(missing_ok=True)
    print(f"{as_text(plan, summary)}\n{slips_text(slips(plan.report.paper))}")
    for name, content in files.items():
        replace_file(output / name, content)
    replace_file(output / DRAWN, drawn_from)
    there = sorted(path.name for pattern in ("*.csv", "*.png") for path in output.glob(pattern))
    print(f"\n{_count_line(plan, runs)}\nin {output}: {', '.join(there)}")
    return 0 if runs["status"].isin(RESULTS).all() else 1


def _is_drawn(output: Path, plan: Plan, drawn_from: bytes) -> bool:
    """Whether the figures are there, and were drawn from this."""
    mark = output / DRAWN
    return (output / f"{plan.name}.png").is_file() and mark.is_file() and mark.read_bytes() == drawn_from


def collect_all(output: Path, parts: Sequence[Path]) -> None:
    """One table of all tables, and the figure that needs two of them (13 against 21 elements, the paper's Fig. 5)."""
    frames, true_responses = [], {}
    for part in parts:
        plan = read_plan(part)
        if plan.report.table == "summary":
            frame = pd.read_csv(part / f"{plan.name}.csv")
            frames.append(frame.assign(table=plan.name))
            true_responses[plan.name] = _by_cell(plan, read_records(part, _for_figures))
    table = pd.concat(frames, ignore_index=True)
    table.insert(0, "table", table.pop("table"))
    files = {f"{output.name}.csv": csv_text(table).encode()}
    meshes = [curves[min(curves)] for name in ("table3", "table4") if (curves := true_responses.get(name))]
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
    if {"updates", "response"} & set(plan.report.figures):
        shown = {run.key for run in plan.runs if run.repetition < MOST_LINES}
        kept = read_records(output, lambda record: _for_figures(record) if record["key"] in shown else ([], None))
        if "updates" in plan.report.figures and any(history for history, _ in kept.values()):
            histories = {key: history for key, (history, _) in kept.items()}
            files[f"{plan.name}_updates.png"] = png(updates_figure(plan, histories))
        if "response" in plan.report.figures and (curves := _by_cell(plan, kept)):
            files[f"{plan.name}_response.png"] = png(response_figure(plan, curves))
    if "cost" in plan.report.figures and runs["status"].isin(RESULTS).any():
        cost = cost_frame(plan, runs)
        files[f"{plan.name}_cost.csv"] = csv_text(cost).encode()
        files[f"{plan.name}_cost.png"] = png(cost_figure(cost))
    return files


def _for_figures(record: dict[str, Any]) -> tuple[list[Any], dict[str, Any] | None]:
    """The updating steps of a run, and its response curves where it keeps them."""
    return record.get("history", []), record.get("curves")


def _by_cell(plan: Plan, kept: Mapping[str, tuple[Any, dict[str, Any] | None]]) -> dict[int, dict[str, Any]]:
    """Response curves by cell, of the repetition that keeps them."""
    curves = {run.cell: kept.get(run.key, (None, None))[1] for run in plan.runs if run.repetition == 0}
    return {cell: found for cell, found in curves.items() if found}


def _count_line(plan: Plan, runs: pd.DataFrame) -> str:
    failed = runs[~runs["status"].isin(RESULTS)]
    if failed.empty:
        return f"all {len(runs)} runs of {plan.name} have a result"
    reasons = Counter(f"{row.status}: {row.error}" if row.error else row.status for row in failed.itertuples())
    shown = "; ".join(f"{count} × {' '.join(reason.split())}" for reason, count in reasons.most_common(3))
    return f"{len(failed)} of {len(runs)} failed ({shown})"
