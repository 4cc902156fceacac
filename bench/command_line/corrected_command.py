"""The command line that was probably meant, ready to paste, for an error that tells it."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from bench.command_line.word_shapes import WrongShape

NEAREST = re.compile(r"unknown (?P<noun>[^']*)'(?P<wrong>[^']*)'; did you mean '(?P<near>[^']*)'")
ONE_PLUGIN = re.compile(r"unknown setting '[\w.]+'; (?P<choice>\w+=\w+) has it, ")
NO_LIST = re.compile(r"(?P<key>[\w.]+): expected a list \[.*got (?P<got>one value|one block|other brackets)")
A_LIST = re.compile(r"(?P<key>[\w.]+): expected .*, got a list; several values are written without brackets")
SEVERAL = re.compile(r"(?P<key>output|name): expected one value for the whole experiment, got several")
COMMA = re.compile(r"(?P<key>[\w.]+): expected a decimal point, .*; write (?P<value>\S+)$")
NO_PLUGIN = re.compile(r"unknown (problem|measurement) '(?P<file>[^']+\.(?P<suffix>ya?ml|csv|xlsx|uff|unv))'")
FILES = {  # what a file is read by
    ("problem", "yaml"): ("problem=rotor", "problem.file"),
    ("measurement", "yaml"): ("measurement=campaign", "measurement.path"),
    ("measurement", "csv"): ("measurement=file", "measurement.path"),
}


def program() -> str:
    """How this program was called."""
    name = Path(sys.argv[0]).name
    return "python -m bench" if name in ("__main__.py", "") else name


def with_cure(error: Exception, words: Sequence[str]) -> str:
    """An error's line, with the command line that was probably meant behind it where there is one."""
    meant = corrected(error, list(words))
    if not meant or sys.argv[0] == "-c" or meant == list(words):
        return str(error)
    return f"{error}; try: {program()} {shlex.join(meant)}"


def corrected(error: Exception, words: list[str]) -> list[str] | None:
    """The words as they were probably meant; None where the error does not tell."""
    if isinstance(error, WrongShape):
        return error.meant
    line = str(error)
    if found := NO_PLUGIN.search(line):
        return _with_file(words, found[1], found["file"], found["suffix"])
    if found := COMMA.search(line):
        return _with_value(words, found["key"], found["value"])
    if found := NO_LIST.search(line):
        return _in_brackets(words, found["key"], found["got"] == "other brackets")
    if found := A_LIST.search(line):
        return _without_brackets(words, found["key"])
    if found := SEVERAL.search(line):
        return [f'{_key(word)}="{word.partition("=")[2]}"' if _key(word) == found["key"] else word for word in words]
    if found := ONE_PLUGIN.search(line):
        group, _, plugin = found["choice"].partition("=")
        chosen = _given(words, group)
        choice = f"{group}={chosen},{plugin}" if "," in chosen else found["choice"]
        return [*[word for word in words if _key(word) != group], choice]
    if found := NEAREST.search(line):
        is_key = found["noun"].startswith(("setting ", "option "))
        return _replaced(words, is_key, found["wrong"], found["near"])
    return None


def _key(word: str) -> str:
    return word.partition("=")[0].lstrip("+")


def _with_value(words: list[str], key: str, value: str) -> list[str] | None:
    return [f"{word.partition('=')[0]}={value}" if _key(word) == key else word for word in words]


def _given(words: list[str], key: str) -> str:
    """The one value that the words give a setting; '' where they give none, or several."""
    values = [word.partition("=")[2] for word in words if _key(word) == key]
    return values[0] if len(values) == 1 else ""


def _in_brackets(words: list[str], key: str, is_other: bool) -> list[str] | None:
    given = _given(words, key)
    inner = given[1:-1] if is_other else given
    return _with_value(words, key, f"[{inner}]") if inner and not inner.startswith("[") else None


def _without_brackets(words: list[str], key: str) -> list[str] | None:
    given = _given(words, key)
    return _with_value(words, key, given[1:-1]) if given.startswith("[") and len(given) > 2 else None


def _with_file(words: list[str], group: str, file: str, suffix: str) -> list[str] | None:
    chosen = FILES.get((group, suffix.replace("yml", "yaml")))
    if chosen is None:
        return None
    plugin, key = chosen
    replaced = [[plugin, f"{key}={file}"] if word == f"{group}={file}" else [word] for word in words]
    return [word for pair in replaced for word in pair]


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
