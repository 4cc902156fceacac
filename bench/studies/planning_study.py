"""Study `plan`: data to add, near published values, measurement.truth or most likely values.

The last are of a measurement.
"""
# Shorter than 40 lines: one plugin a file.

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.setup import Draw, Setup
from bench.plan.study import Study
from bench.studies.design_point import design_point, require_design_point
from ksmea.records.planning import PlanningRecord
from ksmea.records.record import Record
from ksmea.studies.planning import PlanningOptions, planning_study


@dataclass(frozen=True)
class Planning(PlanningOptions, Study):
    """Speeds, probes or a trial unbalance to add, so that unknowns become known best.

    One unknown (c-optimal) or all of them (D-optimal) are the target. Next to it is the gain by as much data without a
    plan.
    """

    record: ClassVar[type[Record]] = PlanningRecord
    report: ClassVar[str] = "plan"
    takes_middles: ClassVar[bool] = True
    ignores: ClassVar[tuple[str, ...]] = ("samples", "surrogate", "optimizer", "method")

    def validate(self, setup: Setup) -> None:
        self.check_problem(setup.problem)
        require_design_point(setup, "study=plan")

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        record = planning_study(design_point(setup, draw, "study=plan"), self)
        return {"status": "done", **record.to_data()}
