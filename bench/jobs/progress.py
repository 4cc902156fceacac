"""Progress of a job: a bar on the terminal, and the log file of the experiment.

The bar has rate and remaining time.
"""

from __future__ import annotations

import io
import logging
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Protocol, TextIO

from tqdm import tqdm

from bench.command_line.output_level import hides_progress
from ksmea.errors import visible, visible_lines
from ksmea.settings.regular_files import open_regular

EVERY = 60.0  # s between two lines of progress


class Progress(Protocol):
    """How far many steps are: `update` after each, `tick` at least every few seconds."""

    def update(self) -> None: ...

    def tick(self) -> None: ...

    def tell(self, line: str) -> None: ...


@contextmanager
def progress_bar(name: str, n_step: int, unit: str = "run") -> Iterator[Progress]:
    """A bar on a terminal's error stream.

    A line a minute into a file, a pipe or a terminal without a size; nothing if only errors are to be shown.
    """
    hidden = hides_progress()
    if hidden or (hidden is None and not _has_room(sys.stderr)):
        yield Lines(name, n_step, unit, is_quiet=bool(hidden))
        return
    with tqdm(total=n_step, desc=name, unit=unit, dynamic_ncols=True) as bar:
        yield _Bar(bar)


def _has_room(stream: TextIO) -> bool:
    """Whether a stream is a terminal that a bar fits on."""
    try:
        return stream.isatty() and os.get_terminal_size(stream.fileno()).columns > 0
    except (OSError, ValueError):  # io.UnsupportedOperation is both
        return False


class _Bar:
    def __init__(self, bar: tqdm) -> None:
        self._bar = bar

    def update(self) -> None:
        self._bar.update()

    def tick(self) -> None:
        pass

    def tell(self, line: str) -> None:
        self._bar.write(line, file=sys.stderr)


class Lines:
    """A line a minute, none of what takes less."""

    def __init__(self, name: str, n_step: int, unit: str, is_quiet: bool = False) -> None:
        self._name, self._n_step, self._unit, self._is_quiet = name, n_step, unit, is_quiet
        self._n_done = 0
        self._began = self._said = time.monotonic()

    def update(self) -> None:
        self._n_done += 1
        self.tick()

    def tick(self) -> None:
        now = time.monotonic()
        if self._is_quiet or now - self._said < EVERY:
            return
        self._said, elapsed = now, now - self._began
        left = ""
        if self._n_done:
            left = f", about {_minutes(elapsed * (self._n_step / self._n_done - 1))} left"
        done = f"{self._n_done} of {self._n_step} {self._unit}s"
        self.tell(visible(f"{self._name}: {done} after {_minutes(elapsed)}{left}"))

    def tell(self, line: str) -> None:
        print(line, file=sys.stderr, flush=True)


def _minutes(seconds: float) -> str:
    """A time as a line tells it.

    >>> [_minutes(each) for each in (90.0, 2 * 3600.0, 60 * 3600.0)]
    ['2 min', '2.0 h', '2.5 days']
    """
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h" if seconds < 48 * 3600 else f"{seconds / 86400:.1f} days"


@contextmanager
def experiment_log(output: Path, name: str, batch: int) -> Iterator[logging.Logger]:
    """Logger that writes into `output/name.log` and nowhere else.

    Each line is whole even if jobs share the file.
    """
    logger = logging.getLogger(f"bench.{name}.{batch}")
    logger.setLevel(logging.INFO)
    logger.propagate = False
    handler = _OwnFile(output / f"{name}.log", mode="a", encoding="utf-8")
    handler.setFormatter(_Visible(f"%(asctime)s batch {batch}: %(message)s"))
    logger.addHandler(handler)
    try:
        yield logger
    finally:
        logger.removeHandler(handler)
        with suppress(OSError):  # what a full disk did not take
            handler.close()


class _OwnFile(logging.FileHandler):
    """A handler that appends to a regular file alone.

    A line that a full disk does not take is lost without a word: the records say what happened, and whoever writes
    those says that the disk is full.
    """

    def handleError(self, record: logging.LogRecord) -> None:
        if not isinstance(sys.exc_info()[1], OSError):
            super().handleError(record)

    def _open(self) -> io.TextIOWrapper:
        return io.TextIOWrapper(open_regular(Path(self.baseFilename), "ab"), encoding="utf-8", write_through=True)


class _Visible(logging.Formatter):
    """Lines as a terminal may show them."""

    def format(self, record: logging.LogRecord) -> str:
        return visible_lines(super().format(record))
