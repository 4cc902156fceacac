"""One process at a time: a lock on a file, which the system releases when the process ends, however it ends."""

from __future__ import annotations

import errno
import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ksmea.errors import SettingError
from ksmea.regular_files import descriptor_of_regular, open_regular


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
