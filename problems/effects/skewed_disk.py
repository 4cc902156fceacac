"""Skewed disk: a disk that is fitted at a small angle τ to the shaft, so that its inertia bends the shaft as it turns.

The disk's own axis turns with the shaft at τ beside it. What it takes to whirl it so is a moment that turns forward and grows
with Ω² (M. I. Friswell, J. E. T. Penny, S. D. Garvey & A. W. Lees, Dynamics of Rotating Machines, 2010, chapter 6):

    M = (I_d − I_p) Ω² (τ_x + i τ_y) (1, −i)    about (x, y),

I_p and I_d the polar and the diametral inertia. τ is an angle about the axes x and y of the shaft at t = 0. A disk that is as stout
as a ball, I_p = I_d, shows nothing. Near one critical speed it does what an unbalance does.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.problem.load import MOMENT
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import setting
from ksmea.units import MILLIRADIAN
from problems.rotor.extension.effect import PlacedEffect, drawn_vector, forward_vector, require_on_shaft
from problems.rotor.finite_elements.data import SAME_PLACE, Disk, Rotor
from problems.rotor.finite_elements.loads import forward_load
from problems.rotor.response.problem import RotorProblem

LARGEST = 5 * MILLIRADIAN  # the rim of a disk of 0.4 m then wobbles by ± 1 mm, which is seen
NOTICED = (0.02 * MILLIRADIAN, 2 * MILLIRADIAN)  # vectors as long as these are drawn


@dataclass(frozen=True)
class SkewedDisk(PlacedEffect):
    """A disk is not square to the shaft."""

    position: float | None = setting(
        None, "where the disk sits; null: the first one whose polar and diametral inertia differ", unit="m", at_least=0
    )

    is_scanned: ClassVar[bool] = False
    aliases: ClassVar[Mapping[str, str]] = {
        "unbalance": "both grow with Ω² and turn with the shaft; a second critical speed, a trial weight, a dial gauge on the rim",
        "coupling_misalignment": "moments that turn with the shaft; that of a disk grows with Ω²: measure at low speed too",
    }
    has_loads: ClassVar[bool] = True

    def __str__(self) -> str:
        return "the first disk" if self.position is None else f"at {self.position:g} m"

    def locations(self, problem: RotorProblem) -> Sequence[SkewedDisk]:
        return [dataclasses.replace(self, position=disk.position) for disk in _uneven_disks(problem.rotor)]

    def placed_on(self, problem: RotorProblem) -> SkewedDisk:
        require_on_shaft(problem, self.position, "disk")
        disks = _uneven_disks(problem.rotor)
        if self.position is None and disks:
            return dataclasses.replace(self, position=disks[0].position)
        if self.position is None or not _inertia(problem.rotor, self.position):
            raise SettingError("skewed disk: expected a disk whose polar and diametral inertia differ, got none there")
        return self

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        return tuple(Parameter(name, "mrad", MILLIRADIAN, -LARGEST, LARGEST) for name in ("skew_x", "skew_y"))

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        return drawn_vector(rng, *NOTICED)

    def loads(self, rotor: Rotor, speed: Array) -> ComplexArray:
        if self.position is None:
            raise SettingError("position: expected the place of the disk, got none; add the effect to a problem")
        size = _inertia(rotor, self.position) * np.asarray(speed) ** 2
        return size[:, None, None] * forward_load(rotor, self.position, MOMENT, len(speed))

    def load_sizes(self, theta: Array) -> ComplexArray:
        return forward_vector(theta)[:, None]


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
