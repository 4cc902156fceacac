"""Unbalance on another disk than the one that the model has it on.

A mass m e at a position z of the shaft: f = Ω² (u_x + i u_y) (1, −i), as the unbalance of the model has it
(Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, chapter 6). Near one critical speed any unbalance
looks like any other; two modes tell them apart.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ksmea.arrays import Array, ComplexArray
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import (
    SeatedEffect,
    places_of,
    unbalance_scale,
)
from problems.rotor.extension.sizes import VectorSize
from problems.rotor.finite_elements.data import SAME_PLACE, Rotor, UnbalancePlane
from problems.rotor.finite_elements.loads import force_per_unbalance
from problems.rotor.response.problem import RotorProblem

NOTICED = (0.01, 0.5)  # of the largest that is possible: vectors as long as these are drawn


@dataclass(frozen=True)
class FurtherUnbalance(SeatedEffect):
    """A further disk is out of balance."""

    position: float | None = setting(
        None, "position of the unbalance; null: the first disk without unbalance in the model", unit="m", at_least=0
    )

    is_scanned: ClassVar[bool] = False
    words = "unbalance"
    says = "A further unbalance of {unbalance} {place}"
    check_next = (
        "Run with a trial weight in this plane: the predicted change confirms it; look for lost or loose parts."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_damping": "both change peak heights; a second resonance, a trial weight on each disk",
        "youngs_modulus": "both change the mix of modes; a trial weight on each disk, a second mode in the band",
        "mass": "both change the mix of modes; a trial weight on each disk, a second mode in the band",
        "unequal_bearings": "both change the mix of modes; sensors near both ends, a trial weight on each disk",
        "skewed_disk": "both grow with Ω² and turn with the shaft; a second critical speed, a trial weight, a dial gauge on the rim",
        "coupling_misalignment": "an unbalance grows with Ω²; measure at low speed too, or run uncoupled",
    }

    what, default_place, needs = "unbalance", "the first free disk", "a disk without unbalance in the model"
    sizes = (VectorSize("unbalance", "g mm", 1.0, drawn=NOTICED, of=unbalance_scale),)

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        return free_disks(problem.rotor)

    def loads(self, rotor: Rotor, speed: Array) -> ComplexArray:
        plane = UnbalancePlane(self.place)
        return force_per_unbalance(dataclasses.replace(rotor, unbalance=(plane,)), speed)

    def unbalance(self, theta: Array) -> Mapping[float, complex]:
        return {} if self.position is None else {self.position: complex(*theta)}


def free_disks(rotor: Rotor) -> list[float]:
    """Positions of the disks that carry no unbalance plane, m."""

    def is_free(position: float) -> bool:
        return all(abs(plane.position - position) > SAME_PLACE * rotor.length for plane in rotor.unbalance)

    return places_of((disk for disk in rotor.disks if is_free(disk.position)), rotor)
