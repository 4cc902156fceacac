"""Plain files of plugins that a command names: on the command line, and in the configuration files that it chooses.

They are looked for before anything is composed, as only what is registered can be composed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import yaml

from bench.command_line.messages import USER_ERRORS, one_line
from bench.command_line.overrides import Choice, parse
from bench.storage.places import CONF
from ksmea import registry
from ksmea.errors import SettingError

PLUGINS = "plugins"
CONFIG_DIR = ("--config-dir", "-cd")
SEARCH_PATH = "hydra.searchpath"


def register_plugins(words: Sequence[str]) -> None:
    """Register the plugins of all files that the words name, relative to the working directory."""
    for path in given_files(words):
        registry.register_file(path)


def is_of_plugins(word: str) -> bool:
    """Whether a word names files of plugins."""
    return word.lstrip("+").partition("=")[0] == PLUGINS


def require_registered(names: Sequence[str]) -> None:
    """Raise `SettingError` where a composed configuration names a file that was found neither on the command line nor in a
    file that it chooses."""
    known = {path for path, *_ in registry.plugins_in_files()}
    for name in names:
        if _absolute(name) not in known:
            raise SettingError(
                f"plugins: expected {name} on the command line or in the file of the experiment itself; name it there"
            )


def given_files(words: Sequence[str]) -> list[Path]:
    """The files that the words name, each once."""
    try:
        names = [*_names(words)]
    except USER_ERRORS as error:
        raise SettingError(one_line(error)) from error
    return list(dict.fromkeys(_absolute(name) for name in names))


def _absolute(name: str) -> Path:
    return Path(os.path.normpath(Path(name).expanduser().absolute()))


def _names(words: Sequence[str]) -> Iterator[str]:
    choices = parse([word for word in words if "=" in word and not word.startswith("-")])
    folders = [CONF, *_folders(words, choices)]
    for choice in choices:
        if choice.key == PLUGINS:
            yield from _listed(choice.values[0] if len(choice.values) == 1 else None)
        elif len(choice.values) == 1 and isinstance(choice.values[0], str):
            for path in (folder / choice.key / f"{choice.values[0]}.yaml" for folder in folders):
                yield from _listed(_of_yaml(path))


def _folders(words: Sequence[str], choices: Sequence[Choice]) -> Iterator[Path]:
    """Folders of configurations of the user's own."""
    for word, following in zip(words, [*words[1:], ""]):
        option, _, value = word.partition("=")
        if option in CONFIG_DIR:
            yield Path(value or following)
    for choice in choices:
        if choice.key == SEARCH_PATH and isinstance(choice.values[0], list):
            yield from (Path(str(each).removeprefix("file://")) for each in choice.values[0])


def _of_yaml(path: Path) -> Any:
    """What a configuration file says of plugins; nothing where there is none: composing says what is wrong with a file."""
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError):
        return []
    return (content.get(PLUGINS) or []) if isinstance(content, dict) else []


def _listed(names: Any) -> list[str]:
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise SettingError("plugins: expected a list of Python files, plugins=[my_optimizer.py], got something else")
    return names
