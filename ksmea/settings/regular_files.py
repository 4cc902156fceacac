"""Opening the program's own files: regular ones alone, and never what a link points to.

A folder of results may come from anywhere. A pipe in the place of a file would be waited for for ever, and a link would
be written through to whatever it names.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO, cast

from ksmea.errors import SettingError

FLAGS = {
    "rb": os.O_RDONLY,
    "ab": os.O_WRONLY | os.O_APPEND | os.O_CREAT,
    "r+b": os.O_RDWR,
    "w+b": os.O_RDWR | os.O_CREAT,
    "xb": os.O_WRONLY | os.O_CREAT | os.O_EXCL,
}
FILE_TYPES = {stat.S_IFIFO: "a pipe", stat.S_IFDIR: "a directory", stat.S_IFSOCK: "a socket", stat.S_IFLNK: "a link"}


def open_regular(path: Path, mode: str = "rb") -> BinaryIO:
    """A file opened in a binary mode; `SettingError` where something else than a regular file has its name.

    The other errors are those of `open`. 'w+b' leaves what is in the file.
    """
    descriptor = descriptor_of_regular(path, FLAGS[mode])
    return cast(BinaryIO, os.fdopen(descriptor, "wb" if mode == "xb" else mode.replace("w+", "r+")))


def descriptor_of_regular(path: Path, flags: int) -> int:
    """The same as a file descriptor."""
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
