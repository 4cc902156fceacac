"""What a report gives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import pandas as pd


def _no_figures() -> dict[str, bytes]:
    return {}


@dataclass(frozen=True)
class Made:
    """`text` is printed, `files` are written by name, `runs` has a row per planned run with its `status` and `error`.

    `figures` makes further files; it is not asked where they are there already and were made of the same `files`.
    `outdated` names files that an earlier call may have written and that would now say what is not so.
    """

    text: str
    files: Mapping[str, bytes]
    runs: pd.DataFrame
    figures: Callable[[], Mapping[str, bytes]] = _no_figures
    outdated: tuple[str, ...] = ()
