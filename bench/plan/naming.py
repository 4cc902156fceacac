"""How a cell is called in tables and figures: by those axes alone that tell it from the others."""

from __future__ import annotations

from typing import Any

from bench.plan.plan import Cell, Plan


def telling_axes(plan: Plan) -> tuple[str, ...]:
    """Axes on which cells differ; where cells have labels, those on which cells of one label differ. At least samples."""
    if "label" in plan.axes:
        groups: dict[Any, list[Cell]] = {}
        for cell in plan.cells:
            groups.setdefault(cell.place.get("label"), []).append(cell)
        return ("label", *(axis for axis in plan.axes if axis != "label" and any(map(_differ(axis), groups.values()))))
    return tuple(axis for axis in plan.axes if _differ(axis)(plan.cells)) or tuple({"samples"} & set(plan.axes))


def _differ(axis: str) -> Any:
    return lambda cells: len({str(cell.place.get(axis)) for cell in cells}) > 1


def place_text(value: Any) -> str:
    """A setting's value as tables and figures print it."""
    return "–" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def cell_name(plan: Plan, cell: Cell) -> str:
    """For example 'KSMEA, samples 40'."""
    parts = [(axis, cell.place.get(axis)) for axis in telling_axes(plan)]
    return ", ".join(place_text(value) if axis == "label" else f"{axis} {place_text(value)}" for axis, value in parts)
