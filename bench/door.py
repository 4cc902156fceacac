"""Dispatch of the command line, and the last place where an error becomes one line and an exit code."""

from __future__ import annotations

import os
import sys
import traceback
from pathlib import Path

import hydra
from omegaconf import DictConfig

from bench.config import CONF, register_schemas
from bench.help import help_text
from bench.messages import USER_ERRORS, one_line
from bench.work import work
from ksmea.errors import SettingError, unknown

BAD_INPUT, INTERRUPTED = 2, 130
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


def run(words: list[str]) -> int:
    try:
        if words and words[0] in HELP:
            print(help_text(words[1:]))
            return 0
        return _experiment(words)
    except SettingError as error:
        return _refused(str(error))
    except USER_ERRORS as error:
        return _refused(one_line(error))
    except OSError as error:
        return _refused(f"{error.filename or 'output'}: {error.strerror}; choose another output=DIR")
    except KeyboardInterrupt:
        print("interrupted: finished runs are kept, the same command does the rest", file=sys.stderr)
        return INTERRUPTED


def _experiment(words: list[str]) -> int:
    """Hand all words to Hydra, which plans, launches and collects through the plan sweeper."""
    for word in words:
        if word.startswith("-") and word.partition("=")[0] not in HYDRA_OPTIONS:
            raise unknown("option", word, HYDRA_OPTIONS)
    os.environ["HYDRA_FULL_ERROR"] = "1"  # errors come here as they are; this is the only place that prints them
    register_schemas()
    sys.argv[1:] = [f"+{word}" if word.startswith("experiment=") else word for word in words]
    if not any(word.startswith("-") for word in words):
        sys.argv.append("--multirun")  # conf/config.yaml says so too, but Hydra forgets it where composing fails
    try:
        _job()
    except SystemExit as exit:
        return int(exit.code or 0)
    return 0


@hydra.main(version_base="1.3", config_path=str(CONF), config_name="config")
def _job(config: DictConfig) -> None:
    """One job: a share of the plan's runs."""
    work(Path(config.output), config.batch, config.batches, config.workers, config.timeout)


def _refused(line: str) -> int:
    if os.environ.get("BENCH_TRACEBACK"):
        traceback.print_exc()
    print(f"error: {line}", file=sys.stderr)
    return BAD_INPUT
