"""Files that are there whole or not at all."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ksmea.errors import SettingError
from ksmea.regular_files import open_regular

PARTIAL = re.compile(r"\.(.+\.(csv|png|json|jsonl|yaml|html)|\.drawn)\.([1-9][0-9]{0,9})")  # .NAME.PID


def replace_file(path: Path, content: bytes) -> None:
    """Write a file in one move: whatever happens in between, the old one or the new one is there. A link of its name is
    replaced, and what it points to stays as it is."""
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    partial.unlink(missing_ok=True)  # of an earlier process with this number
    try:
        with open_regular(partial, "xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


@contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """A folder to be filled, which takes the path's name at the end of the block; nothing of it stays where the block fails.
    `SettingError` where there is something of that name."""
    if path.exists():
        raise SettingError(f"expected no {path} yet, found one; choose another --out, or remove it")
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        partial.mkdir(parents=True)
        yield partial
        partial.rename(path)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def remove_partial(folder: Path) -> None:
    """Remove what processes that are gone left unfinished in a folder."""
    for path in folder.glob(".*"):
        found = PARTIAL.fullmatch(path.name)
        if found and path.is_file() and not path.is_symlink() and not _is_running(int(found[3])):
            path.unlink(missing_ok=True)


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:  # another user's
        return True
    return True
