"""The study `plan`: which data to add, near the published values or measurement.truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.draw import Draw
from bench.plan.setup import Setup
from bench.plan.study import Study
from ksmea.records.plan import PlanRecord
from ksmea.records.record import Record
from ksmea.studies.plan import PlanOptions, planning_study


@dataclass(frozen=True)
class Planning(PlanOptions, Study):
    """Speeds, probes or a trial unbalance to add, chosen so that one unknown (c-optimal) or all of them (D-optimal) become
    known best; beside it what the same amount of data gives without a plan."""

    record: ClassVar[type[Record]] = PlanRecord
    report: ClassVar[str] = "plan"
    ignores: ClassVar[tuple[str, ...]] = ("samples", "surrogate", "optimizer", "method")

    def validate(self, setup: Setup) -> None:
        self.check_problem(setup.problem)
        setup.require_truth("study=plan")
        setup.require_noise("study=plan")

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        measurement = setup.source
        record = planning_study(
            setup.problem,
            setup.true_x,
            setup.require_noise("study=plan"),
            measurement.kind,
            noise_known=measurement.noise_known,
            options=self,
        )
        return {"status": "done", **record.to_data()}
