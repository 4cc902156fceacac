"""A first look at the words of an experiment.

Certain errors are rejected before anything large is loaded.

Names, and plain values of settings, are held against listings alone. Whatever these cannot tell is left to what comes after,
which composes the configuration and makes the plugins.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence

from bench.command_line.bench_settings import bench_fields, default_plugins
from bench.command_line.config_dirs import EXPERIMENT, experiment_files, names_folders
from bench.command_line.corrected_command import in_brackets, without_brackets
from bench.command_line.grid import LABEL
from bench.command_line.plugin_settings import plugin_setting, unknown_key
from bench.command_line.source_settings import source_settings
from bench.command_line.word_shapes import joined_options, require_shape
from ksmea.errors import SettingError, shortened, unknown
from ksmea.plugins.names import GROUPS, registered
from ksmea.settings.regular_files import require_there

PLAIN = re.compile(r"[^\s'\"\[\]{}()$\\=,]+")  # a value without signs of Hydra's grammar
NAME = re.compile(r"[A-Za-z_][\w.-]*")
BLOCKS = "[{setting: value, ...}, ...]"
WORDS = ("null", "true", "false", "nan", "inf")  # which are no names
GRIDS = ("grid", "add", "cross")
DECIMAL_COMMA = re.compile(r"-?\d+,0\d+")
IN_WORDS = {"int": "a whole number", "float": "a number", "bool": "true or false", "str": "a text"}
OURS = {"hydra/sweeper": "plan", "hydra.mode": "MULTIRUN"}
EXPECTED = {"output": "a folder, output=. for the working directory", "name": "the name of a file", "label": "a label"}
FILES = {"problem.file": {"rotor": "YAML", "extended": "YAML"}, "measurement.path": {"file": "CSV", "campaign": "YAML"}}
GLOB = "*?"  # signs of names of several files
TRUTHS = ("y", "yes", "on", "true", "1", "n", "no", "off", "false", "0")


def looked_at(words: Sequence[str], commands: Collection[str]) -> list[str]:
    """The words, the values of options joined to them; `SettingError` for what is certainly wrong."""
    joined = joined_options(words)
    require_shape(joined, commands)
    _require_once(joined)
    said = _said(joined)
    for key, value in said.items():
        _require_known(key, value)
    if not names_folders(joined) and "plugins" not in said:  # which bring experiments and plugins of their own
        _require_names(said)
        _require_files(said)
    return joined


def _require_once(words: Sequence[str]) -> None:
    """Raise `SettingError` if two arguments set entries of one mapping.

    The first would be dropped in silence. Of two plain values or lists the last counts, as Hydra documents it.
    """
    keys: dict[str, str] = {}
    for word in words:
        key, sign, value = word.lstrip("+").partition("=")
        if sign and value.startswith("{") and keys.setdefault(key, word) != word:
            raise SettingError(
                f"expected one mapping, got {shortened(keys[key])} and {shortened(word)}; put both into one, or leave one out",
                setting=key,
            )


def _said(words: Sequence[str]) -> dict[str, str]:
    """Values by setting, as written; options and settings removed by ~ are omitted."""
    settings = [word for word in words if not word.startswith(("-", "~"))]
    return {key.lstrip("+"): value for key, _, value in (word.partition("=") for word in settings)}


def plain(value: str) -> tuple[str, ...]:
    """A value or several of a sweep, where all are written without signs of Hydra's grammar.

    Empty if one is not.

    >>> plain("de,pso"), plain("[de]")
    (('de', 'pso'), ())
    """
    parts = value.split(",")
    return tuple(parts) if all(PLAIN.fullmatch(part) for part in parts) else ()


def _require_known(key: str, value: str) -> None:
    """Whether a setting is one of the bench's, or belongs to a group; what a group knows is asked later."""
    if key in OURS and value != OURS[key]:
        raise SettingError(
            f"{key}: expected {OURS[key]}, by which all experiments are planned, got {value}; leave it out"
        )
    if "/" in key or key.partition(".")[0] == "hydra":
        return
    top, _, below = key.partition(".")
    names = [*bench_fields(), EXPERIMENT]
    if top not in names:
        raise unknown("group", top, GROUPS) if below else unknown_key(key, names)
    if not below:
        _require_value(key, value, str(bench_fields()[key].type) if key in bench_fields() else "")


