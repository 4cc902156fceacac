"""A file that is read with one answer after the other: what the answers do not change is read once."""
# Shorter than 40 lines: readers of all formats share it.

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, TypeVar

from measurements.run_up_rows import read_bytes

Made = TypeVar("Made")


class Opened:
    """The content of a file, and where `keeps` is true the latest of each thing that was made of it."""

    def __init__(self, path: str, *, keeps: bool = False) -> None:
        self.path = path
        self._keeps = keeps
        self._content: bytes | None = None
        self._made: dict[str, tuple[Hashable, Any]] = {}

    def content(self, most: int) -> bytes:
        """All bytes; `SettingError` if the file is missing, unreadable or has more than `most`."""
        if self._content is None or len(self._content) > most:
            self._content = read_bytes(self.path, most)
        return self._content

    def once(self, thing: str, key: Hashable, make: Callable[[], Made]) -> Made:
        """Result of `make` for the content; with the key of the last call, its result."""
        kept = self._made.get(thing)
        if kept is not None and kept[0] == key:
            made: Made = kept[1]
            return made
        made = make()
        if self._keeps:
            self._made[thing] = (key, made)
        return made
