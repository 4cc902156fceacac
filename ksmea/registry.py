"""The cabinets that plugins register in by entry point, and the only place where a name becomes a class.

[project.entry-points."ksmea.optimizers"]
mine = "my_package.mine:Mine"
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from ksmea.contracts import CONTRACTS
from ksmea.errors import SettingError, unknown
from ksmea.settings import own_fields, part_fields

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
        plugin: type = points[name].load()
    except (Exception, SystemExit) as error:
        raise SettingError(f"{group}={name}: {points[name].value} cannot be loaded: {_one_line(error)}") from error
    parameters = vars(plugin).get("__dataclass_params__") if isinstance(plugin, type) else None
    if parameters is None or not parameters.frozen:
        raise SettingError(f"{group}={name}: expected a frozen dataclass at {points[name].value}, got {plugin!r}")
    contract = CONTRACTS[group]
    if not issubclass(plugin, contract):
        raise SettingError(
            f"{group}={name}: expected a subclass of {contract.__module__}.{contract.__name__} at {points[name].value},"
            f" got {plugin.__name__}; make it one, see {contract.__module__}"
        )
    if missing := sorted(plugin.__abstractmethods__):
        raise SettingError(
            f"{group}={name}: expected {plugin.__name__} to define {', '.join(missing)}, which {contract.__name__} leaves"
            " abstract, got nothing; add it"
        )
    return plugin


def _one_line(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())


def create(group: str, name: str, settings: Mapping[str, Any], parts: Mapping[str, Any] | None = None) -> Any:
    """A plugin with its settings checked; the error says which plugin and setting it was. A method is made of those of
    `parts` that it has."""
    plugin = plugin_class(group, name)
    known = [field.name for field in own_fields(plugin)]
    for key in settings:
        if key not in known:
            raise unknown(f"setting of {group}={name}:", key, known)
    chosen = {}
    for field in part_fields(plugin):
        chosen[field.name] = (parts or {}).get(field.name)
        if chosen[field.name] is None:
            raise SettingError(f"{group}={name}: expected {field.name}, {field.metadata['help']}, got none; choose one")
    try:
        return plugin(**chosen, **settings)
    except SettingError as error:
        raise SettingError(f"{group}={name}: {error}") from error
