"""The contract of a study: one question, answered run by run as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Protocol

from bench.setup import Setup


@dataclass(frozen=True)
class Draw:
    """What one run has of its own: seeds by component, a journal of model evaluations where one is kept, whether the
    response curves that figures are made of are wanted, and whether it is the only run, which shows its own progress."""

    seeds: Mapping[str, list[int]]
    journal: Path | None = None
    with_curves: bool = False
    with_progress: bool = False


class Study(Protocol):
    """Settings of a study. `report` names the kind of table that is made of its records (`bench.reports`),
    `ignores` the parts of a run that make no difference to it."""

    report: ClassVar[str]
    ignores: ClassVar[tuple[str, ...]]

    def validate(self, setup: Setup) -> None:
        """Raise `SettingError` where the parts cannot work together, before anything is run."""
        ...

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        """The record of one run: JSON data with a `status` of 'done' or 'budget'."""
        ...
