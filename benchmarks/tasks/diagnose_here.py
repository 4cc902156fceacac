"""Diagnoses by this project, with what their parts take (`benchmarks.diagnosis_cost`)."""

from __future__ import annotations

from typing import Any

import ksmea
from benchmarks.diagnosis_cost import DATA, SEEDS, measured
from benchmarks.harness.task import Task


def diagnosis(data: str) -> Task:
    """With all effects, each turn data of another seed."""
    hidden = DATA[data]

    def run(turn: int) -> dict[str, float]:
        return dict(measured(hidden, SEEDS[turn % len(SEEDS)])[1])

    return Task(run, parts=lambda seconds: seconds)


def of_effects(n_effect: int) -> Task:
    """With so many effects on data that hide none of them, without location."""
    names = [
        "mass",
        "youngs_modulus",
        "runout",
        "residual_bow",
        "added_mass",
        "axial_force",
        "unbalance",
        "probe_rotation",
    ]
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.2, 0.5])
    data = ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", rng=1)

    def run(turn: int) -> Any:
        return ksmea.diagnose(rotor, data, effects=names[:n_effect], locate=False)

    return Task(run)
