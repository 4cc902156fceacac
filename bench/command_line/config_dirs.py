"""Folders with configuration files: the project's, and the user's own, named by options or words."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from bench.storage.own_files import CONF
from ksmea.errors import SettingError

CONFIG_DIR = ("--config-dir", "-cd")
SEARCH_PATH = "hydra.searchpath"
EXPERIMENT = "experiment"
ENTRY = re.compile(r"""'([^']*)'|"([^"]*)"|([^,'"]+)""")


def folders(words: Sequence[str]) -> list[Path]:
    """Folders searched for configuration files; `SettingError` if one does not exist."""
    own = [*_own_folders(words)]
    for folder in own:
        if not folder.is_dir():
            raise SettingError(f"{folder}: expected a folder with configuration files, found none; write its path")
    return [CONF, *own]


def _own_folders(words: Sequence[str]) -> Iterator[Path]:
    for word, following in zip(words, [*words[1:], ""]):
        key, _, value = word.partition("=")
        if key in CONFIG_DIR:
            yield Path(value or following)
        elif key.lstrip("+") == SEARCH_PATH and value.startswith("[") and value.endswith("]"):
            entries = ("".join(parts).strip() for parts in ENTRY.findall(value[1:-1]))
            yield from (Path(each.removeprefix("file://")) for each in entries if not each.startswith("pkg://"))


def without_folders(words: Sequence[str]) -> list[str]:
    """Words that do not name the user's own configuration folders."""
    before = ["", *words]
    is_folder = [
        word.partition("=")[0] in (*CONFIG_DIR, SEARCH_PATH) or last in CONFIG_DIR for last, word in zip(before, words)
    ]
    return [word for word, leave in zip(words, is_folder) if not leave]


def names_folders(words: Sequence[str]) -> bool:
    """Whether words name folders of the user's own."""
    return any(word.partition("=")[0].lstrip("+") in (*CONFIG_DIR, SEARCH_PATH) for word in words)


def experiment_files(searched: Sequence[Path] = (CONF,)) -> dict[str, Path]:
    """The experiments by name; a file of the project's comes before one of the user's own."""
    found = [path for folder in searched for path in sorted((folder / EXPERIMENT).glob("*.yaml"))]
    return {path.stem: path for path in reversed(found)}


def experiment_names() -> list[str]:
    """The project's own experiments."""
    return sorted(experiment_files())
