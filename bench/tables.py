"""Tables from plan and records: a row per run, and medians over the repetitions beside the paper's printed values."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from bench.plan import Cell, Plan, Run
from bench.records import RESULTS, read_records

PAPER = Path(__file__).resolve().parent / "paper"
COUNTS = ("updates", "model_evaluations", "model_jacobians", "surrogate_evaluations")
SECONDS = ("model", "surrogate", "search")
EFFORT = (("updates", ""), ("model_evaluations", ""), ("time", "s"))  # rows of a table below the parameters


def runs_frame(plan: Plan, output: Path) -> pd.DataFrame:
    """A row for every planned run, in the order of the plan; values in the units of the parameters."""
    rows = read_records(output, _result_row)
    not_run = {"status": "not run", "error": ""}
    return pd.DataFrame([_place_row(plan, run) | rows.get(run.key, not_run) for run in plan.runs])


def _place_row(plan: Plan, run: Run) -> dict[str, Any]:
    cell = plan.cells[run.cell]
    return {
        "key": run.key,
        "cell": run.cell,
        **_columns(plan, cell),
        "seed": cell.seed,
        "repetition": run.repetition,
    }


def _columns(plan: Plan, cell: Cell) -> dict[str, Any]:
    """Where a cell stands on the axes; lists and mappings as text, which can be compared and counted."""
    place = {axis: cell.place.get(axis) for axis in plan.axes}
    return {axis: str(value) if isinstance(value, (list, dict)) else value for axis, value in place.items()}


def _result_row(record: dict[str, Any]) -> dict[str, Any]:
    """What runs.csv says of a record, its names shared among all rows."""
    row: dict[str, Any] = {"status": record["status"]}
    if record["status"] in RESULTS:
        for parameter in record["parameters"]:
            name = parameter["name"]
            row[sys.intern(name)] = parameter["identified"] / parameter["si_per_unit"]
            row[sys.intern(f"{name}_error_pct")] = 100 * (parameter["identified"] / parameter["true"] - 1)
            row[sys.intern(f"{name}_at_bound")] = parameter["at_bound"]
        row |= {"misfit": record["misfit"], "stop": sys.intern(record["stop"])}
        row |= {count: record[count] for count in COUNTS}
        row |= {sys.intern(f"time_{part}"): record["seconds"][part] for part in SECONDS}
        row["time"] = record["seconds"]["total"]
    row["error"] = record.get("error", "")
    return row


def summary_frame(plan: Plan, runs: pd.DataFrame) -> pd.DataFrame:
    """Tidy table: a row per parameter (then updates, evaluations, time) and cell; median, quartiles, failures.

    `error_pct_median` is the median of the absolute errors.
    """
    printed = _printed_values(plan.paper)
    rows = [
        row
        for parameter in _row_names(plan)
        for index, cell in enumerate(plan.cells)
        for row in [_summary_row(plan, cell, parameter, runs[runs["cell"] == index], printed)]
        if row is not None
    ]
    return pd.DataFrame(rows)


def _row_names(plan: Plan) -> list[str]:
    names = dict.fromkeys(parameter.name for cell in plan.cells for parameter in cell.parameters)
    return [*names, *(name for name, _ in EFFORT)]


def _summary_row(
    plan: Plan, cell: Cell, name: str, runs: pd.DataFrame, printed: dict[tuple[str, int], tuple[float, float]]
) -> dict[str, Any] | None:
    facts = {parameter.name: parameter for parameter in cell.parameters}
    if name not in facts and name not in dict(EFFORT):
        return None
    results = runs[runs["status"].isin(RESULTS)]
    values = results[name].dropna().to_numpy(dtype=float) if name in results else np.array([])
    quartiles = np.percentile(values, [25, 50, 75]) if len(values) else [np.nan] * 3
    reference = facts[name].truth / facts[name].si_per_unit if name in facts else np.nan
    paper, paper_error = printed.get((name, cell.place["samples"]), (np.nan, np.nan))
    return {
        "parameter": name,
        "unit": facts[name].unit if name in facts else dict(EFFORT)[name],
        "reference": reference,
        **_columns(plan, cell),
        "paper": paper,
        "paper_error_pct": paper_error,
        "median": quartiles[1],
        "q1": quartiles[0],
        "q3": quartiles[2],
        "error_pct_median": np.median(np.abs(values / reference - 1)) * 100 if len(values) else np.nan,
        "runs": len(values),
        "failed": len(runs) - len(results),
    }


def _printed_values(paper: str | None) -> dict[tuple[str, int], tuple[float, float]]:
    """The paper's value and printed error by parameter and number of samples."""
    if paper is None:
        return {}
    table = pd.read_csv(PAPER / f"{paper}.csv")
    return {
        (row.parameter, int(row.samples)): (row.identified, row.error_pct_printed)
        for row in table.itertuples(index=False)
    }


def csv_text(frame: pd.DataFrame) -> str:
    return frame.to_csv(index=False, float_format="%.10g", lineterminator="\n")


def as_text(plan: Plan, summary: pd.DataFrame) -> str:
    """The table as people read it: a line per parameter and cell, ours beside the paper's."""
    axes = [axis for axis in plan.axes if summary[axis].nunique(dropna=False) > 1 or axis == "samples"]
    has_paper = plan.paper is not None
    head = ["parameter", "unit", "reference", *axes, "median", "[q1, q3]", "error %", "runs", "failed"]
    if has_paper:
        head[-2:-2] = ["paper", "paper error %"]
    lines = []
    for _, row in summary.iterrows():
        line = [row["parameter"], row["unit"], _number(row["reference"]), *(str(row[axis]) for axis in axes)]
        line += [
            _number(row["median"]),
            f"[{_number(row['q1'])}, {_number(row['q3'])}]",
            _number(row["error_pct_median"], 3),
        ]
        if has_paper:
            line += [_number(row["paper"]), _number(row["paper_error_pct"])]
        lines.append([*line, str(row["runs"]), str(row["failed"])])
    widths = [max(len(line[column]) for line in [head, *lines]) for column in range(len(head))]
    return "\n".join("  ".join(text.rjust(width) for text, width in zip(line, widths)) for line in [head, *lines])


def _number(value: float, digits: int = 4) -> str:
    return "–" if pd.isna(value) else f"{value:.{digits}g}"
