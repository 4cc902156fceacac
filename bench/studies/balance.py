"""The study `balance`: influence coefficients, unknown weights and corrections of a campaign, without a model of the rotor."""

from __future__ import annotations

import dataclasses
import threading
import time
from dataclasses import dataclass
from typing import Any, ClassVar

from tqdm import tqdm

from bench.plan.draw import Draw
from bench.plan.plan import generator
from bench.plan.setup import Setup
from bench.plan.study import Study
from ksmea.balancing.readings import readings
from ksmea.records.balance import BalanceRecord
from ksmea.records.record import Record
from ksmea.studies.balance import BalanceOptions, balance


@dataclass(frozen=True)
class Balance(BalanceOptions, Study):
    """Influence coefficients, unknown weights and correction weights of runs with known weights; no rotor is asked for."""

    record: ClassVar[type[Record]] = BalanceRecord
    report: ClassVar[str] = "balance"
    ignores: ClassVar[tuple[str, ...]] = ("problem", "samples", "surrogate", "optimizer", "method")

    def validate(self, setup: Setup) -> None:
        readings(setup.source.read(), self.speed_tolerance)

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        started = time.perf_counter()
        tqdm.set_lock(threading.RLock())  # a lock between processes would outlive this worker
        with tqdm(desc="balance", disable=None if draw.with_progress else True, unit=" steps") as bar:
            found = balance(
                setup.source.read(),
                generator(draw.seeds["diagnosis"]),
                options=self,
                progress=lambda: bar.update() and None,
            )
        return {"status": "done", **dataclasses.replace(found, seconds=time.perf_counter() - started).to_data()}
