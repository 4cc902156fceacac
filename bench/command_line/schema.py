"""Hydra's schemas of settings: typed nodes made of the fields of a plugin, or of the bench itself.

A command line offers what it can write and a plan can keep: plain types, each with a default.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterable
from functools import cache
from typing import Any

from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from bench.command_line.bench_settings import BenchConfig
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.settings.settings import own_fields
from ksmea.settings.types import in_words

PLAIN = (bool, int, float, str, type(None), Any)
POSSIBLE = "bool, int, float or str, or None, lists, tuples or mappings by name of these"


def plugin_schema(group: str, name: str) -> DictConfig:
    """Settings of a plugin with their types and its name.

    With the name a composed configuration states the choice.

    Raises `SettingError` if a setting has no default, or a type that cannot be given as words.
    """
    plugin = registry.plugin_class(group, name)
    try:
        return _plugin_schema(plugin, name)
    except SettingError as error:
        raise error.within(f"{group}={name}") from error


@cache
def bench_schema() -> DictConfig:
    """The settings of the bench itself."""
    return _node("Bench", _typed(BenchConfig))


@cache
def _plugin_schema(plugin: type, name: str) -> DictConfig:
    """The schema of a class, which each process makes once where nothing is wrong with it."""
    settings = _typed(plugin)
    for each in settings:
        _require_offered(*each)
    own_name: Any = dataclasses.field(default=name)
    node = _node("Named" + plugin.__name__, [*settings, ("name", str, own_name)])
    for setting in own_fields(plugin):
        if node[setting.name] == {}:  # names that the plugin alone knows
            OmegaConf.set_struct(node[setting.name], False)
    return node


Typed = tuple[str, Any, dataclasses.Field[Any]]


def _typed(settings: type) -> list[Typed]:
    """Name, type and default of each setting."""
    try:
        hints = typing.get_type_hints(settings)
    except Exception as error:  # whatever an annotation raises
        raise SettingError(
            f"expected types of its settings that can be resolved, got {type(error).__name__}:"
            f" {' '.join(str(error).split())}; define them at the top of its module"
        ) from error
    return [(each.name, hints[each.name], _with_default(each)) for each in own_fields(settings)]


def _with_default(setting: dataclasses.Field[Any]) -> dataclasses.Field[Any]:
    """A field with the default of another one, for another dataclass."""
    if setting.default_factory is not dataclasses.MISSING:
        return dataclasses.field(default_factory=setting.default_factory)
    return dataclasses.field(default=setting.default)


def _node(name: str, settings: Iterable[Typed]) -> DictConfig:
    node: DictConfig = OmegaConf.structured(dataclasses.make_dataclass(name, settings))
    return node


def _require_offered(name: str, hint: Any, setting: dataclasses.Field[Any]) -> None:
    said = in_words(hint)
    if not _is_plain(hint):
        raise SettingError(f"expected a setting of type {POSSIBLE}, got {said}; give it such a type", setting=name)
    if setting.default is dataclasses.MISSING and setting.default_factory is dataclasses.MISSING:
        raise SettingError(f"expected a setting with a default, got none; give it one ({said})", setting=name)
    try:
        _node("One", [(name, hint, setting)])
    except (OmegaConfBaseException, TypeError, ValueError) as error:
        reason = " ".join(str(error).split("\n")[0].split())
        raise SettingError(
            f"expected a setting of type {POSSIBLE} with a default of that type, got {said} ({reason}); change it",
            setting=name,
        ) from error


def _is_plain(hint: Any) -> bool:
    origin, options = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return all(map(_is_plain, options))
    if origin in (list, tuple):
        return all(_is_plain(option) for option in options if option is not ...)
    if origin is dict:
        return options[0] is str and _is_plain(options[1])
    return hint in PLAIN or hint in (list, tuple, dict)
