"""Files that are written whole or not at all, and a lock that ends with its process."""

from __future__ import annotations

import errno
import fcntl
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ksmea.errors import SettingError
from ksmea.settings.regular_files import descriptor_of_regular, open_regular

PARTIAL = re.compile(r"\.(.+\.(csv|png|json|jsonl|yaml|html)|\.drawn)\.([1-9][0-9]{0,9})")  # .NAME.PID


def replace_file(path: Path, content: bytes) -> None:
    """Write a file in one move: whatever happens in between, the old one or the new one is there.

    A link of its name is replaced, and what it points to stays as it is.
    """
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
    """A folder to be filled, which takes the path's name at the end of the block.

    Nothing of it stays where the block fails. `SettingError` if there is something of that name.
    """
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


def is_held(path: Path) -> bool:
    """Whether a process holds the lock file now."""
    try:
        with open_regular(path) as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except OSError as error:
        return error.errno in (errno.EWOULDBLOCK, errno.EACCES)
    return False


@contextmanager
def exclusive(path: Path) -> Iterator[None]:
    """Hold the lock file for the block; a one-line error where another process holds it.

    On a file system without locks (some network file systems) nothing is held, and nobody is refused.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor = descriptor_of_regular(path, os.O_RDWR | os.O_CREAT)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            os.close(descriptor)
            raise SettingError(
                f"{path.parent}: another process is working there; wait for it to end, or choose another output=DIR"
            ) from None
    try:
        yield
    finally:
        os.close(descriptor)
