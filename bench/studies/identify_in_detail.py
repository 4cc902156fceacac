"""Study of an identification with details.

Data and fit over speed, tests of the fit, an unmodelled force.
"""

from __future__ import annotations

from dataclasses import dataclass

from bench.plan.plan import generator
from bench.plan.setup import Draw, Setup
from bench.studies.identify import Identify, streams_of
from ksmea.location.location import require_enough as require_enough_to_locate
from ksmea.plugins import registry
from ksmea.problem.case import Case
from ksmea.records.identification import IdentificationRecord
from ksmea.settings.settings import Settings, setting
from ksmea.studies.identification_details import detailed_identification, location_options
from ksmea.studies.locate import LOCAL_FORCE


@dataclass(frozen=True)
class IdentifyInDetail(Identify):
    """Identification with all that `details` and `unmodelled` add.

    `study=identify study.details=true` is run by it.
    """

    details: bool = setting(
        True, "keep data and fit over speed, a test of the fit, CRLBs and correlations at the identified values"
    )

    @property
    def parts(self) -> tuple[Settings, ...]:
        """The effect that a located law becomes, if an unmodelled force is located."""
        return (registry.create("effect", LOCAL_FORCE, {}),) if self.unmodelled else ()

    def validate(self, setup: Setup) -> None:
        super().validate(setup)
        if self.unmodelled:
            location_options(self.unmodelled, self.level)
            require_enough_to_locate(setup.problem, setup.source.kind)

    def identified(self, case: Case, setup: Setup, draw: Draw) -> IdentificationRecord:
        return detailed_identification(
            case,
            setup.method,
            streams_of(draw),
            generator(draw.seeds["diagnosis"]),
            self.options(setup, draw),
            beside=location_options(self.unmodelled, self.level),
            remarks=setup.source.remarks,
        )
