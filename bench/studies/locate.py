"""Study `locate`: site of an unknown cause that the model lacks, and its action there."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.plan import generator
from bench.plan.progress import progress_of
from bench.plan.setup import Draw, Setup
from bench.plan.study import Study
from ksmea.location.location import require_enough
from ksmea.numerics.parallel import Workers, cpu_seconds
from ksmea.plugins import registry
from ksmea.plugins.effect import AnyEffect
from ksmea.problem.case import Case
from ksmea.records.location import LocationRecord
from ksmea.records.record import Record
from ksmea.studies.locate import LOCAL_FORCE, LocationOptions, location


@dataclass(frozen=True)
class Locate(LocationOptions, Study):
    """Site of an unmodelled cause, and its action there.

    An unknown force, moment or reading, free at every speed.
    """

    record: ClassVar[type[Record]] = LocationRecord
    report: ClassVar[str] = "location"
    ignores: ClassVar[tuple[str, ...]] = ("samples", "surrogate", "optimizer", "method")

    @property
    def parts(self) -> list[AnyEffect]:
        return [registry.create("effect", LOCAL_FORCE, {})]  # what a law that holds becomes

    def validate(self, setup: Setup) -> None:
        setup.refuse_exact_data("study=locate")
        require_enough(setup.problem, setup.source.kind)

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        started = cpu_seconds()
        with progress_of(draw, "location") as progress:
            found = location(
                Case(setup.problem, setup.measure(draw)),
                generator(draw.seeds["diagnosis"]),
                options=self,
                workers=Workers(draw.workers, progress),
            )
        found = dataclasses.replace(found, hidden=setup.hidden(draw), seconds=cpu_seconds() - started)
        return {"status": "done", **found.to_data()}
