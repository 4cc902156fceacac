"""Kinds of tables: what is made of an experiment's records, by the name that `table` and a study's `report` give.

A report is a function of the plan and the experiment's folder. It returns what is printed and the files by name; it
computes nothing that a record does not hold.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from bench.plan import Plan
from bench.reports.audit import audit_report
from bench.reports.calibration import calibration_report
from bench.reports.diagnosis import diagnosis_report
from bench.reports.identifiability import identifiability_report
from bench.reports.identification import identification_report
from bench.reports.made import Made
from bench.reports.planning import plan_report
from bench.reports.settings import settings_report
from bench.reports.summary import summary_report


@dataclass(frozen=True)
class Report:
    """How a table is made, and of which study's records."""

    make: Callable[[Plan, Path], Made]
    study: str


REPORTS = {
    "summary": Report(summary_report, "identify"),
    "settings": Report(settings_report, "identify"),
    "calibration": Report(calibration_report, "identify"),
    "identification": Report(identification_report, "identify"),
    "identifiability": Report(identifiability_report, "identifiability"),
    "audit": Report(audit_report, "identifiability"),
    "plan": Report(plan_report, "plan"),
    "diagnosis": Report(diagnosis_report, "diagnose"),
}
