"""Names of cells in tables and figures, by the axes that distinguish them; columns of a run's place."""

from __future__ import annotations

import hashlib
from typing import Any

from bench.plan.plan import Cell, Plan, Run
from ksmea.errors import shortened

LONGEST_NAME = 80  # characters of a label or another value in a table or a figure


def telling_axes(plan: Plan) -> tuple[str, ...]:
    """Axes on which cells differ; where cells have labels, those on which cells of one label differ.

    If cells differ on no axis, it is `samples`.
    """
    if "label" in plan.axes:
        groups: dict[Any, list[Cell]] = {}
        for cell in plan.cells:
            groups.setdefault(cell.place.get("label"), []).append(cell)
        return ("label", *(axis for axis in plan.axes if axis != "label" and any(map(_differ(axis), groups.values()))))
    return tuple(axis for axis in plan.axes if _differ(axis)(plan.cells)) or tuple({"samples"} & set(plan.axes))


def _differ(axis: str) -> Any:
    return lambda cells: len({str(cell.place.get(axis)) for cell in cells}) > 1


def naming_axes(plan: Plan) -> tuple[str, ...]:
    """Axes in the names of cells: the telling ones but for those whose value follows from an earlier one."""
    kept: list[str] = []
    for axis in telling_axes(plan):
        if not any(_follows(plan, axis, earlier) for earlier in kept):
            kept.append(axis)
    return tuple(kept)


def _follows(plan: Plan, axis: str, earlier: str) -> bool:
    """Whether all cells with one value of an earlier axis have one value of this axis."""
    values: dict[str, set[str]] = {}
    for cell in plan.cells:
        values.setdefault(str(cell.place.get(earlier)), set()).add(str(cell.place.get(axis)))
    return all(len(each) == 1 for each in values.values())


def place_text(value: Any) -> str:
    """A setting's value as tables and figures print it.

    A long value is shown by its beginning, and by digits of its hash that distinguish it from others with this
    beginning.
    """
    text = "–" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
    if len(text) <= LONGEST_NAME:
        return text
    return f"{shortened(text, LONGEST_NAME)} ({hashlib.sha256(text.encode(errors='replace')).hexdigest()[:6]})"


def cell_name(plan: Plan, cell: Cell) -> str:
    """For example 'KSMEA, samples 40'."""
    parts = [(axis, cell.place.get(axis)) for axis in naming_axes(plan)]
    return ", ".join(place_text(value) if axis == "label" else f"{axis} {place_text(value)}" for axis, value in parts)


def place_columns(plan: Plan, cell: Cell) -> dict[str, Any]:
    """Values of a cell on the axes; lists and mappings as text, which can be compared and counted."""
    place = {axis: cell.place.get(axis) for axis in plan.axes}
    return {axis: str(value) if isinstance(value, (list, dict)) else value for axis, value in place.items()}


def run_columns(plan: Plan, run: Run, status: str, error: str) -> dict[str, Any]:
    """Key, cell, axis values and repetition of a planned run, with its status and error."""
    cell = plan.cells[run.cell]
    return {
        "key": run.key,
        "cell": run.cell,
        **place_columns(plan, cell),
        "repetition": run.repetition,
        "status": status,
        "error": error,
    }
