"""The contract of a study: one question, answered run by run as plain data."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.setup import Draw, Setup
from ksmea.records.record import Record
from ksmea.settings.settings import Settings


@dataclass(frozen=True)
class Study(Settings):
    """Settings of a study.

    `record` is the class of its results; default: a record without known fields. `report` names the kind of table that is made of
    its records (`bench.reports`). `ignores` lists the parts of a run that make no difference to it; default: all parts do.
    `takes_middles` states whether unknown true values may be the midpoints of their limits; default: they may not.
    """

    record: ClassVar[type[Record]] = Record
    report: ClassVar[str]
    ignores: ClassVar[tuple[str, ...]] = ()
    takes_middles: ClassVar[bool] = False

    def validate(self, setup: Setup) -> None:
        """Check that the parts work together, before anything is run.

        Default: they always do.

        Args:
            setup: problem, measurement and method of a cell.

        Raises:
            SettingError: the parts cannot work together.
        """

    @abstractmethod
    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        """Record of one run.

        Args:
            setup: problem, measurement and method of its cell.
            draw: seeds of its repetition.

        Returns:
            JSON data with a `status` of 'done' or 'budget'.
        """
