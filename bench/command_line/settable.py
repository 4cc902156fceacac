"""Which settings of a plugin the command line can offer: what it can write, what a plan can keep, and with a default."""

from __future__ import annotations

import dataclasses
import types
import typing
from functools import cache
from typing import Any

from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.settings.settings import own_fields
from ksmea.settings.types import in_words

PLAIN = (bool, int, float, str, type(None), Any)
POSSIBLE = "bool, int, float or str, or None, lists, tuples or mappings by name of these"


def require_offered(group: str, name: str) -> None:
    """Raise `SettingError` where a setting of a plugin has no default, or a type that cannot be given as words."""
    _require_offered_of(registry.plugin_class(group, name), f"{group}={name}")


@cache
def _require_offered_of(plugin: type, where: str) -> None:
    """The same of a class, which each process looks at once where nothing is wrong with it."""
    try:
        hints = typing.get_type_hints(plugin)
    except Exception as error:  # whatever an annotation raises
        raise SettingError(
            f"{where}: expected types of its settings that can be resolved, got {type(error).__name__}:"
            f" {' '.join(str(error).split())}; define them at the top of its module"
        ) from error
    for each in own_fields(plugin):
        _require_setting_offered(f"{where}: {each.name}", each, hints[each.name])


def _require_setting_offered(where: str, each: dataclasses.Field[Any], hint: Any) -> None:
    if not _is_plain(hint):
        raise SettingError(f"{where}: expected a setting of type {POSSIBLE}, got {in_words(hint)}; give it such a type")
    if each.default is dataclasses.MISSING and each.default_factory is dataclasses.MISSING:
        raise SettingError(f"{where}: expected a setting with a default, got none; give it one ({in_words(hint)})")
    try:
        OmegaConf.structured(dataclasses.make_dataclass("One", [(each.name, hint, copied(each))]))
    except (OmegaConfBaseException, TypeError, ValueError) as error:
        reason = " ".join(str(error).split("\n")[0].split())
        raise SettingError(
            f"{where}: expected a setting of type {POSSIBLE} with a default of that type, got {in_words(hint)} ({reason});"
            " change it"
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


def copied(setting: dataclasses.Field[Any]) -> Any:
    """A field with the same default, for another dataclass."""
    if setting.default_factory is not dataclasses.MISSING:
        return dataclasses.field(default_factory=setting.default_factory)
    return dataclasses.field(default=setting.default)
