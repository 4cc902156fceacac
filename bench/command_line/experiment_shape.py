"""The shape of an experiment's file: what Hydra would meet without a word of where it stands.

A file says settings as `setting: value`, plugins in its defaults (`- override /optimizer: pso`), and lines of its grid as mappings. Whether
the settings exist, and whether values are of their types, is asked later, when the configuration is composed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from omegaconf.errors import OmegaConfBaseException
from omegaconf.grammar_parser import parse

from bench.command_line.bench_settings import bench_fields
from ksmea.errors import SettingError, described, shortened
from ksmea.plugins.names import GROUPS

DEFAULTS = "defaults"
LINES = ("grid", "add", "cross")
GROUP = re.compile(r"(?:override +|optional +)*(/?)([\w/.@-]+)")
MISSING = "???"  # OmegaConf's mark of a value that is to come, which a file would silently say nothing by
MOST_ENTRIES = 10**5  # of a file, those behind its aliases (*name) each time that they are named


def require_shape(said: Mapping[Any, Any], path: Path) -> None:
    """Raise `SettingError` with file and key if a configuration file has a shape that Hydra rejects."""
    try:
        if _n_entry(said, {}, ()) > MOST_ENTRIES:
            raise SettingError(
                f"expected at most {MOST_ENTRIES} entries, got more through aliases (*name); write them out"
            )
        for where, value in _entries(said, ""):
            _require_value(value, where)
        for group in GROUPS:
            if group in said and path.parent.name not in (*GROUPS, "launcher"):
                _require_plugin(said[group], group)
        for key in LINES:
            _require_lines(said.get(key, []), key)
        for key, field in bench_fields().items():
            if key in said and key not in LINES:
                _require_collection(said[key], key, str(field.type))
        _require_defaults(said.get(DEFAULTS, []))
    except SettingError as error:
        raise error.within(path) from error


def included(said: Mapping[Any, Any]) -> list[str]:
    """Names of files in the same folder that its defaults include."""
    entries = said.get(DEFAULTS) or []
    return [entry for entry in entries if isinstance(entry, str) and entry != "_self_"]


def _n_entry(said: Any, known: dict[int, int], above: tuple[int, ...]) -> int:
    """Entries of a value; `SettingError` for one that holds itself."""
    if not isinstance(said, (dict, list)):
        return 1
    if id(said) in above:
        raise SettingError("expected values that end, got an alias (*name) of what it stands in; write it out")
    if id(said) not in known:
        inner = said.values() if isinstance(said, dict) else said
        known[id(said)] = 1 + sum(_n_entry(each, known, (*above, id(said))) for each in inner)
    return known[id(said)]


def _entries(said: Any, where: str) -> Iterator[tuple[str, Any]]:
    """Each value with its key; `SettingError` for a key that is not a name."""
    if isinstance(said, dict):
        for key, value in said.items():
            if not isinstance(key, str):
                place = f" in {where}" if where else ""
                raise SettingError(
                    f"expected names of settings before the colons{place}, got {key!r}; put it into quotes"
                )
            yield from _entries(value, f"{where}.{key}" if where else key)
    elif isinstance(said, list):
        for number, value in enumerate(said):
            yield from _entries(value, f"{where}[{number}]")
    else:
        yield where, said


def _require_value(value: Any, where: str) -> None:
    if value == MISSING:
        raise SettingError(f"expected a value, got {MISSING}; write one, or leave the line out", setting=where)
    if isinstance(value, (bytes, set)):
        raise SettingError(f"expected a text, a number or a list, got a YAML {type(value).__name__}", setting=where)
    if not isinstance(value, str):
        return
    if any(0xD800 <= ord(sign) <= 0xDFFF for sign in value):
        raise SettingError(f"expected characters, got half of one in {shortened(ascii(value))}", setting=where)
    try:
        if value:
            parse(value)
    except (OmegaConfBaseException, RecursionError):
        raise SettingError(
            f"expected ${{setting}} with both brackets, got {shortened(value)!r}; close it, or put a backslash before '$'",
            setting=where,
        ) from None


def _require_plugin(said: Any, group: str) -> None:
    """Check the settings that a file gives to the chosen plugin of a group."""
    cure = f"choose a plugin in the file's defaults, '- override /{group}: NAME'"
    if not isinstance(said, dict):
        raise SettingError(f"expected {{setting: value, ...}}, got {described(said)}; {cure}", setting=group)
    if "name" in said:
        raise SettingError(f"expected settings of a plugin, got its name; {cure}", setting=group)


def _require_collection(value: Any, key: str, type_name: str) -> None:
    """Check a setting of the bench whose type is a list of texts or a mapping."""
    if type_name.startswith("dict") and not isinstance(value, dict):
        raise SettingError(f"expected {{name: value, ...}}, got {described(value)}", setting=key)
    if type_name == "list[str]" and isinstance(value, list):
        for number, entry in enumerate(value):
            if not isinstance(entry, str):
                raise SettingError(f"expected a text, got {described(entry)}", setting=f"{key}[{number}]")


def _require_lines(lines: Any, key: str) -> None:
    """The lines of a grid: mappings of settings to a value or several."""
    if lines is None or not isinstance(lines, list):
        raise SettingError(f"expected a list of lines {{setting: value, ...}}, got {described(lines)}", setting=key)
    for number, line in enumerate(lines):
        where = f"{key}[{number}]"
        if not isinstance(line, dict):
            raise SettingError(f"expected {{setting: value, ...}}, got {described(line)}", setting=where)
        for name, value in line.items():
            if value == []:
                raise SettingError("expected at least one value, got an empty list", setting=f"{where}.{name}")
            values = value if isinstance(value, list) else [value]
            wrong = [each for each in values if not isinstance(each, str)]
            if name in GROUPS and wrong:
                raise SettingError(f"expected names of plugins, got {described(wrong[0])}", setting=f"{where}.{name}")


def _require_defaults(defaults: Any) -> None:
    example = "- override /optimizer: pso"
    if not isinstance(defaults, list):
        raise SettingError(f"expected a list, '{example}', got {described(defaults)}", setting=DEFAULTS)
    for number, entry in enumerate(defaults):
        where = f"{DEFAULTS}[{number}]"
        if isinstance(entry, str):
            continue
        if not isinstance(entry, dict) or len(entry) != 1:
            raise SettingError(f"expected '{example}', got {described(entry)}", setting=where)
        [(key, name)] = entry.items()
        found = GROUP.fullmatch(key)
        if found is None or not isinstance(name, str):
            raise SettingError(f"expected '{example}', got {key}: {described(name)}", setting=where)
        if found[2] in GROUPS and (not found[1] or "override" not in key):
            raise SettingError(f"expected 'override /{found[2]}: {name}', got '{key}: {name}'", setting=where)
