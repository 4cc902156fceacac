"""Dispatch of the command line, and the last place where an error becomes one line and an exit code.

Experiments and commands on results are imported when they are asked for: help comes at once.
"""

from __future__ import annotations

import errno
import os
import sys
import traceback
from collections.abc import Callable

from bench.command_line.help import help_text
from bench.commands.results import COMMANDS, run_command
from ksmea.errors import SettingError, visible

FAILED, BAD_INPUT, INTERRUPTED, BROKEN_PIPE = 1, 2, 130, 141
DISK_TROUBLE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
HELP = ("help", "--help", "-h")


def _to_stderr(line: str) -> None:
    print(f"error: {line}", file=sys.stderr)


def run(words: list[str], refuse: Callable[[str], None] = _to_stderr) -> int:
    """Do what the words say; the exit code. `refuse` is told in one line why they cannot be done."""
    try:
        if words and words[0] in HELP:
            print(help_text(words[1:]))
            return 0
        if words and words[0] in COMMANDS:
            return run_command(words)
        from bench.run_experiment import run_experiment

        return run_experiment(words)
    except SettingError as error:
        return _refused(str(error), refuse)
    except BrokenPipeError:  # who reads what is printed has gone; the files are written
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except OSError as error:
        return _cannot_write(error, refuse)
    except KeyboardInterrupt:
        print("interrupted: finished runs are kept, the same command does the rest", file=sys.stderr)
        return INTERRUPTED


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
