"""The words of an experiment on their way through Hydra: checked, composed, planned and done."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import hydra
from omegaconf import DictConfig

from bench.command_line.config_dirs import CONFIG_DIR
from bench.command_line.config_files import chosen_files, require_experiments, with_file
from bench.command_line.messages import USER_ERRORS, arose_in_hydra, in_our_words
from bench.command_line.overrides import for_some_plugins, parse, with_quoted_files
from bench.command_line.plugin_words import register_plugins
from bench.command_line.schema import plugin_schema
from bench.jobs.offers import job_of
from bench.jobs.work import work
from bench.storage.own_files import CONF
from ksmea.errors import SettingError, unknown
from ksmea.plugins import registry


def run_experiment(words: list[str]) -> int:
    """Hand all words to Hydra, which plans, launches and collects through the plan sweeper; the exit code.

    Raises `SettingError` for words that cannot be done.
    """
    paths: list[Path] = []
    words = with_quoted_files(words)
    try:
        paths = chosen_files(words)
        return _run(words, paths)
    except Exception as error:
        if not isinstance(error, (SettingError, *USER_ERRORS)) and not arose_in_hydra(error):
            raise
        is_ours = isinstance(error, SettingError)
        wrong = error if isinstance(error, SettingError) else in_our_words(error)
        located = with_file(wrong, paths, words, is_composed=not is_ours)
        if located is error:
            raise
        raise located from error


def _run(words: list[str], paths: list[Path]) -> int:
    require_experiments(paths)
    register_plugins(words)
    _check_names(words)
    os.environ["HYDRA_FULL_ERROR"] = "1"  # errors come here as they are; this is the only place that prints them
    options = [word for word in words if word.startswith("-") or "=" not in word]  # argparse wants them side by side
    settings = [word for word in words if word not in options]
    is_run = all(option.partition("=")[0] in CONFIG_DIR for option in options if option.startswith("-"))
    if is_run:
        settings = for_some_plugins(settings, registry.GROUPS)
    sys.argv[1:] = [*options, *(f"+{word}" if word.startswith("experiment=") else word for word in settings)]
    if is_run:
        sys.argv.append(
            "--multirun"
        )  # the primary configuration says so too, but Hydra forgets it where composing fails
    try:
        _job()
    except SystemExit as exit:
        return int(exit.code or 0)
    return 0


def _check_names(words: list[str]) -> None:
    """Every sweep has a value, and every choice of a plugin is a name.

    Hydra itself fails on a number or null there, and merges a list. It knows no setting of a plugin that has one which
    it cannot offer.
    """
    for choice in parse([word for word in words if "=" in word and not word.startswith("-")]):
        if choice.override.is_sweep_override() and not choice.values:
            known = f"; known: {', '.join(registry.registered(choice.key))}" if choice.key in registry.GROUPS else ""
            raise SettingError(f"expected a sweep of at least one value, got {choice.override.input_line}{known}")
        for name in choice.values:
            if choice.key in registry.GROUPS and not isinstance(name, str):
                raise unknown(choice.key, str(name), registry.registered(choice.key))
            is_known = choice.key in registry.GROUPS and name in registry.registered(choice.key)
            if is_known and (len(choice.values) == 1 or not registry.is_outside(choice.key, name)):
                plugin_schema(choice.key, name)  # of several from outside, those that cannot be used are left out


@hydra.main(version_base="1.3", config_path=str(CONF), config_name="config")
def _job(config: DictConfig) -> None:
    """One job: a share of the plan's runs."""
    work(job_of(config))
