"""A disk that sits elsewhere along the shaft than assumed: its mass and moments of inertia act beside the node of the model.

The centre of mass of an impeller lies millimetres off the middle of its hub, and drawings give the hub. The disk moves and turns as the
shaft does there (Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, section 5.4, for the shapes of the element).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ksmea.arrays import Array
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import SeatedEffect, is_near, shaft_length
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.02  # of the shaft's length, to either side
NOTICED = (0.002, 0.015)  # of the shaft's length, to either side, are drawn


@dataclass(frozen=True)
class DiskPosition(SeatedEffect):
    """A disk sits elsewhere along the shaft."""

    position: float | None = setting(None, "where the model has it; null: the first disk", unit="m", at_least=0)

    is_scanned: ClassVar[bool] = False
    aliases: ClassVar[Mapping[str, str]] = {
        "added_mass": "both change what the disk does to each mode; measure its distance from a bearing, or weigh it",
    }
    what, default_place, needs = "disk", "the first disk", "a rotor with a disk"
    sizes = (Size("disk_position_change", "mm", LARGEST, drawn=NOTICED, of=shaft_length),)

    def is_offered(self, problem: RotorProblem) -> bool:
        return problem.is_as_drawn

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        return list(dict.fromkeys(disk.position for disk in problem.rotor.disks))

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        disks = tuple(
            dataclasses.replace(disk, offset=disk.offset + float(theta[0]))
            if is_near(disk.position, self.place)
            else disk
            for disk in rotor.disks
        )
        return dataclasses.replace(rotor, disks=disks)
