"""Plugins that a file names, `{name: three_disk, mesh: 13}`: what a command line says of a plugin, said in YAML."""

from __future__ import annotations

import dataclasses
import typing
from functools import partial
from typing import Any

from ksmea.errors import unknown
from ksmea.plugins import registry
from ksmea.settings.document import Block, inside
from ksmea.settings.types import read_as

NAME = "name"


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
        settings[key] = inside(block, key, partial(read_as, value, hints[key]))
    return inside(block, "", lambda: registry.create(group, name, settings))
