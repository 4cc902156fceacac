"""Dispatch of the command line, and the last place where an error becomes one line and an exit code.

Experiments, commands and help are imported when they are requested: what is refused, and help, come at once.
"""

from __future__ import annotations

import errno
import io
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import ExitStack, redirect_stdout

from bench.command_line.corrected_command import with_cure
from bench.command_line.output_level import TRACEBACK, is_quiet, is_verbose, tell_error, without_level
from bench.command_line.plain_signs import print_any_sign
from bench.commands.dispatch import COMMANDS, run_command
from ksmea.errors import SettingError, visible

FAILED, BAD_INPUT, INTERRUPTED, BROKEN_PIPE, TERMINATED = 1, 2, 130, 141, 143
TOO_MANY = (errno.EMFILE, errno.ENFILE, errno.EAGAIN, errno.ENOMEM)  # files, processes or bytes at once
DISK_TROUBLE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
HELP, VERSION = ("help", "--help", "-h"), ("--version", "version")
COMPLETION, COMPLETE = "completion", "_complete"  # what prints a shell's script, and what that calls


def run(words: list[str], refuse: Callable[[str], None] = tell_error) -> int:
    """Execute the words and return the exit code; `refuse` receives an error as one line."""
    print_any_sign()
    with ExitStack() as shown:
        try:
            return _done(words if words[:1] == [COMPLETE] else _with_level(words, shown))
        except SettingError as error:
            return _interrupted(error) if _was_interrupted(error) else _refused(with_cure(error, words), refuse)
        except BrokenPipeError:  # who reads what is printed has gone; the files are written
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return BROKEN_PIPE
        except OSError as error:
            return _interrupted(error) if _was_interrupted(error) else _cannot_write(error, refuse)
        except KeyboardInterrupt as error:
            return _interrupted(error)
        except Exception as error:
            if _was_interrupted(error):
                return _interrupted(error)
            raise


class Terminated(KeyboardInterrupt):
    """SIGTERM, by which a scheduler or `kill` asks a process to end: as Ctrl-C."""


def _interrupted(error: BaseException) -> int:
    print("interrupted: finished runs are kept, the same command does the rest", file=sys.stderr)
    return TERMINATED if any(isinstance(each, Terminated) for each in _causes(error)) else INTERRUPTED


def _was_interrupted(error: BaseException) -> bool:
    """Whether an error came of Ctrl-C or SIGTERM: libraries that tidy up then may raise one of their own."""
    return any(isinstance(each, KeyboardInterrupt) for each in _causes(error))


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _with_level(words: list[str], shown: ExitStack) -> list[str]:
    """The words without -q and -v, which hold as long as `shown` is open."""
    others, asked = without_level(words)
    for variable in asked:
        before = os.environ.get(variable)
        os.environ[variable] = "1"
        shown.callback(_restore, variable, before)
    if is_quiet():
        shown.enter_context(redirect_stdout(_Nowhere()))
    return others


class _Nowhere(io.TextIOBase):
    """Takes whatever is written to it."""

    def write(self, text: str) -> int:
        return len(text)


def _restore(variable: str, before: str | None) -> None:
    if before is None:
        os.environ.pop(variable, None)
    else:
        os.environ[variable] = before


def _done(words: list[str]) -> int:
    if not words:
        return _printed(_start_text())
    if any("\0" in word for word in words):  # no shell passes one on; files with such names raise ValueError
        raise SettingError("expected arguments without NUL characters, got one; leave it out")
    first, *others = words
    asks = [word for word in words if word in HELP[1:]]
    if first in (*COMMANDS, COMPLETION, *HELP[:1]) and asks:
        return _printed(_help_text([first]))
    if asks or first == HELP[0]:  # of an experiment, or of whatever is named
        return _printed(_help_text([word for word in (others if first == HELP[0] else words) if word not in asks]))
    if first in (COMPLETION, COMPLETE):
        return _printed(_completion(first, others))
    if first in VERSION or VERSION[0] in others:
        return _printed(_version_text())
    if first in COMMANDS:
        return run_command(words)
    return _experiment(words)


def _experiment(words: list[str]) -> int:
    """An experiment: what is certainly wrong is rejected before Hydra and the plugins are loaded."""
    from bench.command_line.quick_check import looked_at

    known = looked_at(words, [*COMMANDS, COMPLETION, "help", "version"])
    from bench.run_experiment import run_experiment

    return run_experiment(known)


def _start_text() -> str:
    from bench.help.help import start_text

    return start_text()


def _help_text(words: list[str]) -> str:
    from bench.help.help import help_text

    return help_text(words)


def _version_text() -> str:
    from bench.help.help import version_text

    return version_text()


def _completion(asked: str, words: list[str]) -> str:
    """A shell's script, or the completions that it requests."""
    from bench.help.completion import completed, script

    return script(words) if asked == COMPLETION else completed(words)


def _printed(text: str) -> int:
    print(text)
    sys.stdout.flush()
    return 0


def _cannot_write(error: OSError, refuse: Callable[[str], None]) -> int:
    """A folder that cannot be used is bad input.

    A disk that fills up is not, and what was written before is kept.
    """
    if error.errno in TOO_MANY and (not error.filename or error.errno in (errno.EMFILE, errno.ENFILE)):
        _refused(
            f"workers: expected files, processes and memory for all workers, got: {error.strerror}; finished runs are kept: give the"
            " same command with fewer workers, such as workers=2 (ulimit -n and -u show the limits)",
            refuse,
        )
        return FAILED
    place = error.filename or "output"
    if error.errno in DISK_TROUBLE:
        _refused(
            f"{place}: {error.strerror}; finished runs are kept: make room and give the same command again", refuse
        )
        return FAILED
    return _refused(f"{place}: {error.strerror}; choose another output=DIR", refuse)


def _refused(line: str, refuse: Callable[[str], None]) -> int:
    if os.environ.get(TRACEBACK) or is_verbose():
        traceback.print_exc()
    refuse(visible(line))
    return BAD_INPUT
