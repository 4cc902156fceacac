"""Foundation resonance: all bearings stand on one block, a mass on a spring along one axis.

With a = s/(1 + iη − s Ω² m) its compliance and F_b the force on bearing b, the block moves by v = a Σ F_b and takes all bearings along
(`problems/rotor/finite_elements/bearing.py`); at a compliance of 0 it is rigid, whatever its mass. It has a resonance of its own at √(1/(s m)), in one
axis alone: foundations are stiffer upwards than sideways, and each axis is an effect by itself. A flexible pedestal is another thing:
each bearing has its own, with one mass for both axes, and one bearing moves on it without the other. A block does not feel modes in
which the bearings push against each other, and pedestals do. Probes measure against the ground; rocking is left out.

A. W. Lees & M. I. Friswell, The evaluation of rotor imbalance in flexibly mounted machines, J. Sound Vib. 208 (1997) 671–683;
Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010, chapters 5 and 6.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.measurement.channel import DIRECTIONS
from ksmea.plugins.effect import SizeRecord, StatementRecord
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import RotorEffect, rotor_mass, stiffness_scale
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.bearing import Support
from problems.rotor.response.problem import RotorProblem

SOFTEST = 2.0  # times the compliance of the stiffest bearing, as of a pedestal
HEAVIEST = 10.0  # of the rotor
NOTICED_COMPLIANCE = (0.02, 1.0)  # of the compliance of the stiffest bearing, are drawn
NOTICED_MASS = (0.5, 5.0)  # of the rotor, are drawn


@dataclass(frozen=True)
class FoundationResonance(RotorEffect):
    """The block that all bearings stand on gives way along one axis, and has a mass."""

    direction: str = setting("x", "the axis along which it moves", choices=DIRECTIONS)
    loss_factor: float = setting(
        0.05, "η of its spring: bolted frames have 0.01 to 0.05, concrete on soil 0.1", above=0, at_most=1
    )

    check_next = (
        "Tap the base frame or measure its vibration: a resonance there confirms it; then check anchor bolts and grout."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "flexible_pedestal": "a block moves all bearings alike; sensors on the casings of two bearings, or on the foundation",
        "speed_dependent_stiffness": "a block's mass softens it with speed too; a sensor on the foundation, another axis",
        "spring_mass": "both add a resonance; a sensor on the foundation, a tap test of the part at rest",
    }
    couples_bearings: ClassVar[bool] = True

    @property
    def sizes(self) -> Sequence[Size]:
        compliance, mass = (f"foundation_{what}_{self.direction}" for what in ("compliance", "mass"))
        return (
            Size(compliance, "µm/kN", (0.0, SOFTEST), drawn=NOTICED_COMPLIANCE, per=stiffness_scale),
            Size(mass, "kg", (0.0, HEAVIEST), drawn=NOTICED_MASS, of=rotor_mass),
        )

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        compliance, mass = (f"{{foundation_{what}_{self.direction}}}" for what in ("compliance", "mass"))
        sentence = f"The foundation yields {{place}} by {compliance}, and moves with a mass of {mass}"
        return dataclasses.replace(super().statement(sizes), sentence=sentence)

    def __str__(self) -> str:
        return f"along {self.direction}"

    def locations(self, problem: RotorProblem) -> Sequence[FoundationResonance]:
        return [dataclasses.replace(self, direction=direction) for direction in DIRECTIONS]

    def support(self, theta: Array) -> Support:
        along = np.array([[self.direction == axis] for axis in DIRECTIONS])
        return Support(along * theta[:, 0], theta[:, 1], self.loss_factor, is_common=True)
