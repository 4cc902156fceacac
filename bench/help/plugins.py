"""Help on plugins: docstring, settings and origin of each.

Settings have defaults, units, ranges and sources.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bench.command_line.schema import plugin_schema
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import expected_range, own_fields

EFFECT = "effect"  # chosen in settings of measurements, studies and extended problems
EXAMPLE = "three_disk"  # the problem that limits of effects are shown for, where none is named


@dataclass(frozen=True)
class Problem:
    """The problem that limits of effects are shown for."""

    name: str = EXAMPLE
    settings: Mapping[str, Any] = field(default_factory=dict)
    was_asked: bool = False

    def __str__(self) -> str:
        said = (f"problem.{key}={value}" for key, value in self.settings.items())
        return " ".join([f"problem={self.name}", *said])


def group_text(group: str, problem: Problem) -> str:
    """All plugins of a group; a broken one does not take the help on the others away."""
    return "\n\n".join(_plugin_text_or_why_not(group, name, problem) for name in registry.registered(group))


def setting_text(group: str, name: str, setting: str) -> str | None:
    """One setting of a plugin; None if the plugin has none of that name, or cannot be loaded."""
    try:
        fields = own_fields(registry.plugin_class(group, name))
    except SettingError:
        return None
    lines = [
        setting_line(f"{group}.{name}.{setting}" if group == EFFECT else f"{group}.{setting}", field)
        for field in fields
        if field.name == setting
    ]
    return f"{group}={name}:\n  {lines[0]}" if lines else None


def _plugin_text_or_why_not(group: str, name: str, problem: Problem) -> str:
    try:
        return plugin_text(group, name, problem)
    except SettingError as error:  # a broken plugin does not take the help on the others away
        return f"{error} [{registry.origin(group, name)}]"


def plugin_text(group: str, name: str, problem: Problem) -> str:
    """Description, origin and settings of a plugin; of an effect also its unknowns on a problem."""
    settings = registry.plugin_class(group, name)
    lines = [f"{group}={name}: {_summary(settings)} [{registry.origin(group, name)}]"]
    lines += [f"  {setting_line(f'{group}.{field.name}', field)}" for field in own_fields(settings)]
    return "\n".join([*lines, *(_effect_lines(name, problem) if group == EFFECT else _why_not_offered(group, name))])


def _summary(settings: type) -> str:
    """The first paragraph of what a class says of itself, or its module where it says nothing."""
    said = vars(settings).get("__doc__") or ""
    if not said or said.startswith(f"{settings.__name__}("):  # what a dataclass writes itself
        said = inspect.getdoc(inspect.getmodule(settings)) or ""
    return " ".join(said.strip().split("\n\n")[0].split())


def setting_line(key: str, field: dataclasses.Field) -> str:
    """A setting by its key, with its default, meaning, unit, range and source."""
    return f"{key}={_default(field)}  {_remarks(field)}"


def _why_not_offered(group: str, name: str) -> list[str]:
    """Why a plugin cannot be chosen on the command line; nothing where it can."""
    try:
        plugin_schema(group, name)
    except SettingError as error:
        return [f"  cannot be chosen: {error}"]
    return []


def _effect_lines(name: str, problem: Problem) -> list[str]:
    """Unknowns of an effect, effects that it can look like, and its physics with the source."""
    effect = registry.create(EFFECT, name, {})
    lines = []
    for parameter in _parameters_on(effect, problem):
        lower, upper = parameter.lower / parameter.si_per_unit, parameter.upper / parameter.si_per_unit
        lines.append(f"  unknown {parameter.name}: {lower:g} to {upper:g} {parameter.unit} ({problem})")
    lines += [f"  can look like {alias}: {what}" for alias, what in effect.aliases.items()]
    physics = inspect.getdoc(inspect.getmodule(type(effect))) or ""
    return lines + [f"  | {line}".rstrip() for line in physics.splitlines()]


def _parameters_on(effect: AnyEffect, problem: Problem) -> Sequence[Parameter]:
    """Unknowns of a plugin on a problem; empty if it does not fit the problem that is shown by default.

    Raises `SettingError` if it does not fit the one that was requested.
    """
    try:
        return effect.parameters(registry.create("problem", problem.name, problem.settings).build())
    except Exception as error:  # whatever an effect for other problems does with it
        if not problem.was_asked:
            return ()
        reason = str(error) if isinstance(error, SettingError) else f"{type(error).__name__}: {error}"
        raise SettingError(f"{problem}: expected a problem that the effect fits, but {reason}") from error


def _default(field: dataclasses.Field) -> str:
    if field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
        return "?"
    default = field.default_factory() if field.default_factory is not dataclasses.MISSING else field.default
    if default is None:
        return "null"
    return str(default).lower() if isinstance(default, bool) else str(default)


def _remarks(field: dataclasses.Field) -> str:
    metadata = field.metadata
    remarks = [metadata.get("help", "")]
    if metadata.get("unit"):
        remarks.append(f"[{metadata['unit']}]")
    if metadata.get("choices"):
        remarks.append(f"(one of {', '.join(map(str, metadata['choices']))})")
    elif expected_range(metadata):
        remarks.append(f"({expected_range(metadata)})")
    if metadata.get("source"):
        remarks.append(f"– {metadata['source']}")
    return " ".join(remark for remark in remarks if remark)
