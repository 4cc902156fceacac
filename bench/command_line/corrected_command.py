"""The command line that was probably meant, ready to paste, for an error that holds what was meant."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from ksmea.errors import SettingError, UnknownName

FILES = {  # what a file is read by
    ("problem", ".yaml"): ("problem=rotor", "problem.file"),
    ("measurement", ".yaml"): ("measurement=campaign", "measurement.path"),
    ("measurement", ".csv"): ("measurement=file", "measurement.path"),
}
KEYS = ("setting", "option")  # nouns of names that stand before '='


def program() -> str:
    """How this program was called."""
    name = Path(sys.argv[0]).name
    return "python -m bench" if name in ("__main__.py", "") else name


def with_cure(error: SettingError, words: Sequence[str]) -> str:
    """An error's line, with the command line that was probably meant behind it where there is one."""
    meant = corrected(error, list(words))
    if not meant or sys.argv[0] == "-c":
        return str(error)
    return f"{error}; try: {program()} {shlex.join(meant)}"


def corrected(error: SettingError, words: list[str]) -> list[str] | None:
    """The words as they were probably meant; None if the error does not tell."""
    meant = error.meant
    if isinstance(meant, UnknownName):
        return _with_known_name(words, meant)
    if callable(meant):
        meant = [_changed(word, meant(_value(word))) if _key(word) == error.setting else word for word in words]
    return None if meant == words else meant


def in_brackets(given: str) -> str:
    """A setting's value as a list: unchanged if it is one, or empty."""
    return f"[{given}]" if given and not given.startswith("[") else given


def without_brackets(given: str) -> str:
    """A list as the values of a sweep."""
    return given[1:-1] if len(given) > 2 and given[0] in "[({" else given


def quoted(given: str) -> str:
    """A value with commas as one value."""
    return f'"{given}"'


def _key(word: str) -> str:
    return word.partition("=")[0].lstrip("+")


def _value(word: str) -> str:
    return word.partition("=")[2]


def _changed(word: str, value: str) -> str:
    return f"{word.partition('=')[0]}={value}"


def _with_known_name(words: list[str], meant: UnknownName) -> list[str] | None:
    suffix = Path(meant.name).suffix.replace(".yml", ".yaml")
    if (chosen := FILES.get((meant.noun, suffix))) is not None:
        plugin, key = chosen
        pairs = [[plugin, f"{key}={meant.name}"] if word == f"{meant.noun}={meant.name}" else [word] for word in words]
        return [word for pair in pairs for word in pair]
    if meant.owner:
        group, _, _ = meant.owner.partition("=")
        chosen_there = next((_value(word) for word in words if _key(word) == group and "," in word), "")
        choice = f"{group}={chosen_there},{_value(meant.owner)}" if chosen_there else meant.owner
        return [*(word for word in words if _key(word) != group), choice]
    return None if meant.near is None else _replaced(words, meant.noun.split()[0] in KEYS, meant.name, meant.near)


def _replaced(words: list[str], is_key: bool, wrong: str, near: str) -> list[str] | None:
    """The words with a wrong name replaced where it stands in one of them alone, as a whole."""
    name = re.compile(rf"(?<![\w.-]){re.escape(wrong)}(?![\w-])")
    meant, n_found = [], 0
    for word in words:
        key, sign, value = word.partition("=")
        if not sign or (is_key and name.search(key)):
            key, found = name.subn(lambda _: near, key, count=1)
        else:
            value, found = name.subn(lambda _: near, value, count=1)
        n_found += found
        meant.append(f"{key}{sign}{value}")
    return meant if n_found == 1 else None
