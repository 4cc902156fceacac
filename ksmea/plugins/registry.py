"""Registries of plugins, by entry point or from a file.

They are the only place where a name becomes a class.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from contextlib import nullcontext, suppress
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

from ksmea.errors import PluginFailure, SettingError, unknown
from ksmea.plugins.files import CONTRACTS, OURS, classes_in, one_line, plugins_of_file, require_same
from ksmea.plugins.first_import import require_importable, undisturbed
from ksmea.plugins.module_files import module_spec
from ksmea.plugins.names import (
    FURTHER,
    GROUPS,
    PROJECT,
    BrokenName,
    SharedName,
    add_file,
    is_added,
    left_out,
    origin,
    origin_of,
    package,
    plugins_in_files,
    registered,
)
from ksmea.settings.settings import Settings, own_fields, part_fields, require_free_names

__all__ = [
    "CONTRACTS",
    "FURTHER",
    "GROUPS",
    "PROJECT",
    "create",
    "create_all",
    "is_outside",
    "left_out",
    "modules_of",
    "name_of",
    "origin",
    "origin_of",
    "plugin_class",
    "plugins_in_files",
    "register_file",
    "registered",
]


def register_file(path: Path, planned: Mapping[str, str] | None = None) -> None:
    """Register the plugins of a Python file, which is executed for that, next to the installed ones.

    A file that has been registered stays as it was. `SettingError` if it cannot be loaded, has no plugin, or one of a
    name that is taken, and where it and what it imports from next to it do not have the `planned` digests.
    """
    if is_added(path):
        return
    if planned is not None:
        require_same(path, planned)
    try:
        found = plugins_of_file(path)
    except PluginFailure as error:
        if not (broken := classes_in(path)):
            raise
        groups = GROUPS | FURTHER
        add_file(path, [BrokenName(name, groups[group], str(error)) for group, name in broken])
        return
    for each in found:
        if each.name in registered(each.group):
            raise SettingError(
                f"{path}: expected names that no other plugin has, but {each.group}={each.name} is there from"
                f" {origin(each.group, each.name)}; rename its class {each.plugin.__name__}",
                setting="plugins",
            )
    groups = GROUPS | FURTHER
    points = [
        EntryPoint(each.name, f"{each.plugin.__module__}:{each.plugin.__name__}", groups[each.group]) for each in found
    ]
    add_file(path, points)


def plugin_class(group: str, name: str) -> type:
    """The settings class registered under a name; unknown names list the known ones, the nearest first."""
    points = registered(group)
    if name not in points:
        raise unknown(group, name, points)
    try:
        return _class_at(points[name], CONTRACTS[group])
    except SettingError as error:
        raise error.within(f"{group}={name}") from error


def _class_at(point: EntryPoint, contract: type[Settings]) -> type:
    """The class that an entry point names.

    Raises `SettingError` if it cannot be loaded or is not a plugin by the contract.
    """
    if isinstance(point, SharedName):
        raise SettingError(point.refusal)
    if isinstance(point, BrokenName):
        raise PluginFailure(point.refusal)
    plugin: type = _loaded(point)
    parameters = vars(plugin).get("__dataclass_params__") if isinstance(plugin, type) else None
    if parameters is None or not parameters.frozen:
        raise SettingError(f"expected a frozen dataclass at {point.value}, got {plugin!r}")
    if not issubclass(plugin, contract):
        raise SettingError(
            f"expected a subclass of {contract.__module__}.{contract.__name__} at {point.value},"
            f" got {plugin.__name__}; make it one, see {contract.__module__}"
        )
    require_free_names(plugin)
    if missing := sorted(plugin.__abstractmethods__):
        raise SettingError(
            f"expected {plugin.__name__} to define {', '.join(missing)}, which {contract.__name__} leaves"
            " abstract, got nothing; add it"
        )
    return plugin


def _loaded(point: EntryPoint) -> type:
    """The class that an entry point names.

    The import of a class from outside is tried first, and changes nothing but its own additions.
    """
    module = point.value.partition(":")[0]
    is_new = module not in sys.modules and module.partition(".")[0] not in OURS
    if is_new:
        require_importable(point.value, point.load)
    try:
        with undisturbed() if is_new else nullcontext():
            found: type = point.load()
    except (Exception, SystemExit) as error:
        raise PluginFailure(f"{point.value} cannot be loaded: {one_line(error)}") from error
    return found


def is_outside(group: str, name: str) -> bool:
    """Whether a plugin of this name is registered that is not this project's."""
    point = registered(group).get(name) if group in GROUPS | FURTHER else None
    return point is not None and package(point) != PROJECT


def name_of(plugin: Settings) -> tuple[str, str]:
    """Group and name that a plugin is chosen by; `SettingError` if its class is not registered."""
    own = f"{type(plugin).__module__}:{type(plugin).__qualname__}"
    points = [(group, name, point) for group in GROUPS | FURTHER for name, point in registered(group).items()]
    for group, name, point in points:
        if point.value == own:
            return group, name
    package = type(plugin).__module__.partition(".")[0]
    for group, name, point in points:  # an entry point may name the class by another module that imports it
        if point.module.partition(".")[0] == package:
            with suppress(SettingError):  # a broken plugin takes nothing away from its neighbours
                if plugin_class(group, name) is type(plugin):
                    return group, name
    raise SettingError(f"{own}: expected a registered plugin, got a class without an entry point; register it")


def modules_of(group: str, name: str) -> tuple[str, ...]:
    """The module that makes a plugin, as its entry point says; what that imports follows from its file.

    Nothing is imported for that: names may come from a received folder. `SettingError` for what is not registered, or
    has no module here.
    """
    points = registered(group) if group in GROUPS | FURTHER else {}
    if name not in points:
        raise unknown(group, name, points)
    point = points[name]
    if isinstance(point, SharedName):
        raise SettingError(f"{group}={name}: {point.refusal}")
    if module_spec(point.module) is None:
        raise SettingError(f"{group}={name}: expected a module {point.module}, found none; install its package again")
    return (point.module,)


def create(group: str, name: str, settings: Mapping[str, Any], parts: Mapping[str, Any] | None = None) -> Any:
    """Create a plugin with checked settings; errors name the plugin and the setting.

    A method receives only the `parts` that it has.
    """
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
        with undisturbed() if is_outside(group, name) else nullcontext():
            return plugin(**chosen, **settings)
    except SettingError as error:
        raise error.within(f"{group}={name}", setting=error.setting and f"{group}.{error.setting}") from error
    except (Exception, SystemExit) as error:
        if not is_outside(group, name):
            raise
        raise PluginFailure(
            f"{group}={name}: expected settings that can be made or refused by a SettingError, got {one_line(error)}"
        ) from error


def create_all(group: str, names: Iterable[str]) -> tuple[dict[str, Any], dict[str, str]]:
    """Plugins of these names with their default settings, and errors of names that cannot be made.

    Both by name. One broken package does not affect the others.
    """
    made, left_out = {}, {}
    for name in names:
        try:
            made[name] = create(group, name, {})
        except SettingError as error:
            left_out[name] = str(error)
    return made, left_out
