"""Cubic stiffness of the bearings: beside k they hold the shaft with a force k₃ |r|² r, which stiffens or softens as motions grow.

Ball bearings stiffen as their balls share the load, mountings of rubber and thin oil films do either; the third power is the first
that a support which is alike in opposite directions has (A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations, 1979, ch. 4). Peaks
lean to higher speeds where it stiffens, to lower ones where it softens, by more as the unbalance grows; where they fold over, run-up
and run-down differ. At 3X the shaft answers on an orbit that is no circle. A bearing that softens holds nothing at |r|² = k/|k₃|:
motions so large are not described.

What acts is found by harmonic balance, and of several steady motions the one that the direction of the run leads to
(`ksmea/nonlinear/steady_motion.py`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ksmea.errors import SettingError
from ksmea.nonlinear.laws import LAWS
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import require_on_shaft, stiffness_scale
from problems.rotor.extension.nonlinear_effect import UP, NonlinearEffect, eccentricity
from problems.rotor.extension.site_law import SiteLaw
from problems.rotor.extension.sizes import Size
from problems.rotor.response.problem import RotorProblem

DOUBLED = 10.0  # times the eccentricity of the largest unbalance: at such a motion the limit doubles the stiffness
NOTICED = (0.003, 0.3)  # of the limits, of either sign, are drawn
LAW = LAWS["cubic_spring"]


def _largest(problem: RotorProblem) -> float:
    return stiffness_scale(problem) / (DOUBLED * eccentricity(problem)) ** 2


@dataclass(frozen=True)
class CubicStiffness(NonlinearEffect):
    """The bearings stiffen or soften with the size of the motion."""

    is_scanned: ClassVar[bool] = False  # from 0 on fits lead to it

    positions: list[float] = setting([], "where these springs are, alike; none: at all bearings", unit="m", at_least=0)

    words = "nonlinear bearing stiffness"
    says = "Nonlinear bearing stiffness of {cubic_stiffness:(hardening)|(softening)}, {place}"
    check_next = "Clearance and preload of the bearings; repeat the run with less and with more unbalance."
    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_stiffness": "both move peaks; a run with more unbalance, a run-up beside a run-down",
        "clearance_rub": "both lean peaks; a run with more unbalance",
    }

    sizes = (Size("cubic_stiffness", "MN/mm³", 1.0, drawn=NOTICED, of=_largest, makes_jumps=True),)

    def __str__(self) -> str:
        return f"at {self.positions[0]:g} m" if len(self.positions) == 1 else "all bearings"

    def locations(self, problem: RotorProblem) -> Sequence[CubicStiffness]:
        if self.positions:
            return [self]
        each = [dataclasses.replace(self, positions=[position]) for position in _bearings(problem)]
        return [self.placed_on(problem), *(each if len(each) > 1 else [])]

    def placed_on(self, problem: RotorProblem) -> CubicStiffness:
        placed = self if self.positions else dataclasses.replace(self, positions=_bearings(problem))
        for position in placed.positions:
            require_on_shaft(problem, position, "cubic stiffness")
        return placed

    def places(self, problem: RotorProblem) -> Sequence[float]:
        return self.placed_on(problem).positions

    def site_law(self) -> SiteLaw:
        if not self.positions:
            raise SettingError("positions: expected those of the bearings, got none; add the effect to a problem")
        first, *others = self.positions
        return SiteLaw(first, LAW, further=tuple(others), orders=self.orders, goes_up=self.direction == UP)


def _bearings(problem: RotorProblem) -> list[float]:
    return list(dict.fromkeys(bearing.position for bearing in problem.rotor.bearings))
