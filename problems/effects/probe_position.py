"""Probes of one plane at another position along the shaft than assumed.

All of them are off by one distance.

The distance of a probe from the end of a shaft that nobody sees is read from a drawing. Near a node of a mode some millimetres change
its reading as much as a wrong gain does, and with the other sign beyond it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import setting
from ksmea.units import MILLIMETRE
from problems.rotor.extension.effect import drawn_either_side, planes, where
from problems.rotor.inputs.number_effect import MovedProbesEffect
from problems.rotor.inputs.probe_places import ProbePlace
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.1  # of the shaft's length, to either side
NOTICED = (0.005, 0.06)  # of the shaft's length, to either side, are drawn


@dataclass(frozen=True)
class ProbePosition(MovedProbesEffect):
    """The probes of one plane sit elsewhere along the shaft."""

    position: float | None = setting(None, "the measuring plane; null: all of them alike", unit="m", at_least=0)

    says = "The measuring plane of {place:probes} is {probe_position_change:further from|nearer to} the shaft's start than stated"
    check_next = "Measure the axial position of these probes: an offset of this size confirms it."
    aliases: ClassVar[Mapping[str, str]] = {
        "channel_gain": "both scale what the plane reads; measure the position of the probes, or calibrate them",
    }
    what = "probes"
    for_drawings_only: ClassVar[bool] = True

    def __str__(self) -> str:
        return where(self.position)

    def locations(self, problem: RotorProblem) -> Sequence[ProbePosition]:
        """Each plane, if another one exists to compare it with."""
        found = planes(problem)
        return self.at_each(found) if len(found) > 1 else []

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        """The distance towards the right end, so that the probes stay on the shaft."""
        length = problem.rotor.length
        there = [self.position] if self.position is not None else planes(problem)
        lower, upper = -min(LARGEST * length, *there), min(LARGEST * length, *(length - each for each in there))
        lower, upper = min(lower, -LEAST), max(upper, LEAST)  # at an end of the shaft a probe cannot be beyond it
        return (Parameter("probe_position_change", "mm", MILLIMETRE, lower, upper),)

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        size = drawn_either_side(rng, *NOTICED) * problem.rotor.length
        [parameter] = self.parameters(problem)
        return np.array([size if parameter.lower <= size <= parameter.upper else -size])

    @property
    def of_probes_at(self) -> ProbePlace:
        return ProbePlace("position", self.position)


LEAST = 1e-3 * MILLIMETRE
