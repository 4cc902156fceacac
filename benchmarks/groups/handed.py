"""Files that all sides of a row are handed, made once and removed with the process."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path


@cache
def samples(n: int, q: int = 106) -> str:
    """Samples for surrogates (`benchmarks.tasks.responses`)."""
    from benchmarks.tasks.responses import write

    path = _folder() / f"samples_{n}_{q}.npz"
    write(path, n, q)
    return str(path)


@cache
def run_ups() -> str:
    """Measured data (`benchmarks.tasks.run_ups`)."""
    from benchmarks.tasks.run_ups import write

    path = _folder() / "run_ups.npz"
    write(path)
    return str(path)


@cache
def _folder() -> Path:
    folder = tempfile.mkdtemp(prefix="ksmea-benchmarks-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)
