"""Configuration files that the words of a command choose: the project's, and those in folders of the user's own."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import yaml

from bench.command_line.config_dirs import EXPERIMENT, folders
from bench.command_line.overrides import Choice, parse
from bench.storage.own_files import CONF
from ksmea.errors import SettingError

PACKAGE = re.compile(r"^# *@package +_global_ *$", re.MULTILINE)
INCLUDED = {"experiment": "includes"}  # what names one in a file


def settings_of(words: Sequence[str]) -> tuple[Choice, ...]:
    """What the words say without options."""
    return parse([word for word in words if "=" in word and not word.startswith("-")])


def chosen_files(words: Sequence[str]) -> list[Path]:
    """The configuration files that single values of the words choose."""
    searched = folders(words)
    named = [(each.key, each.values[0]) for each in settings_of(words) if len(each.values) == 1]
    paths = [folder / key / f"{name}.yaml" for key, name in named if isinstance(name, str) for folder in searched]
    return [path for path in paths if path.is_file()]


def content(path: Path) -> dict[str, Any]:
    """What a configuration file says; `SettingError` with its name where it cannot be read."""
    try:
        found = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise SettingError(
            f"{path}: expected a YAML file, could not read it ({' '.join(str(error).split())})"
        ) from error
    if not isinstance(found or {}, dict):
        raise SettingError(f"{path}: expected setting: value, got {type(found).__name__}")
    return found or {}


def require_experiments(paths: Sequence[Path]) -> None:
    """Raise `SettingError` with the file's name where one cannot be read, or is an experiment that says nothing of the whole."""
    for path in paths:
        content(path)
        if path.parent.name == EXPERIMENT and not PACKAGE.search(path.read_text(encoding="utf-8")):
            raise SettingError(
                f"{path}: expected '# @package _global_' as its first line, without which it sets nothing"
            )


def with_file(error: SettingError, paths: Sequence[Path], words: Sequence[str]) -> SettingError:
    """An error with the name of the user's own file in front that has the setting which it is about, if the words do not."""
    key = INCLUDED.get(error.setting, error.setting)
    if not key or key in [choice.key for choice in settings_of(words)]:
        return error
    own = [path for path in paths if not path.is_relative_to(CONF) and key in _keys(content(path))]
    return error.within(own[0]) if own else error


def _keys(said: Any, above: str = "") -> Iterator[str]:
    """All keys of a configuration file with dots, those of its blocks too."""
    if isinstance(said, list):
        for each in said:
            yield from _keys(each)
    elif isinstance(said, dict):
        for key, value in said.items():
            yield f"{above}{key}"
            yield from _keys(value, f"{above}{key}.")
