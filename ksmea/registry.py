"""The cabinets that plugins register in by entry point, and the only place where a name becomes a class.

[project.entry-points."ksmea.optimizers"]
mine = "my_package.mine:Mine"
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from ksmea.errors import SettingError, unknown

GROUPS = {
    "problem": "ksmea.problems",
    "measurement": "ksmea.measurements",
    "surrogate": "ksmea.surrogates",
    "optimizer": "ksmea.optimizers",
    "method": "ksmea.methods",
    "study": "ksmea.studies",
}
FURTHER = {  # not parts of a run: chosen inside the settings of others, or made of records afterwards
    "effect": "ksmea.effects",
    "report": "ksmea.reports",
}


@cache
def registered(group: str) -> dict[str, EntryPoint]:
    """Entry points of a group ('optimizer', …) by name, in alphabetical order."""
    return {
        point.name: point
        for point in sorted(entry_points(group=(GROUPS | FURTHER)[group]), key=lambda point: point.name)
    }


def plugin_class(group: str, name: str) -> type:
    """The settings class registered under a name; unknown names list the known ones, the nearest first."""
    points = registered(group)
    if name not in points:
        raise unknown(group, name, points)
    try:
        plugin = points[name].load()
    except (Exception, SystemExit) as error:
        raise SettingError(f"{group}={name}: {points[name].value} cannot be loaded: {_one_line(error)}") from error
    if not (isinstance(plugin, type) and dataclasses.is_dataclass(plugin) and plugin.__dataclass_params__.frozen):
        raise SettingError(f"{group}={name}: expected a frozen dataclass at {points[name].value}, got {plugin!r}")
    return plugin


def _one_line(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())


def create(group: str, name: str, settings: Mapping[str, Any]) -> Any:
    """A plugin with its settings checked; the error says which plugin and setting it was."""
    plugin = plugin_class(group, name)
    known = [field.name for field in dataclasses.fields(plugin)]
    for key in settings:
        if key not in known:
            raise unknown(f"setting of {group}={name}:", key, known)
    try:
        return plugin(**settings)
    except SettingError as error:
        raise SettingError(f"{group}={name}: {error}") from error
