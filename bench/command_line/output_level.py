"""Output level: -q and -v, colours, progress.

Environment variables carry it to the processes that do the work.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import TextIO

from ksmea.errors import SettingError

QUIET, VERBOSE, PROGRESS, TRACEBACK = "BENCH_QUIET", "BENCH_VERBOSE", "BENCH_PROGRESS", "BENCH_TRACEBACK"
OPTIONS = {"-q": QUIET, "--quiet": QUIET, "-v": VERBOSE, "--verbose": VERBOSE}
RED, PLAIN = "\x1b[1;31m", "\x1b[0m"


def without_level(words: Sequence[str]) -> tuple[list[str], set[str]]:
    """The words without -q and -v, and the variables that these set; `SettingError` for both at once."""
    asked = {OPTIONS[word] for word in words if word in OPTIONS}
    if len(asked) > 1:
        raise SettingError("expected -q (only errors) or -v (each run, tracebacks), got both; leave one out")
    return [word for word in words if word not in OPTIONS], asked


def is_quiet() -> bool:
    """Whether nothing but errors is to be shown."""
    return bool(os.environ.get(QUIET))


def is_verbose() -> bool:
    """Whether each run is reported as it ends and errors show their tracebacks."""
    return bool(os.environ.get(VERBOSE))


def hides_progress() -> bool | None:
    """Whether progress bars are hidden; None: where nobody looks at a terminal."""
    if is_quiet():
        return True
    return False if os.environ.get(PROGRESS) else None


def has_colours(stream: TextIO) -> bool:
    """Whether a stream is a terminal that shows colours, and nobody has requested none (no-color.org)."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def tell_error(line: str) -> None:
    """An error in one line on the error stream."""
    word = f"{RED}error:{PLAIN}" if has_colours(sys.stderr) else "error:"
    print(f"{word} {line}", file=sys.stderr)
