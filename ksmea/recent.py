"""What was made last of something costly, so that it need not be made again."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import TypeVar

Key = TypeVar("Key", bound=Hashable)
Value = TypeVar("Value")


def recent(kept: OrderedDict[Key, Value], key: Key, make: Callable[[], Value], most: int) -> Value:
    """What is kept under a key, made where it is not; the `most` that were asked for last are kept.

    >>> kept = OrderedDict([("a", 1), ("b", 2)])
    >>> recent(kept, "a", lambda: 0, 2), recent(kept, "c", lambda: 3, 2), list(kept)
    (1, 3, ['a', 'c'])
    """
    if key not in kept:
        kept[key] = make()
        if len(kept) > most:
            kept.popitem(last=False)
    kept.move_to_end(key)
    return kept[key]
