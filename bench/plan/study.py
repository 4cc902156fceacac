"""The contract of a study: one question, answered run by run as plain data."""
# Shorter than 40 lines: one contract a file.

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.setup import Draw, Setup
from ksmea.records.record import Record
from ksmea.settings.settings import Settings


@dataclass(frozen=True)
class Study(Settings):
    """Settings of a study. `record` is what it finds; left out: nothing is known of it. `report` names the kind of table that
    is made of its records (`bench.reports`), `ignores` the parts of a run that make no difference to it; left out: all parts do. `takes_middles` says whether true values that
    nobody knows may be the middles of their limits; left out: they may not."""

    record: ClassVar[type[Record]] = Record
    report: ClassVar[str]
    ignores: ClassVar[tuple[str, ...]] = ()
    takes_middles: ClassVar[bool] = False

    def validate(self, setup: Setup) -> None:
        """Raise `SettingError` if the parts cannot work together, before anything is run. Default: they always can."""

    @abstractmethod
    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        """The record of one run: JSON data with a `status` of 'done' or 'budget'."""
