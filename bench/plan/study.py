"""The contract of a study: one question, answered run by run as plain data."""

from __future__ import annotations

from typing import Any, ClassVar, Protocol

from bench.plan.draw import Draw
from bench.plan.setup import Setup


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
