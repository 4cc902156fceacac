"""Moments of inertia of one disk other than assumed, polar and diametral ones in one proportion; its mass is as assumed.

A drawing gives the mass of an impeller and leaves its moments of inertia to a formula for a ring. They tilt modes: an overhung disk splits
forward and backward whirl by its polar moment (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, chapter 3).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ksmea.arrays import Array
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import SeatedEffect, is_near
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.3
NOTICED = (0.03, 0.25)  # of either sign, are drawn


@dataclass(frozen=True)
class DiskInertia(SeatedEffect):
    """A disk has other moments of inertia."""

    position: float | None = setting(None, "of the disk; null: the first", unit="m", at_least=0)

    is_scanned: ClassVar[bool] = False
    aliases: ClassVar[Mapping[str, str]] = {
        "disk_mass": "both change modes that tilt the disk; weigh it, or swing it on wires",
        "hub_stiffening": "both raise modes that tilt the disk; tap the rotor hanging free, or swing the disk on wires",
    }
    what, default_place, needs = "disk", "the first disk", "a rotor with a disk that has moments of inertia"
    sizes = (Size("disk_inertia_change", "%", LARGEST, drawn=NOTICED),)

    def is_offered(self, problem: RotorProblem) -> bool:
        return problem.is_as_drawn

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        have = (disk.position for disk in problem.rotor.disks if disk.polar_inertia or disk.diametral_inertia)
        return list(dict.fromkeys(have))

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        factor = 1 + float(theta[0])

        def turned(disk: Disk) -> Disk:
            polar, diametral = factor * disk.polar_inertia, factor * disk.diametral_inertia
            return dataclasses.replace(disk, polar_inertia=polar, diametral_inertia=diametral)

        disks = tuple(turned(disk) if is_near(disk.position, self.place) else disk for disk in rotor.disks)
        return dataclasses.replace(rotor, disks=disks)
