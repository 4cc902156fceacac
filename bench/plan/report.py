"""Contract of a report: output printed and written from an experiment's records."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from bench.plan.page import Page
from bench.plan.plan import Plan
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.settings.settings import Settings
from ksmea.show.charts.chart import Chart

if TYPE_CHECKING:
    import pandas as pd  # needed when there is something to report

Drawing = bytes | Callable[[], bytes | Chart]  # the content of a file, or what makes it when it is written


def _no_figures() -> dict[str, Drawing]:
    return {}


@dataclass(frozen=True)
class Made:
    """Output of a report: `text` is printed, `files` are written by name.

    `runs` has a row per planned run with its `status` and `error`. `figures` makes further files after `files` are
    written; it is not called if they exist already and were made of the current `files`. Content that is a function is
    computed on its own: if it fails, only its file is missing. `page` returns the page of the experiment. Default:
    `text`, the tables of `files` and the figures. The charts of a page (`bench.plan.page.Drawn`) are also written as
    pictures: `figures` names only files that no page shows. `outdated` names files that an earlier call may have
    written and that would now be wrong.
    """

    text: str
    files: Mapping[str, bytes]
    runs: pd.DataFrame
    figures: Callable[[], Mapping[str, Drawing]] = _no_figures
    outdated: tuple[str, ...] = ()
    page: Callable[[], Page] | None = None


@dataclass(frozen=True)
class Report(Settings, ABC):
    """Base class of the plugins under `ksmea.reports`.

    `study` names the study whose records the report uses. It computes nothing that a record does not hold.
    """

    study: ClassVar[str]

    def check_plan(self, plan: Plan) -> None:
        """Check that a report can be made of a plan, before anything is run.

        Default: it always can.

        Args:
            plan: plan of an experiment.

        Raises:
            SettingError: no report can be made of it.
        """

    @abstractmethod
    def make(self, plan: Plan, output: Path) -> Made:
        """Report of a plan's records.

        Args:
            plan: plan of an experiment.
            output: folder of its records.

        Returns:
            Text, files and figures.
        """


def report_named(name: str) -> Report:
    """Report that `table` or a study's `report` names.

    Args:
        name: registered name.

    Raises:
        SettingError: the class is not a `Report`, or names no study.
    """
    report = registry.create("report", name, {})
    if not isinstance(report, Report):
        raise SettingError(
            f"table={name}: expected a subclass of bench.plan.report.Report, got {type(report).__name__}; make it one"
        )
    if not isinstance(getattr(report, "study", None), str):
        raise SettingError(
            f"table={name}: expected {type(report).__name__} to name the study whose records it is made of, got none; add"
            " study: ClassVar[str]"
        )
    return report
