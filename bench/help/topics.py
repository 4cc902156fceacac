"""Help on whatever has a name.

A command, an experiment, a group of plugins, a plugin, a setting, a term.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from bench.command_line.bench_settings import bench_fields
from bench.command_line.config_dirs import EXPERIMENT
from bench.command_line.source_settings import source_settings
from bench.help.commands import command_names, command_text
from bench.help.experiments import experiment_text
from bench.help.glossary import explained, mentioned, terms
from bench.help.plugins import Problem, group_text, plugin_text, setting_line, setting_text
from ksmea.errors import SettingError, UnknownName, nearest, shortened
from ksmea.plugins.names import FURTHER, GROUPS, registered

ALL = (*GROUPS, *FURTHER)
MOST_NEAR = 4  # names that an unknown one might have meant
LEAST_ALIKE = 0.65  # ratio from which on names are alike


def topic_text(words: Sequence[str], experiments: Mapping[str, Path], usage: str) -> str:
    """All that has one of the names.

    Raises `SettingError` for a name that nothing has. problem=NAME next to the name of an effect chooses the problem
    that its limits are shown for.
    """
    asked, problem = _with_problem(words)
    first, *names = asked
    if first in ALL and names:
        return "\n\n".join(plugin_text(first, name, problem) for name in names)
    if names and (entries := explained(" ".join(asked))):  # a term of several words without quotes
        return "\n\n".join(map(str, entries))
    return "\n\n".join(_topic(word, experiments, usage, problem) for word in asked)


def _with_problem(words: Sequence[str]) -> tuple[list[str], Problem]:
    """The words that ask, and the problem that the others set."""
    said = dict(word.split("=", 1) for word in words if word.startswith(("problem=", "problem.")) and "=" in word)
    others = [word for word in words if word.partition("=")[0] not in said]
    if not said or not others:
        return list(words), Problem()
    settings: dict[str, Any] = {}
    for key, value in said.items():
        if key != "problem":
            settings[key.removeprefix("problem.")] = yaml.safe_load(value)
    return others, Problem(said.get("problem", Problem().name), settings, was_asked=True)


def _topic(word: str, experiments: Mapping[str, Path], usage: str, problem: Problem) -> str:
    key, sign, value = word.lstrip("+").partition("=")
    if sign and key in (EXPERIMENT, *ALL):  # as on a command line
        texts = [
            experiment_text(name, experiments[name])
            if key == EXPERIMENT and name in experiments
            else _named(key, name, problem)
            for name in value.split(",")
        ]
        return "\n\n".join(texts)
    found = [
        *([command_text(key, usage)] if key in command_names(usage) else []),
        *([group_text(key, problem)] if key in ALL else []),
        *([experiment_text(key, experiments[key])] if key in experiments else []),
        *(plugin_text(group, key, problem) for group in ALL if key in registered(group)),
        *_setting_texts(key),
        *map(str, explained(word)),
    ]
    if not found:
        found = [*map(str, mentioned(word))]
    if not found:
        raise _not_known(word, [*_names(experiments, usage), *terms()])
    return "\n\n".join(found)


def _not_known(word: str, names: Sequence[str]) -> SettingError:
    """Error for an unknown word: the nearest of hundreds of names, and the command that lists them."""
    folded = {each.casefold(): each for each in sorted(names)}
    alike = [folded[each] for each in get_close_matches(word.casefold(), folded, n=MOST_NEAR, cutoff=LEAST_ALIKE)]
    best = nearest(word, names)
    others = ", ".join(each for each in alike if best and each.casefold() != best.casefold())
    hint = f"did you mean '{best}'? {f'also near: {others}; ' if others else ''}" if best else ""
    return SettingError(
        f"unknown name '{shortened(word)}'; {hint}python -m bench help lists commands, experiments and plugins",
        meant=UnknownName("name", word, best),
    )


def _named(group: str, name: str, problem: Problem) -> str:
    if group == EXPERIMENT:
        raise SettingError(f"expected an experiment, got {name}; python -m bench help lists them")
    return plugin_text(group, name, problem)


def _setting_texts(key: str) -> list[str]:
    """A setting of the bench; one of plugins: GROUP.SETTING, GROUP.PLUGIN.SETTING, or SETTING alone."""
    own = key in bench_fields() and key not in GROUPS
    texts = [f"{setting_line(key, bench_fields()[key])} (of the whole experiment)"] if own else []
    group, _, setting = key.rpartition(".")
    top, _, plugin = group.partition(".")
    if top in ALL and plugin in registered(top):
        pairs = [(top, plugin)]
    elif top in ALL and not plugin:
        pairs = [(top, name) for name in registered(top)]
    elif not group:
        pairs = [(each, name) for each in ALL for name in registered(each)]
    else:
        return texts
    having = [(each, name) for each, name in pairs if setting in (source_settings(each, name) or (setting,))]
    return [*texts, *filter(None, (setting_text(each, name, setting) for each, name in having))]


def _names(experiments: Mapping[str, Path], usage: str) -> list[str]:
    """All names that help knows, plugins' settings left out: they are many."""
    plugins = {name for group in ALL for name in registered(group)}
    return sorted({*command_names(usage), *ALL, *experiments, *plugins, *bench_fields()})
