"""One disk heavier or lighter than assumed, its mass and both moments of inertia in one proportion: another material, blades, a filled bore.

Unlike `added_mass`, which has no extent, it brings the moments of inertia of the disk along: an impeller that is heavier tilts more slowly
too (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, chapter 5, for the matrices of a disk).
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
NOTICED = (0.01, 0.15)  # of either sign, are drawn


@dataclass(frozen=True)
class DiskMass(SeatedEffect):
    """A disk is heavier or lighter."""

    position: float | None = setting(None, "of the disk; null: the first", unit="m", at_least=0)

    is_scanned: ClassVar[bool] = False
    aliases: ClassVar[Mapping[str, str]] = {
        "added_mass": "a disk has moments of inertia too; modes that tilt it, or weigh the disk",
        "disk_inertia": "both change modes that tilt the disk; weigh it, or swing it on wires",
        "mass": "both lower natural frequencies; several critical speeds, whose modes move that disk differently",
    }
    what, default_place, needs = "disk", "the first disk", "a rotor with a disk"
    sizes = (Size("disk_mass_change", "%", LARGEST, drawn=NOTICED),)

    def is_offered(self, problem: RotorProblem) -> bool:
        return problem.is_as_drawn

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        return list(dict.fromkeys(disk.position for disk in problem.rotor.disks))

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        factor = 1 + float(theta[0])
        disks = tuple(heavier(disk, factor) if is_near(disk.position, self.place) else disk for disk in rotor.disks)
        return dataclasses.replace(rotor, disks=disks)


def heavier(disk: Disk, factor: float) -> Disk:
    """A disk with mass and moments of inertia times a factor."""
    mass, polar, diametral = (factor * value for value in (disk.mass, disk.polar_inertia, disk.diametral_inertia))
    return dataclasses.replace(disk, mass=mass, polar_inertia=polar, diametral_inertia=diametral)
