"""Kinds of tables: what is made of an experiment's records, by the name that `table` and a study's `report` give.

A report is a function of the plan and the experiment's folder. It returns what is printed and the files by name; it
computes nothing that a record does not hold.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from bench.plan import Plan
from bench.reports.made import Made
from bench.reports.settings import settings_report
from bench.reports.summary import summary_report

REPORTS: dict[str, Callable[[Plan, Path], Made]] = {
    "summary": summary_report,
    "settings": settings_report,
}
