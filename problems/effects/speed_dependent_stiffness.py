"""Stiffness of the bearings that changes with speed: k (1 + a Ω/Ω₁), both axes and all bearings alike.

Oil films stiffen as their Sommerfeld number rises, ball bearings soften under centrifugal load; over a limited band a
straight line stands for either (J. W. Lund, Review of the concept of dynamic coefficients for fluid film journal
bearings, J. Tribology 109 (1987) 37–41). Ω₁ is the highest speed of the problem that the effect is added to, and stays
so when the problem is seen at others. Direct stiffnesses change, cross-coupled ones do not.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import ALL_BEARINGS, RotorEffect, column
from problems.rotor.extension.sizes import Size
from problems.rotor.response.problem import RotorProblem

LOWEST, HIGHEST = -0.6, 1.0  # of what it is at rest: it stays a stiffness, and at most doubles
NOTICED = (0.02, 0.4)  # of either sign, are drawn


@dataclass(frozen=True)
class SlopeOverSpeed(RotorEffect):
    """Base of effects by which direct coefficients of the bearings change in proportion to speed."""

    extent = ALL_BEARINGS
    full_speed: float | None

    def locations(self, problem: RotorProblem) -> Sequence[Self]:
        return [self.placed_on(problem)]

    def placed_on(self, problem: RotorProblem) -> Self:
        full_speed = float(np.max(problem.speed)) if self.full_speed is None else self.full_speed
        return dataclasses.replace(self, full_speed=full_speed)

    def factor(self, speed: Array, theta: Array) -> Array:
        """Coefficients over their values at rest, (n, n_speed)."""
        return 1 + column(theta[:, 0]) * speed / (np.max(speed) if self.full_speed is None else self.full_speed)


@dataclass(frozen=True)
class SpeedDependentStiffness(SlopeOverSpeed):
    """The bearings' stiffness rises or falls with speed."""

    full_speed: float | None = setting(
        None, "the speed at which the change is a; null: the highest of the problem", unit="rad/s", above=0
    )

    words = "stiffness over speed"
    says = "Bearing stiffness is {stiffness_slope:higher|lower} at full speed than at rest"
    check_next = (
        "Record oil temperature and load over the run:"
        " identifying bands of speed apart confirms it if stiffness differs."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "cubic_stiffness": "both move peaks; a run with more unbalance, a run-up and a run-down",
        "youngs_modulus": "both move the peaks; several critical speeds, or tap the rotor hanging free",
        "mass": "both move the peaks; several critical speeds, or weigh the rotor",
        "flexible_pedestal": "a pedestal's mass softens it with speed too; a sensor on the casing",
        "foundation_resonance": "a block's mass softens it with speed too; a sensor on the foundation, another axis",
        "run_up_acceleration": "both move a peak; a second run-up at another rate, a coast-down",
        "bearing_mass": "both change the bearings' stiffness with speed; a wider band, an impact test at standstill",
    }

    sizes = (Size("stiffness_slope", "%", (LOWEST, HIGHEST), drawn=NOTICED),)

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        changed = impedance.copy()
        for axis in (0, 1):
            changed.real[:, axis, axis] *= self.factor(speed, theta)
        return changed
