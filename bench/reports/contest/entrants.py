"""Methods of a contest: arguments that choose each, its origin and its budget."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from bench.plan.plan import Cell, Plan
from bench.reports.contest.cells import PARTS, budget, method_name
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.settings.settings import own_fields

NAME, BUDGET, SAMPLES = "name", "budget", "samples"


def entrants_frame(plan: Plan) -> pd.DataFrame:
    """A row per method, all text; settings that differ between its cells as a range or a list."""
    methods: dict[str, list[Cell]] = {}
    for cell in plan.cells:
        methods.setdefault(method_name(cell), []).append(cell)
    rows = [
        {
            "method": method,
            "settings": " ".join(_words(cells)),
            "from": ", ".join(
                dict.fromkeys(_origin(plan, group, cell.chosen(group)) for cell in cells for group in _groups(cell))
            ),
            "budget": _values([budget(cell) for cell in cells]) or "none",
            "cells": str(len(cells)),
        }
        for method, cells in methods.items()
    ]
    return pd.DataFrame(rows)


def _groups(cell: Cell) -> list[str]:
    return [group for group in PARTS if cell.settings.get(group)]


def _words(cells: list[Cell]) -> list[str]:
    """Words of the command line that choose a method.

    Its plugins, and their settings that are not the defaults.
    """
    words = []
    for group in PARTS:
        parts = [cell.settings[group] for cell in cells if cell.settings.get(group)]
        if not parts:
            continue
        words.append(f"{group}={_values([part[NAME] for part in parts])}")
        default = _defaults(group, parts[0][NAME])
        for name in dict.fromkeys(name for part in parts for name in part if name not in (NAME, BUDGET)):
            values = [part.get(name) for part in parts]
            if any(value != default.get(name) for value in values):
                words.append(f"{group}.{name}={_values(values)}")
    samples = [cell.settings[SAMPLES] for cell in cells if cell.settings.get(SAMPLES) is not None]
    return [*words, *([f"{SAMPLES}={_values(samples)}"] if samples else [])]


def _values(values: list[Any]) -> str:
    """One value, the range of several numbers, or all others."""
    different = list(dict.fromkeys(str(value) for value in values if value is not None))
    if len(different) > 1 and all(isinstance(value, (int, float)) for value in values if value is not None):
        numbers = [value for value in values if value is not None]
        return f"{min(numbers):g}…{max(numbers):g}"
    return ",".join(different)


def _defaults(group: str, name: str) -> dict[str, Any]:
    """Defaults of a plugin's settings; none of one that is not registered here."""
    if name not in registry.registered(group):
        return {}
    try:
        plugin = registry.plugin_class(group, name)
    except SettingError:
        return {}
    return {
        field.name: field.default if not callable(field.default_factory) else field.default_factory()
        for field in own_fields(plugin)
    }


def _origin(plan: Plan, group: str, name: str) -> str:
    """The package with its version, or the file, that a plugin comes from."""
    if (path := plan.plugins.get(f"{group}={name}")) is not None:
        return Path(path).name
    if name in registry.registered(group):
        return registry.origin(group, name)
    return f"{group}={name}, which is not installed here"
