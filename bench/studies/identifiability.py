"""The study `identifiability`: what these data would tell about the unknowns, and what other data would."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.draw import Draw
from bench.plan.setup import Setup
from bench.plan.study import Study
from ksmea.errors import SettingError
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
        noise = setup.plugins["measurement"].noise
        if noise is None or noise.is_absent:
            raise SettingError(
                "study=identifiability: expected noise, without which everything is known exactly; say"
                " measurement.relative=0.1 or measurement.floor=0.5 (µm)"
            )

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        measurement = setup.plugins["measurement"]
        record = identifiability_study(
            setup.problem,
            setup.true_x,
            measurement.noise,
            measurement.kind,
            noise_known=measurement.noise_known,
            options=self,
        )
        return {"status": "done", **record.to_data()}
