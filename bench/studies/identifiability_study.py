"""The study `identifiability`.

How well these data would determine the unknowns, and how well other data would.
"""
# Shorter than 40 lines: one plugin a file.

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.setup import Draw, Setup
from bench.plan.study import Study
from bench.studies.design_point import design_point, require_design_point
from ksmea.records.identifiability import IdentifiabilityRecord
from ksmea.records.record import Record
from ksmea.studies.identifiability import IdentifiabilityOptions, identifiability_study


@dataclass(frozen=True)
class IdentifiabilityStudy(IdentifiabilityOptions, Study):
    """Precision of the unknowns from such data, by the Cramér–Rao lower bound, and from other data."""

    record: ClassVar[type[Record]] = IdentifiabilityRecord
    report: ClassVar[str] = "identifiability"
    takes_middles: ClassVar[bool] = True
    ignores: ClassVar[tuple[str, ...]] = ("samples", "surrogate", "optimizer", "method")

    def validate(self, setup: Setup) -> None:
        require_design_point(setup, "study=identifiability")

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        record = identifiability_study(design_point(setup, draw, "study=identifiability"), self)
        return {"status": "done", **record.to_data()}
