"""Plugins that a file names, `{name: three_disk, mesh: 13}`: what a command line says of a plugin, said in YAML."""

from __future__ import annotations

import dataclasses
import types
import typing
from typing import Any

from ksmea import registry
from ksmea.errors import SettingError, unknown
from problems.blocks import Block, described, inside

NAME = "name"
TRUTHS = {"true": True, "false": False}  # strict YAML has them as texts
IN_WORDS = {bool: "true or false", int: "a whole number", float: "a number", str: "a text", type(None): "null"}


def plugin_of(block: Block, group: str) -> Any:
    """The plugin that a block names, with its settings checked for their types as well."""
    name = block.choice(NAME, group, registry.registered(group))
    plugin = inside(block, "", lambda: registry.plugin_class(group, name))
    hints = typing.get_type_hints(plugin)
    known = [field.name for field in dataclasses.fields(plugin)]
    settings = {}
    for key, value in block.values.items():
        if key == NAME:
            continue
        if key not in known:
            raise block.error("", unknown(f"setting of {group}={name}:", str(key), known))
        settings[key] = inside(block, key, lambda value=value, key=key: _typed(value, hints[key]))
    return inside(block, "", lambda: registry.create(group, name, settings))


def _typed(value: Any, hint: Any) -> Any:
    """A value of the file as the type of a setting has it."""
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        for option in typing.get_args(hint):
            try:
                return _typed(value, option)
            except SettingError:
                pass
    elif typing.get_origin(hint) is list and isinstance(value, list):
        return [_typed(entry, typing.get_args(hint)[0]) for entry in value]
    elif typing.get_origin(hint) is dict and isinstance(value, dict):
        return {str(key): _typed(entry, typing.get_args(hint)[1]) for key, entry in value.items()}
    elif hint is bool and isinstance(value, str) and value in TRUTHS:
        return TRUTHS[value]
    elif hint is float and isinstance(value, (int, float)):
        return float(value)
    elif hint in (int, str, type(None)) and isinstance(value, hint):
        return value
    raise SettingError(f"expected {_in_words(hint)}, got {described(value)}")


def _in_words(hint: Any) -> str:
    origin, options = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return " or ".join(map(_in_words, options))
    if origin is list:
        return f"a list, each entry {_in_words(options[0])}"
    if origin is dict:
        return f"a mapping, each value {_in_words(options[1])}"
    return IN_WORDS.get(hint, str(hint))
