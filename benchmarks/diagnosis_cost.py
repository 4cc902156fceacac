"""What the parts of a diagnosis cost: core-seconds on data that a model explains, that lack one effect, and that are far off.

    OPENBLAS_NUM_THREADS=1 python -m benchmarks.diagnosis_cost > diagnosis_cost.csv
    OPENBLAS_NUM_THREADS=1 python -m benchmarks.diagnosis_cost mass "far off"    # some of the data

Three-disk rotor, probes in x and y at 0.1, 0.2 and 0.5 m, 53 speeds, complex data with 5 % noise. A part has the time of the
others taken off that it calls; `rest` is what belongs to none.
"""

from __future__ import annotations

import csv
import importlib
import sys
import time
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any
from unittest.mock import patch

import ksmea

DATA = {
    "adequate": [],
    "runout": ["runout"],
    "speed_dependent_stiffness": ["speed_dependent_stiffness"],
    "flexible_pedestal": ["flexible_pedestal"],
    "mass": ["mass"],
    "far off": ["internal_damping", "residual_bow", "flexible_pedestal"],
}
SEEDS = (1, 2, 3)
FITTING, DIAGNOSIS, LOCATE = "ksmea.fits.fitting", "ksmea.diagnosis.diagnosis", "ksmea.studies.locate"
PARTS = {  # by the modules that call them, and names
    "screening": ((FITTING, "screened_both_ways"), (FITTING, "scanned"), (FITTING, "screened_at")),
    "baseline": ((DIAGNOSIS, "fit_baseline"),),
    "fits": ((DIAGNOSIS, "fitted"), (DIAGNOSIS, "refined")),
    "second effects": ((DIAGNOSIS, "pairs_beside"), (DIAGNOSIS, "alternatives")),
    "lack of fit": ((DIAGNOSIS, "fit_quality"),),
    "intervals": ((DIAGNOSIS, "settled"), (DIAGNOSIS, "settled_stable")),
    "observability": ((DIAGNOSIS, "smallest_detectable"), (DIAGNOSIS, "collinearities")),
    "split": ((DIAGNOSIS, "best_split"),),
    "gain": ((DIAGNOSIS, "predictive_gain"),),
    "location": ((LOCATE, "locate"),),
    "laws": ((LOCATE, "fitted_laws"),),
}


class Clock:
    """Core-seconds by part, each without those that it calls."""

    def __init__(self) -> None:
        self.seconds: Counter[str] = Counter()
        self._running = ["rest"]
        self._since = time.process_time()

    def switch(self) -> None:
        now = time.process_time()
        self.seconds[self._running[-1]] += now - self._since
        self._since = now

    def timed(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def run(*args: Any, **keywords: Any) -> Any:
            self.switch()
            self._running.append(part)
            try:
                return function(*args, **keywords)
            finally:
                self.switch()
                self._running.pop()

        return run


def by_part(work: Callable[[], Any]) -> tuple[Any, Counter[str]]:
    """What the work returns, and core-seconds of each part of the diagnoses in it, without those of others that it calls."""
    clock = Clock()
    with ExitStack() as stack:
        for part, places in PARTS.items():
            for module, name in places:
                called = getattr(importlib.import_module(module), name)
                stack.enter_context(patch(f"{module}.{name}", clock.timed(part, called)))
        clock.switch()
        clock.seconds.clear()
        found = work()
        clock.switch()
    return found, clock.seconds


def measured(hidden: list[str], seed: int) -> tuple[str, Counter[str]]:
    """The verdict on one set of data, and what its parts cost."""
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.2, 0.5])
    data = ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", hidden=hidden, rng=seed)
    found, seconds = by_part(lambda: ksmea.diagnose(rotor, data))
    return f"{found.record.verdict} {' '.join(found.record.named)}".strip(), seconds


def main() -> None:
    table = csv.writer(sys.stdout)
    parts = [*PARTS, "rest"]
    table.writerow(["data", "seed", "verdict", *parts, "all"])
    for data in sys.argv[1:] or DATA:
        for seed in SEEDS:
            verdict, seconds = measured(DATA[data], seed)
            row = [f"{seconds[part]:.2f}" for part in parts]
            table.writerow([data, seed, verdict, *row, f"{sum(seconds.values()):.2f}"])
            sys.stdout.flush()


if __name__ == "__main__":
    main()
