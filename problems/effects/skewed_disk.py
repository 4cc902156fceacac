"""Skewed disk: a disk fitted at a small angle τ to the shaft.

Its inertia bends the shaft as it turns.

The disk's own axis turns with the shaft, tilted by τ. What it takes to whirl it so is a moment that turns forward and
grows with Ω² (M. I. Friswell, J. E. T. Penny, S. D. Garvey & A. W. Lees, Dynamics of Rotating Machines, 2010,
chapter 6):

    M = (I_d − I_p) Ω² (τ_x + i τ_y) (1, −i)    about (x, y),

I_p and I_d the polar and the diametral inertia. τ is an angle about the axes x and y of the shaft at t = 0. A disk that is as stout
as a ball, I_p = I_d, shows nothing. Near one critical speed it does what an unbalance does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.problem.load import MOMENT
from ksmea.settings.settings import setting
from ksmea.units import MILLIRADIAN
from problems.rotor.extension.effect import SeatedEffect
from problems.rotor.extension.sizes import VectorSize
from problems.rotor.finite_elements.data import SAME_PLACE, Rotor
from problems.rotor.finite_elements.loads import forward_load
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.response.problem import RotorProblem

LARGEST = 5 * MILLIRADIAN  # the rim of a disk of 0.4 m then wobbles by ± 1 mm, which is seen
NOTICED = (0.02 * MILLIRADIAN, 2 * MILLIRADIAN)  # vectors as long as these are drawn


@dataclass(frozen=True)
class SkewedDisk(SeatedEffect):
    """A disk is not square to the shaft."""

    position: float | None = setting(
        None, "position of the disk; null: the first one whose polar and diametral inertia differ", unit="m", at_least=0
    )

    is_scanned: ClassVar[bool] = False
    says = "The disk {place} sits {skew:size} out of square"
    check_next = "Measure runout of the disk's face by dial gauge: a skew of this size confirms it; then mount it anew."
    aliases: ClassVar[Mapping[str, str]] = {
        "unbalance": "both grow with Ω² and turn with the shaft; a second critical speed, a trial weight, a dial gauge on the rim",
        "coupling_misalignment": "moments that turn with the shaft; a disk's grows with Ω²: measure at low speed too",
    }

    what, default_place, needs = "disk", "the first disk", "a disk whose polar and diametral inertia differ"
    sizes = (VectorSize("skew", "mrad", LARGEST, drawn=NOTICED),)

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        return [disk.position for disk in _uneven_disks(problem.rotor)]

    def placed_on(self, problem: RotorProblem) -> Self:
        placed = super().placed_on(problem)
        if not _inertia(problem.rotor, placed.place):
            raise SettingError(f"position: expected {self.needs}, got none there")
        return placed

    def loads(self, rotor: Rotor, speed: Array) -> ComplexArray:
        size = _inertia(rotor, self.place) * np.asarray(speed) ** 2
        return size[:, None, None] * forward_load(rotor, self.place, MOMENT, len(speed))


def _uneven_disks(rotor: Rotor) -> list[Disk]:
    """The disks, one at each place, whose inertias differ."""
    first = {disk.position: disk for disk in reversed(rotor.disks)}
    return [first[position] for position in sorted(first) if _inertia(rotor, position)]


def _inertia(rotor: Rotor, position: float) -> float:
    """I_d − I_p of what sits at a position, kg m²; 0 where nothing does."""
    return sum(
        disk.diametral_inertia - disk.polar_inertia
        for disk in rotor.disks
        if abs(disk.position - position) <= SAME_PLACE * rotor.length
    )
