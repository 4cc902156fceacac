"""The cabinets that plugins register in, by entry point or from a file, and the only place where a name becomes a class.

[project.entry-points."ksmea.optimizers"]
mine = "my_package.mine:Mine"
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from ksmea.contracts import CONTRACTS
from ksmea.errors import SettingError, unknown
from ksmea.plugin_files import FoundPlugin, one_line, plugins_of_file, require_same
from ksmea.settings import own_fields, part_fields

PROJECT = "ksmea-bench"
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


_in_files: dict[Path, list[FoundPlugin]] = {}  # what this process has registered from files


class _SharedName(EntryPoint):
    """A name that several packages register: it is refused where it is chosen, none of them stands in for another."""

    def __init__(self, points: Sequence[EntryPoint]) -> None:
        super().__init__(points[0].name, points[0].value, points[0].group)
        packages = (f"{_package(point)} ({point.value})" for point in points)
        vars(self).update(packages=" and ".join(packages))

    @property
    def refusal(self) -> str:
        return (
            f"expected one package that registers this name, got {vars(self)['packages']}; rename it in one of them or"
            " uninstall that one"
        )


@cache
def registered(group: str) -> dict[str, EntryPoint]:
    """Entry points of a group ('optimizer', …) by name, in alphabetical order. A name of this project stays its own."""
    by_name: dict[str, list[EntryPoint]] = {}
    for point in _points(group):
        by_name.setdefault(point.name, []).append(point)
    for name, points in by_name.items():
        by_name[name] = [point for point in points if _package(point) == PROJECT] or points
    return {name: points[0] if len(points) == 1 else _SharedName(points) for name, points in by_name.items()}


def left_out(group: str) -> list[EntryPoint]:
    """Entry points of other packages whose names are those of this project's plugins, which stand."""
    return [point for point in _points(group) if _package(point) != PROJECT == _package(registered(group)[point.name])]


def register_file(path: Path, planned: Mapping[str, str] | None = None) -> None:
    """Register the plugins of a Python file, which is executed for that, beside the installed ones. A file that has been
    registered stays as it was. `SettingError` where it cannot be loaded, has no plugin, or one of a name that is taken, and
    where it and what it imports from beside it do not have the `planned` digests."""
    if path in _in_files:
        return
    if planned is not None:
        require_same(path, planned)
    found = plugins_of_file(path)
    for each in found:
        if each.name in registered(each.group):
            raise SettingError(
                f"plugins: {path}: expected names that no other plugin has, but {each.group}={each.name} is there from"
                f" {origin(each.group, each.name)}; rename its class {each.plugin.__name__}"
            )
    _in_files[path] = found
    registered.cache_clear()


def plugins_in_files() -> Iterator[tuple[Path, str, str]]:
    """File, group and name of every plugin that was registered from a file."""
    yield from ((path, each.group, each.name) for path, found in _in_files.items() for each in found)


def origin(group: str, name: str) -> str:
    """Where a plugin comes from: its package with the version, or its file."""
    files = (str(path) for path, *chosen in plugins_in_files() if chosen == [group, name])
    return next(files, origin_of(registered(group)[name]))


def origin_of(point: EntryPoint) -> str:
    """The package that an entry point comes from, with the version."""
    return f"{_package(point)} {point.dist.version}" if point.dist else _package(point)


def _points(group: str) -> list[EntryPoint]:
    """Entry points of a group, from packages and from files, by their names."""
    in_files = [each for found in _in_files.values() for each in found if each.group == group]
    where = (GROUPS | FURTHER)[group]
    points = [EntryPoint(each.name, f"{each.plugin.__module__}:{each.plugin.__name__}", where) for each in in_files]
    return sorted([*entry_points(group=where), *points], key=lambda point: point.name)


def _package(point: EntryPoint) -> str:
    return point.dist.name if point.dist else "?"


def plugin_class(group: str, name: str) -> type:
    """The settings class registered under a name; unknown names list the known ones, the nearest first."""
    points = registered(group)
    if name not in points:
        raise unknown(group, name, points)
    point = points[name]
    if isinstance(point, _SharedName):
        raise SettingError(f"{group}={name}: {point.refusal}")
    try:
        plugin: type = point.load()
    except (Exception, SystemExit) as error:
        raise SettingError(f"{group}={name}: {points[name].value} cannot be loaded: {one_line(error)}") from error
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


def create_all(group: str, names: Iterable[str]) -> tuple[dict[str, Any], dict[str, str]]:
    """Plugins of these names with their default settings, and why there is none of a name that cannot be made: one broken
    package takes nothing away from the others."""
    made, left_out = {}, {}
    for name in names:
        try:
            made[name] = create(group, name, {})
        except SettingError as error:
            left_out[name] = str(error)
    return made, left_out
