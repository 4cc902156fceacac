"""The study `plan`: which data to add, near the published values or measurement.truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.draw import Draw
from bench.plan.setup import Setup
from bench.plan.study import Study
from ksmea.errors import SettingError
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
        measurement = setup.plugins["measurement"]
        if measurement.noise is None or measurement.noise.is_absent:
            raise SettingError(
                "study=plan: expected a measurement with noise, without which every unknown is known exactly, got none;"
                " give measurement.relative or measurement.floor"
            )

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        measurement = setup.plugins["measurement"]
        record = planning_study(
            setup.problem,
            setup.true_x,
            measurement.noise,
            measurement.kind,
            noise_known=measurement.noise_known,
            options=self,
        )
        return {"status": "done", **record.to_data()}
