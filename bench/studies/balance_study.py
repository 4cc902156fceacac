"""Study `balance`: influence coefficients, unknown weights and corrections of a campaign.

It uses no model of the rotor.
"""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.plan import generator
from bench.plan.progress import progress_of
from bench.plan.setup import Draw, Setup
from bench.plan.study import Study
from ksmea.balancing.readings import readings
from ksmea.records.balancing import BalanceRecord
from ksmea.records.record import Record
from ksmea.studies.balance import BalanceOptions, balance


@dataclass(frozen=True)
class Balance(BalanceOptions, Study):
    """Influence coefficients, unknown weights and correction weights of runs with known weights.

    No rotor is requested.
    """

    record: ClassVar[type[Record]] = BalanceRecord
    report: ClassVar[str] = "balance"
    ignores: ClassVar[tuple[str, ...]] = ("problem", "samples", "surrogate", "optimizer", "method")

    def validate(self, setup: Setup) -> None:
        readings(setup.source.read(), self.speed_tolerance)

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        started = time.perf_counter()
        with progress_of(draw, "balance") as progress:
            found = balance(
                setup.source.read(),
                generator(draw.seeds["diagnosis"]),
                options=self,
                progress=progress,
            )
        return {"status": "done", **dataclasses.replace(found, seconds=time.perf_counter() - started).to_data()}
