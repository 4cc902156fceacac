"""Dispatch of the command line, and the last place where an error becomes one line and an exit code."""

from __future__ import annotations

import errno
import os
import sys
import traceback
from collections.abc import Callable

import hydra
from omegaconf import DictConfig

from bench.command_line.config import register_schemas
from bench.command_line.help import help_text
from bench.command_line.messages import USER_ERRORS, one_line
from bench.command_line.offered import require_offered
from bench.command_line.overrides import for_some_plugins, parse
from bench.commands.results import COMMANDS
from bench.jobs.deal import job_of
from bench.jobs.work import work
from bench.storage.places import CONF
from ksmea import registry
from ksmea.errors import SettingError, unknown, visible

FAILED, BAD_INPUT, INTERRUPTED, BROKEN_PIPE = 1, 2, 130, 141
DISK_TROUBLE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
HELP = ("help", "--help", "-h")
HYDRA_OPTIONS = (
    "--multirun",
    "-m",
    "--cfg",
    "-c",
    "--info",
    "-i",
    "--config-dir",
    "-cd",
    "--package",
    "-p",
    "--resolve",
    "--version",
)


def _to_stderr(line: str) -> None:
    print(f"error: {line}", file=sys.stderr)


def run(words: list[str], refuse: Callable[[str], None] = _to_stderr) -> int:
    """Do what the words say; the exit code. `refuse` is told in one line why they cannot be done."""
    try:
        if words and words[0] in HELP:
            print(help_text(words[1:]))
            return 0
        if words and words[0] in COMMANDS:
            return COMMANDS[words[0]](words[1:])
        return _experiment(words)
    except SettingError as error:
        return _refused(str(error), refuse)
    except USER_ERRORS as error:
        return _refused(one_line(error), refuse)
    except BrokenPipeError:  # who reads what is printed has gone; the files are written
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except OSError as error:
        return _cannot_write(error, refuse)
    except KeyboardInterrupt:
        print("interrupted: finished runs are kept, the same command does the rest", file=sys.stderr)
        return INTERRUPTED


def _experiment(words: list[str]) -> int:
    """Hand all words to Hydra, which plans, launches and collects through the plan sweeper."""
    for word in words:
        if word.startswith("-") and word.partition("=")[0] not in HYDRA_OPTIONS:
            raise unknown("option", word, HYDRA_OPTIONS)
    _check_names(words)
    os.environ["HYDRA_FULL_ERROR"] = "1"  # errors come here as they are; this is the only place that prints them
    register_schemas()
    options = [word for word in words if word.startswith("-") or "=" not in word]  # argparse wants them side by side
    settings = [word for word in words if word not in options]
    if not any(word.startswith("-") for word in words):
        settings = for_some_plugins(settings, registry.GROUPS)
    sys.argv[1:] = [*options, *(f"+{word}" if word.startswith("experiment=") else word for word in settings)]
    if not any(word.startswith("-") for word in words):
        sys.argv.append("--multirun")  # conf/config.yaml says so too, but Hydra forgets it where composing fails
    try:
        _job()
    except SystemExit as exit:
        return int(exit.code or 0)
    return 0


def _check_names(words: list[str]) -> None:
    """Every choice of a plugin is a name; Hydra itself fails on a number or null there, and merges a list. It knows no
    setting of a plugin that has one which it cannot offer."""
    for choice in parse([word for word in words if "=" in word and not word.startswith("-")]):
        for name in choice.values:
            if choice.key in registry.GROUPS and not isinstance(name, str):
                raise unknown(choice.key, str(name), registry.registered(choice.key))
            if choice.key in registry.GROUPS and name in registry.registered(choice.key):
                require_offered(choice.key, name)


@hydra.main(version_base="1.3", config_path=str(CONF), config_name="config")
def _job(config: DictConfig) -> None:
    """One job: a share of the plan's runs."""
    work(job_of(config))


def _cannot_write(error: OSError, refuse: Callable[[str], None]) -> int:
    """A folder that cannot be used is bad input; a disk that fills up is not, and what was written before is kept."""
    place = error.filename or "output"
    if error.errno in DISK_TROUBLE:
        _refused(
            f"{place}: {error.strerror}; finished runs are kept: make room and give the same command again", refuse
        )
        return FAILED
    return _refused(f"{place}: {error.strerror}; choose another output=DIR", refuse)


def _refused(line: str, refuse: Callable[[str], None]) -> int:
    if os.environ.get("BENCH_TRACEBACK"):
        traceback.print_exc()
    refuse(visible(line))
    return BAD_INPUT
