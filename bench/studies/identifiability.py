"""The study `identifiability`: how well these data would determine the unknowns, and how well other data would."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.draw import Draw
from bench.plan.setup import Setup
from bench.plan.study import Study
from ksmea.records.identifiability import IdentifiabilityRecord
from ksmea.records.record import Record
from ksmea.studies.identifiability import IdentifiabilityOptions, identifiability_study


@dataclass(frozen=True)
class IdentifiabilityStudy(IdentifiabilityOptions, Study):
    """How well the unknowns can be known from such data, by the Cramér–Rao lower bound, and how other data would change
    that."""

    record: ClassVar[type[Record]] = IdentifiabilityRecord
    report: ClassVar[str] = "identifiability"
    ignores: ClassVar[tuple[str, ...]] = ("samples", "surrogate", "optimizer", "method")

    def validate(self, setup: Setup) -> None:
        setup.require_truth("study=identifiability")
        setup.require_noise("study=identifiability")

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        measurement = setup.source
        record = identifiability_study(
            setup.problem,
            setup.true_x,
            setup.require_noise("study=identifiability"),
            measurement.kind,
            noise_known=measurement.noise_known,
            options=self,
        )
        return {"status": "done", **record.to_data()}
