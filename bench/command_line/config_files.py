"""Configuration files that the words of a command choose.

The project's, and those in folders of the user's own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import yaml

from bench.command_line.config_dirs import EXPERIMENT, folders
from bench.command_line.experiment_shape import included, require_shape
from bench.command_line.overrides import Choice, parse
from bench.storage.own_files import CONF
from ksmea.errors import SettingError
from ksmea.plugins.names import GROUPS
from ksmea.settings.strict_yaml import parse as parse_strictly
from ksmea.settings.strict_yaml import read_bytes

PACKAGE = re.compile(r"^# *@package +(.*?) *$", re.MULTILINE)
GLOBAL = "_global_"
OF_PLUGIN = re.compile(r"(\w+)=\w+: ")
INDEX = re.compile(r"\[\d+\]")
INCLUDED = {"experiment": "includes"}  # what names one in a file


def settings_of(words: Sequence[str]) -> tuple[Choice, ...]:
    """Settings among the arguments, without options."""
    return parse([word for word in words if "=" in word and not word.startswith("-")])


def chosen_files(words: Sequence[str]) -> list[Path]:
    """The configuration files that single values of the words choose."""
    searched = folders(words)
    named = [(each.key, each.values[0]) for each in settings_of(words) if len(each.values) == 1]
    paths = [folder / key / f"{name}.yaml" for key, name in named if isinstance(name, str) for folder in searched]
    return [path for path in paths if path.is_file()]


def content(path: Path) -> dict[str, Any]:
    """Parsed content of a configuration file.

    Raises `SettingError` with its name and the place if it cannot be read.
    """
    read = read_bytes(str(path))
    parse_strictly(read, str(path))  # keys that stand twice, lists nested too deeply: with their lines
    try:
        found = yaml.safe_load(read.decode("utf-8-sig"))  # as Hydra reads it, by YAML 1.1
    except (ValueError, yaml.YAMLError) as error:
        raise SettingError(
            f"{path}: expected a YAML file, could not read it ({' '.join(str(error).split())})"
        ) from error
    if not isinstance(found or {}, dict):
        raise SettingError(f"{path}: expected setting: value, got {type(found).__name__}")
    require_shape(found or {}, path)
    return found or {}


def require_experiments(paths: Sequence[Path]) -> None:
    """Raise `SettingError` with the file's name if an experiment cannot be read.

    It is also raised for an experiment that says nothing of the whole.
    """
    for path in paths:
        _require_file(path, ())


def _require_file(path: Path, above: tuple[Path, ...]) -> None:
    """Check one file and the files of its folder that it includes.

    `above` holds the files that include it.
    """
    if path in above:
        raise SettingError(f"{path}: expected defaults that end, got a file that includes itself; leave it out")
    said = content(path)
    if path.parent.name == EXPERIMENT:
        packages = PACKAGE.findall(path.read_text(encoding="utf-8-sig"))
        if not packages:
            raise SettingError(
                f"{path}: expected '# @package {GLOBAL}' as its first line, without which it sets nothing"
            )
        if packages != [GLOBAL]:
            raise SettingError(f"{path}: expected '# @package {GLOBAL}' once, got {', '.join(packages)}")
    for name in included(said):
        if (beside := path.parent / f"{name}.yaml").is_file():
            _require_file(beside, (*above, path))


def with_file(
    error: SettingError, paths: Sequence[Path], words: Sequence[str], is_composed: bool = False
) -> SettingError:
    """Error with the name of the user's own file that has the setting it is about, if the words do not.

    `is_composed`: the error arose while files and words were put together.
    """
    key = _key(error)
    own = [path for path in paths if not path.is_relative_to(CONF) and not str(error).startswith(str(path))]
    if not own or any(_is_about(error, key, choice) for choice in settings_of(words)):
        return error
    naming = [path for path in own if key and any(_is_meant(key, each) for each in _keys(content(path)))]
    if not naming and not is_composed:
        return error
    return error.within((naming or own)[0])


def _key(error: SettingError) -> str:
    """The setting that an error is about, or the group of the plugin; '' if it does not say."""
    if not error.setting and (found := OF_PLUGIN.match(str(error))) and found[1] in GROUPS:
        return found[1]
    return INDEX.sub("", INCLUDED.get(error.setting, error.setting))


def _is_about(error: SettingError, key: str, choice: Choice) -> bool:
    """Whether an error is about what a word says.

    Its setting, unless its value is another one than the error quotes.
    """
    if choice.key.partition(".")[0] == key and key in GROUPS:
        return True
    return choice.key == key and (
        " got '" not in str(error) or any(f"'{each}'" in str(error) for each in choice.values)
    )


def _is_meant(key: str, said: str) -> bool:
    """Whether a key of a file sets a setting.

    `standard.optimizer.population` sets `optimizer.population`, `override /optimizer` a plugin.
    """
    return said == key or said.endswith((f".{key}", f"/{key}"))


def _keys(said: Any, above: str = "") -> Iterator[str]:
    """All keys of a configuration file with dots, including keys within blocks."""
    if isinstance(said, list):
        for each in said:
            yield from _keys(each)
    elif isinstance(said, dict):
        for key, value in said.items():
            yield f"{above}{key}"
            yield from _keys(value, f"{above}{key}.")
