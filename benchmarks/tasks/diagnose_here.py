"""Diagnoses by this project, with what their parts take."""

from __future__ import annotations

import importlib
from contextlib import ExitStack
from typing import Any
from unittest.mock import patch

import ksmea
from benchmarks import diagnosis_cost
from benchmarks.diagnosis_cost import DATA, DIAGNOSIS, SEEDS, Clock
from benchmarks.harness.task import Task

PARTS = {  # by the modules that call them, and names
    **diagnosis_cost.PARTS,
    "second effects": ((DIAGNOSIS, "pairs_beside"), (DIAGNOSIS, "alternatives")),
    "observability": ((DIAGNOSIS, "smallest_detectable"), (DIAGNOSIS, "collinearities")),
}
EFFECTS = (
    "mass",
    "runout",
    "residual_bow",
    "added_mass",
    "axial_force",
    "unbalance",
    "probe_rotation",
    "youngs_modulus",
)


def diagnosis(data: str) -> Task:
    """With all effects, each turn data of another seed."""
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.2, 0.5])

    def run(turn: int) -> dict[str, float]:
        seed = SEEDS[turn % len(SEEDS)]
        measurement = ksmea.synthetic_measurement(
            rotor, relative=0.05, kind="complex", hidden=DATA[data], rng=seed
        ).measurement
        return by_part(lambda: ksmea.diagnose(rotor, measurement))

    return Task(run, parts=lambda seconds: seconds)


def by_part(diagnose: Any) -> dict[str, float]:
    """CPU seconds of each part of a diagnosis, without those of the others that it calls."""
    clock = Clock()
    with ExitStack() as stack:
        for part, places in PARTS.items():
            for module, name in places:
                called = getattr(importlib.import_module(module), name)
                stack.enter_context(patch(f"{module}.{name}", clock.timed(part, called)))
        clock.switch()
        clock.seconds.clear()
        diagnose()
        clock.switch()
    return dict(clock.seconds)


def of_effects(n_effect: int) -> Task:
    """With so many effects on data that hide none of them, without location."""
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.2, 0.5])
    data = ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", rng=1)
    return Task(lambda turn: ksmea.diagnose(rotor, data, effects=EFFECTS[:n_effect], locate=False))
