"""Diagnoses by this project, with what their parts take."""

from __future__ import annotations

import scipy.stats  # which a first diagnosis would import  # noqa: F401

import ksmea
from benchmarks.diagnosis_cost import DATA, SEEDS, measured
from benchmarks.harness.task import Task

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
    return Task(lambda turn: dict(measured(DATA[data], SEEDS[turn % len(SEEDS)])[1]), parts=lambda seconds: seconds)


def shared(data: str, workers: int) -> Task:
    """The same by processes that share it."""
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.2, 0.5])

    def diagnosis(turn: int) -> None:
        seed = SEEDS[turn % len(SEEDS)]
        made = ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", hidden=DATA[data], rng=seed)
        ksmea.diagnose(rotor, made, workers=workers)

    return Task(diagnosis)


def of_effects(n_effect: int) -> Task:
    """With so many effects on data that hide none of them, without location."""
    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.2, 0.5])
    data = ksmea.synthetic_measurement(rotor, relative=0.05, kind="complex", rng=1)
    return Task(lambda turn: ksmea.diagnose(rotor, data, effects=EFFECTS[:n_effect], locate=False))
