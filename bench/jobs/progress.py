"""Progress of a job: a bar with rate and remaining time on the terminal, and the log file of the experiment."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tqdm import tqdm

from bench.command_line.output_level import hides_progress
from ksmea.errors import visible_lines
from ksmea.settings.regular_files import open_regular


def progress_bar(name: str, n_step: int, unit: str = "run") -> tqdm:
    """A bar on the error stream; none where nobody looks at a terminal, or only errors are to be shown."""
    return tqdm(total=n_step, desc=name, unit=unit, disable=hides_progress(), dynamic_ncols=True)


@contextmanager
def experiment_log(output: Path, name: str, batch: int) -> Iterator[logging.Logger]:
    """A logger that writes into `output/name.log` and nowhere else, each line whole even where jobs share the file."""
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
        handler.close()


class _OwnFile(logging.FileHandler):
    """A handler that appends to a regular file alone."""

    def _open(self) -> io.TextIOWrapper:
        return io.TextIOWrapper(open_regular(Path(self.baseFilename), "ab"), encoding="utf-8", write_through=True)


class _Visible(logging.Formatter):
    """Lines as a terminal may show them."""

    def format(self, record: logging.LogRecord) -> str:
        return visible_lines(super().format(record))
