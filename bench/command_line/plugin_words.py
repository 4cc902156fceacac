"""Plain files of plugins that a command names.

They stand on the command line, and in the configuration files that it chooses.

They are looked for before anything is composed, as only what is registered can be composed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from bench.command_line.config_files import chosen_files, content, settings_of
from bench.command_line.messages import USER_ERRORS, in_our_words
from ksmea.errors import SettingError
from ksmea.plugins import registry

PLUGINS = "plugins"


def register_plugins(words: Sequence[str]) -> None:
    """Register the plugins of all files that the words name, relative to the working directory."""
    for path in given_files(words):
        registry.register_file(path)


def registered_or_why_not(words: Sequence[str]) -> list[str]:
    """Register the plugins of the files that words plugins=[…] name.

    Why a file could not be, for each that could not.
    """
    refused = []
    for path in given_files([word for word in words if is_of_plugins(word)]):
        try:
            registry.register_file(path)
        except SettingError as error:  # it does not take the help on the others away
            refused.append(str(error))
    return refused


def is_of_plugins(word: str) -> bool:
    """Whether a word names files of plugins."""
    return word.lstrip("+").partition("=")[0] == PLUGINS


def require_registered(names: Sequence[str]) -> None:
    """Raise `SettingError` if a composed configuration names a plugin file that was not found before.

    Files are found on the command line and in the configuration files that it chooses.
    """
    known = {path for path, *_ in registry.plugins_in_files()}
    for name in names:
        if _absolute(name) not in known:
            raise SettingError(
                f"expected {name} on the command line or in the file of the experiment itself; name it there",
                setting="plugins",
            )


def given_files(words: Sequence[str]) -> list[Path]:
    """The files that the words name, each once."""
    try:
        names = [*_names(words)]
    except USER_ERRORS as error:
        raise in_our_words(error) from error
    return list(dict.fromkeys(_absolute(name) for name in names))


def _absolute(name: str) -> Path:
    return Path(os.path.normpath(Path(name).expanduser().absolute()))


def _names(words: Sequence[str]) -> Iterator[str]:
    for choice in settings_of(words):
        if choice.key == PLUGINS:
            yield from _listed(choice.values[0] if len(choice.values) == 1 else None)
    for path in chosen_files(words):
        yield from _listed(content(path).get(PLUGINS) or [])


def _listed(names: Any) -> list[str]:
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise SettingError(
            "expected a list of Python files, plugins=[my_optimizer.py], got something else", setting="plugins"
        )
    return names
