"""Facts of a cell in a contest: its method, its instance and family, and the budget of its runs.

A *method* is a label. An *instance* is the whole of a cell's problem and measurement settings, its *family* the problem's setting
of that name, or the problem's own name.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

from bench.plan.naming import place_text
from bench.plan.plan import Cell
from bench.plan.setup import FINGERPRINTS

FAMILY, HELD_BACK = "family", "held_back"  # settings of a problem; the latter: kept for the final ranking
PARTS = ("method", "surrogate", "optimizer")  # that name a method without a label
OF_INSTANCE = ("problem", "measurement")


def method_name(cell: Cell) -> str:
    """The label of a cell, or its method with its parts."""
    if (label := cell.place.get("label")) is not None:
        return place_text(label)
    return " + ".join(str(cell.settings[part]["name"]) for part in PARTS if cell.settings.get(part))


def budget(cell: Cell) -> int | None:
    """Evaluations of the true model that a run of a cell may take.

    The smaller of the study's budget and the method's own.
    """
    parts = (cell.settings.get(part) or {} for part in ("study", "method"))
    return min((part["budget"] for part in parts if part.get("budget") is not None), default=None)


def identity(cell: Cell) -> str:
    """All that an instance is, as text: settings of problem and measurement, and content of their files."""
    names = (*OF_INSTANCE, *FINGERPRINTS.values())
    return json.dumps({name: cell.settings.get(name) for name in names}, sort_keys=True, default=str)


def family(cell: Cell) -> str:
    """The kind of problem that a cell's instance is of."""
    problem = cell.settings["problem"]
    return str(problem.get(FAMILY) or problem["name"])


def is_held_back(cell: Cell) -> bool | None:
    """Whether a cell's instance is kept for the final ranking; None if it does not say."""
    held_back = cell.settings["problem"].get(HELD_BACK)
    return None if held_back is None else bool(held_back)


def telling_words(cells: Sequence[Cell]) -> list[str]:
    """Words for each cell that tell their instances apart: settings that are not the same in all."""
    words = [
        {f"{group}.{name}": value for group in OF_INSTANCE for name, value in cell.settings[group].items()}
        for cell in cells
    ]
    names = dict.fromkeys(name for each in words for name in each)
    telling = [name for name in names if len({str(each.get(name)) for each in words}) > 1]
    return [" ".join(f"{name}={each[name]}" for name in telling if name in each) for each in words]
