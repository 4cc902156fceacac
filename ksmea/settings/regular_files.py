"""Reading a file that a user names, and opening the program's own.

Regular ones alone, and of these never what a link points to.

A folder of results may come from anywhere. A pipe in the place of a file would be waited for for ever, and a link would
be written through to whatever it names.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, cast

from ksmea.errors import SettingError, shortened

LONGEST_REASON = 200  # characters of the system's own words

FLAGS = {
    "rb": os.O_RDONLY,
    "ab": os.O_WRONLY | os.O_APPEND | os.O_CREAT,
    "r+b": os.O_RDWR,
    "w+b": os.O_RDWR | os.O_CREAT,
    "xb": os.O_WRONLY | os.O_CREAT | os.O_EXCL,
}
FILE_TYPES = {stat.S_IFIFO: "a pipe", stat.S_IFDIR: "a directory", stat.S_IFSOCK: "a socket", stat.S_IFLNK: "a link"}


def read_input(path: str, kind: str, most: int, too_large: Callable[[int], str]) -> bytes:
    """Read the content of a file of a kind, such as "YAML".

    Raises `SettingError` if it does not exist, cannot be read or has more than `most` bytes: `too_large` makes the
    message from their number, before they are read.
    """
    try:
        file = require_there(path, kind)
        if (size := file.stat().st_size) > most:
            raise SettingError(f"{path}: {too_large(size)}")
        with file.open("rb") as opened:
            content = opened.read(most + 1)  # one that grows, or has no size of its own (/proc), is no larger either
        if len(content) > most:
            raise SettingError(f"{path}: {too_large(len(content))}")
        return content
    except SettingError:
        raise
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error


def require_there(path: str, kind: str) -> Path:
    """The regular file of a kind at a path; raises `SettingError` without one."""
    file = Path(path).expanduser()
    try:
        if file.is_dir():
            raise SettingError(f"{path}: expected a {kind} file, got a directory; name a file in it")
        if not file.exists():
            raise SettingError(f"{path}: expected a {kind} file, found none (working directory: {Path.cwd()})")
        if not file.is_file():
            raise SettingError(
                f"{path}: expected a {kind} file, got something that is not a regular file; copy it into one"
            )
    except SettingError:
        raise
    except (OSError, ValueError) as error:  # a name too long or with a NUL, a folder that may not be searched
        raise _unreadable(path, error) from error
    return file


def _unreadable(path: str, error: Exception) -> SettingError:
    return SettingError(f"{path}: expected a file that can be read, got {shortened(str(error), LONGEST_REASON)}")


def open_regular(path: Path, mode: str = "rb") -> BinaryIO:
    """Open a file in a binary mode; `SettingError` if its name belongs to anything but a regular file.

    Other errors are raised as by `open`. 'w+b' keeps the content of the file.
    """
    descriptor = descriptor_of_regular(path, FLAGS[mode])
    return cast(BinaryIO, os.fdopen(descriptor, "wb" if mode == "xb" else mode.replace("w+", "r+")))


def descriptor_of_regular(path: Path, flags: int) -> int:
    """File descriptor of a regular file."""
    try:
        descriptor = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    except OSError as error:
        if error.errno in (errno.ELOOP, errno.EISDIR, errno.ENXIO):  # a link, a directory, a pipe or socket to write to
            raise _no_regular_file(path) from error
        raise
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise _no_regular_file(path)
    return descriptor


def _no_regular_file(path: Path) -> SettingError:
    file_type = FILE_TYPES.get(stat.S_IFMT(os.lstat(path).st_mode), "a device")
    return SettingError(f"{path}: expected a regular file, got {file_type}; remove it, or put a copy of the file there")
