"""The log file of an experiment: when each job began, what became of each run, and why."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def experiment_log(output: Path, name: str, batch: int) -> Iterator[logging.Logger]:
    """A logger that writes into `output/name.log` and nowhere else, each line whole even where jobs share the file."""
    logger = logging.getLogger(f"bench.{name}.{batch}")
    logger.setLevel(logging.INFO)
    logger.propagate = False
    handler = logging.FileHandler(output / f"{name}.log", mode="a", encoding="utf-8")
    handler.setFormatter(logging.Formatter(f"%(asctime)s batch {batch}: %(message)s"))
    logger.addHandler(handler)
    try:
        yield logger
    finally:
        logger.removeHandler(handler)
        handler.close()