def _require_value(key: str, value: str, type_name: str) -> None:
    """Whether a plain value is of a setting's type."""
    base_type, *_ = type_name.split(" | ")
    if not value:
        if key in GROUPS or key == EXPERIMENT:
            known = registered(key) if key in GROUPS else sorted(experiment_files())
            raise SettingError(f"expected one of {', '.join(known)}, got nothing", setting=key)
        if key in bench_fields() or base_type in ("int", "float", "bool"):
            raise SettingError(
                f"expected {EXPECTED.get(key, IN_WORDS.get(base_type, 'a list [a,b,...]'))}, got nothing", setting=key
            )
        return
    if base_type in ("int", "float") and DECIMAL_COMMA.fullmatch(value):
        decimal = value.replace(",", ".", 1)
        raise SettingError(
            f"expected a decimal point, or several values with commas, got '{value}'; write {decimal}",
            setting=key,
            meant=lambda _: decimal,
        )
    values = plain(value)
    if base_type.startswith("list[") and value not in WORDS:
        _require_list(key, value, base_type, values)
    if base_type.startswith("dict[") and (values or value.startswith("[")) and value not in WORDS:
        raise SettingError(
            f"expected {{name: value, ...}}, got {'a list' if value.startswith('[') else 'one value'}", setting=key
        )
    if base_type not in IN_WORDS:
        return
    if value.startswith(("[", "{")):
        raise SettingError(
            f"expected {EXPECTED.get(key, IN_WORDS[base_type])}, got a list; several values are written without brackets",
            setting=key,
            meant=without_brackets,
        )
    if key == LABEL and value == "null":
        raise SettingError("expected a label, got null; leave it out, for all of them", setting=key)
    for each in values:
        if each.casefold() not in WORDS and not _is_of(each, base_type):
            raise SettingError(f"expected {IN_WORDS[base_type]}, got '{each}'", setting=key)


def _require_list(key: str, value: str, base_type: str, values: tuple[str, ...]) -> None:
    is_blocks = base_type.startswith("list[dict")
    if values:
        raise SettingError("expected a list [a,b,...], got one value", setting=key, meant=in_brackets)
    if value.startswith(("{", "(")):
        raise SettingError(
            f"expected a list {BLOCKS if is_blocks else '[a,b,...]'}, got {'one block' if is_blocks else 'other brackets'}",
            setting=key,
            meant=in_brackets if is_blocks else lambda given: in_brackets(without_brackets(given)),
        )
    if is_blocks and value.startswith("[") and value[1:].strip() not in ("]", "") and value[1:].strip()[0] not in "{$":
        raise SettingError(f"expected a list {BLOCKS}, got a list of something else", setting=key)


def _is_of(text: str, base_type: str) -> bool:
    if base_type == "bool":
        return text.casefold() in TRUTHS
    try:
        {"int": int, "float": float}.get(base_type, str)(text)
    except ValueError:
        return False
    return True


def _require_names(said: Mapping[str, str]) -> None:
    """Whether experiments, plugins and their settings are there."""
    experiments = experiment_files()
    for name in plain(said.get(EXPERIMENT, "")):
        if name.removesuffix(".yaml") not in experiments:
            raise unknown(EXPERIMENT, name, experiments)
    for group in GROUPS:
        for name in _names(said.get(group, "")):
            if name.removesuffix(".yaml") not in registered(group):
                raise unknown(group, name, registered(group))
    for key, value in said.items():
        _require_plugin_setting(key, value, said)


def _require_files(said: Mapping[str, str]) -> None:
    """Whether a file is there that the words name for a plugin that reads it."""
    for key, kinds in FILES.items():
        group = key.partition(".")[0]
        plugin = said.get(group, next(iter(kinds)))
        paths = plain(said.get(key, ""))
        if plugin not in kinds or len(paths) != 1 or paths[0] in WORDS or set(paths[0]) & set(GLOB):
            continue  # several files are a fleet, whose error lists what its folder holds
        try:
            require_there(paths[0], kinds[plugin])
        except SettingError as error:
            raise error.within(f"{group}={plugin}", key) from error


def _names(value: str) -> list[str]:
    return [each for each in plain(value) if NAME.fullmatch(each) and each not in WORDS]


def _require_plugin_setting(key: str, value: str, said: Mapping[str, str]) -> None:
    """Whether one of the plugins that may be chosen has a setting, and a plain value of it its type."""
    asked = plugin_setting(key)
    if asked is None:
        return
    chosen = [asked.plugin] if asked.plugin is not None else _chosen(asked.group, said)
    name, _, below = asked.setting.partition(".")
    every = {each: source_settings(asked.group, each) for each in chosen or registered(asked.group)}
    settings = [found for found in every.values() if found is not None]
    if len(settings) < len(every):  # one cannot be told from its source
        return
    types = {found[name].type for found in settings if name in found}
    if not types:
        prefix = f"{asked.group}.{asked.plugin}" if asked.plugin else asked.group
        raise unknown_key(f"{prefix}.{name}", {each for found in settings for each in found})
    if len(types) == 1 and not below:
        _require_value(key, value, types.pop())
    if len(chosen) == 1 and not below and (choices := settings[0][name].choices):
        for each in plain(value):
            if each not in (*choices, *WORDS):
                raise unknown(f"value for {name}:", each, choices).within(f"{asked.group}={chosen[0]}", key)


def _chosen(group: str, said: Mapping[str, str]) -> list[str]:
    """The plugins of a group that the words choose; none if an experiment or a grid may choose others."""
    if group in said:
        names = [each.removesuffix(".yaml") for each in plain(said[group])]
        return [each for each in names if each in registered(group)] if names else []
    return [] if EXPERIMENT in said or any(key in said for key in GRIDS) else [default_plugins()[group]]
