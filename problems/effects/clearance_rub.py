"""Rub: where its motion is larger than a clearance, the shaft touches a stop around it and rubs against it.

With r the motion at the place, the stop pushes with −k (1 − δ/|r|) r outside of |r| = δ, and drags against the turning shaft with μ
times as much, at right angles (the Jeffcott rotor of A. Muszynska, Rotordynamics, 2005, ch. 5, and J. Jiang and H. Ulbrich, Nonlinear
Dyn. 24 (2001) 269–283). Contact stiffens: peaks are cut off at about the clearance and lean to higher speeds, where run-up and run-down
differ; an orbit that is no circle has 3X. The clearance is around the shaft as it is without unbalance: one that the shaft leans into,
with contact on one side and motions at 2X and ½X, is not described, nor is dry whip, a backward whirl at another frequency.

Without contact stiffness the other unknowns do nothing. What acts is found by harmonic balance, and of several steady motions the one
that the direction of the run leads to (`ksmea/nonlinear/steady_motion.py`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.nonlinear.laws import LAWS
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import setting
from ksmea.units import MICROMETRE
from problems.rotor.extension.effect import drawn, require_on_shaft, stiffness_scale
from problems.rotor.extension.nonlinear_effect import UP, NonlinearEffect, eccentricity
from problems.rotor.extension.site_law import SiteLaw
from problems.rotor.response.problem import RotorProblem

WIDEST = 30.0  # clearance, times the eccentricity of the largest unbalance: motions beside resonances are far smaller
ROUGHEST = 0.5  # friction coefficient: dry steel on steel
STIFF, WIDE, ROUGH = (0.01, 0.3), (0.03, 0.3), (0.05, 0.6)  # of the limits, are drawn
LAW = LAWS["rub"]


@dataclass(frozen=True)
class ClearanceRub(NonlinearEffect):
    """The shaft touches a stop where it moves farther than a clearance."""

    if_nowhere: ClassVar[str] = "this rotor has no disks; give its position, which takes a file"

    position: float | None = setting(None, "where it touches; null: at a disk", unit="m", at_least=0)

    aliases: ClassVar[Mapping[str, str]] = {
        "cubic_stiffness": "both lean peaks; a run with more unbalance",
        "speed_dependent_damping": "both lower a peak; a run with more unbalance",
    }

    def __str__(self) -> str:
        return "at a disk" if self.position is None else f"at {self.position:g} m"

    def locations(self, problem: RotorProblem) -> Sequence[ClearanceRub]:
        if self.position is not None:
            return [self]
        disks = dict.fromkeys(disk.position for disk in problem.rotor.disks)
        return [dataclasses.replace(self, position=position) for position in disks]

    def placed_on(self, problem: RotorProblem) -> ClearanceRub:
        require_on_shaft(problem, self.position, "rub")
        if self.position is not None:
            return self
        if not problem.rotor.disks:
            raise SettingError(f"position: expected where the shaft rubs, got none; {self.if_nowhere}")
        return dataclasses.replace(self, position=problem.rotor.disks[0].position)

    def places(self, problem: RotorProblem) -> Sequence[float]:
        return [] if self.position is None else [self.position]

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        return (
            Parameter("contact_stiffness", "MN/m", 1e6, 0.0, stiffness_scale(problem), makes_jumps=True),
            Parameter("clearance", "µm", MICROMETRE, 0.0, WIDEST * eccentricity(problem), makes_jumps=True),
            Parameter("friction", "%", 0.01, 0.0, ROUGHEST, makes_jumps=True),
        )

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        parts = [drawn(rng, *decade) for decade in (STIFF, WIDE, ROUGH)]
        return np.array([part * item.upper for part, item in zip(parts, self.parameters(problem))])

    def site_law(self) -> SiteLaw:
        if self.position is None:
            raise SettingError("position: expected where the shaft rubs, got none; add the effect to a problem")
        return SiteLaw(self.position, LAW, orders=self.orders, goes_up=self.direction == UP)
