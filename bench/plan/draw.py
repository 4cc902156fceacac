"""What one run has of its own, besides the settings of its cell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Draw:
    """What one run has of its own: seeds by component, a journal of model evaluations where one is kept, whether the
    response curves that figures are made of are wanted, whether it is the only run, which shows its own progress, and how many
    processes may share it."""

    seeds: Mapping[str, list[int]]
    journal: Path | None = None
    with_curves: bool = False
    with_progress: bool = False
    workers: int = 1
