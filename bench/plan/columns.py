"""Columns that say where a run stands in its plan."""

from __future__ import annotations

from typing import Any

from bench.plan.plan import Cell, Plan, Run


def place_columns(plan: Plan, cell: Cell) -> dict[str, Any]:
    """Where a cell stands on the axes; lists and mappings as text, which can be compared and counted."""
    place = {axis: cell.place.get(axis) for axis in plan.axes}
    return {axis: str(value) if isinstance(value, (list, dict)) else value for axis, value in place.items()}


def run_columns(plan: Plan, run: Run, status: str, error: str) -> dict[str, Any]:
    """Where a planned run stands and what became of it."""
    cell = plan.cells[run.cell]
    return {
        "key": run.key,
        "cell": run.cell,
        **place_columns(plan, cell),
        "repetition": run.repetition,
        "status": status,
        "error": error,
    }
