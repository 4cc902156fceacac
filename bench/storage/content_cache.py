"""Cache of values that follow from the content of files, in the user's folder for caches.

An entry is found by the hash of the content that it follows from, so that it cannot be out of date: an edited file is
another one. The folder is `ksmea-bench` in `BENCH_CACHE` (no cache if that is empty), else in `XDG_CACHE_HOME` or
`~/.cache`. If it cannot be read or written, all values are recomputed. It is written in one move: of two processes that
write at the same time one loses its additions, which the next one recomputes.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from types import GenericAlias
from typing import Generic, TypeVar

import msgspec

from bench.storage.files import remove_partial, replace_file
from ksmea.errors import SettingError
from ksmea.settings.regular_files import open_regular

FOLDER = "BENCH_CACHE"
OWN = "ksmea-bench"  # the folder in it, whose files are no one else's
MOST = 5000  # entries; beyond, those alone are kept that were asked for last
Value = TypeVar("Value")


class KeptByContent(Generic[Value]):
    """Values computed by a pure function of bytes, kept in a file of this name.

    `msgspec` must be able to write their type. The name must change with the function.
    """

    def __init__(self, name: str, value_type: type[Value], make: Callable[[bytes], Value]) -> None:
        folder = cache_folder()
        self._file = None if folder is None else folder / name
        self._make = make
        self._kept = {} if self._file is None else _read(self._file, value_type)
        self._asked: dict[str, Value] = {}

    def of(self, content: bytes) -> Value:
        """The value of this content."""
        digest = hashlib.sha256(content).hexdigest()
        if digest not in self._asked:
            self._asked[digest] = self._kept[digest] if digest in self._kept else self._make(content)
        return self._asked[digest]

    def keep(self) -> None:
        """Write what was made, as far as that is possible."""
        if self._file is None or self._asked.keys() <= self._kept.keys():
            return
        together = self._kept | self._asked
        self._kept = together if len(together) <= MOST else dict(self._asked)
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            remove_partial(self._file.parent)
            replace_file(self._file, msgspec.json.encode(self._kept))
        except OSError:
            self._file = None  # a folder that cannot be written: not tried again


def cache_folder() -> Path | None:
    """The folder for what is kept between processes; None if there is to be none."""
    chosen = os.environ.get(FOLDER)
    if chosen is not None:
        return Path(chosen).absolute() / OWN if chosen else None
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:  # nobody knows the user's home
        return None
    return home / OWN if home.is_absolute() else None  # the standard ignores a relative one


def _read(file: Path, value_type: type[Value]) -> dict[str, Value]:
    """Content of a cache file; empty without a readable one."""
    try:
        with open_regular(file) as opened:
            return msgspec.convert(msgspec.json.decode(opened.read()), GenericAlias(dict, (str, value_type)))
    except (OSError, SettingError, ValueError, RecursionError):  # a ValueError of msgspec too, and for bytes of no text
        return {}
