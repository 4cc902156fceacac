"""Diagnoses and locations by this project, with the CPU seconds of a diagnosis' parts.

Three-disk rotor, probes in x and y at 0.1, 0.2 and 0.5 m, 53 speeds, complex data with 5 % noise. A part has the time of the
others taken off that it calls; `rest` is what belongs to none.
"""

from __future__ import annotations

import importlib
import time
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any
from unittest.mock import patch

import scipy.stats  # which a first diagnosis would import  # noqa: F401

import ksmea
from benchmarks.harness.task import Task

DATA = {
    "adequate": [],
    "runout": ["runout"],
    "speed_dependent_stiffness": ["speed_dependent_stiffness"],
    "flexible_pedestal": ["flexible_pedestal"],
    "mass": ["mass"],
    "far off": ["internal_damping", "residual_bow", "flexible_pedestal"],
}
SEEDS = (1, 2, 3)
EFFECTS = (
    *("mass", "runout", "residual_bow", "added_mass", "axial_force", "unbalance", "probe_rotation", "youngs_modulus"),
)
FITTING, DIAGNOSIS = "ksmea.fits.fitting", "ksmea.diagnosis.diagnosis"
DIAGNOSE, LOCATE = "ksmea.studies.diagnose", "ksmea.studies.locate"
PARTS = {  # by the modules that call them, and names
    "screening": ((FITTING, "screened_both_ways"), (FITTING, "scanned"), (FITTING, "eliminated")),
    "baseline": ((DIAGNOSE, "fit_baseline"),),
    "fits": ((DIAGNOSIS, "fitted"), (DIAGNOSIS, "refined")),
    "second effects": ((DIAGNOSIS, "pairs_beside"), (DIAGNOSIS, "alternatives")),
    "lack of fit": ((DIAGNOSIS, "fit_quality"),),
    "intervals": ((DIAGNOSIS, "settled"), (DIAGNOSIS, "settled_stable")),
    "observability": ((DIAGNOSIS, "collinearities"), ("ksmea.diagnosis.observability", "smallest_detectable")),
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
    """Result of the work, and core-seconds of each part of its diagnoses.

    The time of others that a part calls is not included.
    """
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


def diagnosis(data: str) -> Task:
    """With all effects, each turn data of another seed."""
    rotor, made = _rotor_and_data(DATA[data])

    def parts(turn: int) -> Counter[str]:
        data = made(turn)
        return by_part(lambda: ksmea.diagnose(rotor, data))[1]

    return Task(parts, parts=dict)


def shared(data: str, workers: int) -> Task:
    """Diagnosis by processes that share it."""
    rotor, made = _rotor_and_data(DATA[data])
    return Task(lambda turn: ksmea.diagnose(rotor, made(turn), workers=workers))


def of_effects(n_effect: int) -> Task:
    """With so many effects on data that hide none of them, without location."""
    rotor, made = _rotor_and_data([])
    data = made(0)
    return Task(lambda turn: ksmea.diagnose(rotor, data, effects=EFFECTS[:n_effect], locate=False))


def location(mesh: int, n_speed: int) -> Task:
    """Location of an unbalance on another disk, which its law reveals.

    Candidates are forces and moments at each node and a reading at each plane.
    """
    rotor = ksmea.load_problem("three_disk", mesh=mesh, sensors=[0.1, 0.5, 1.0], n_speed=n_speed)
    noise = {"relative": 0.05, "floor": 0.1, "noise_known": False, "kind": "complex"}
    data = ksmea.synthetic_measurement(rotor, hidden=["unbalance"], mesh=26, route="dense", rng=1, **noise)
    return Task(lambda turn: ksmea.locate(rotor, data))


def _rotor_and_data(hidden: list[str]) -> tuple[Any, Callable[[int], Any]]:
    """The rotor, and data of it for each turn."""
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.2, 0.5])

    def made(turn: int) -> Any:
        seed = SEEDS[turn % len(SEEDS)]
        return ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", hidden=hidden, rng=seed)

    return rotor, made
