"""Cubic stiffness of the bearings: a force k₃ |r|² r in addition to k r, stiffening or softening.

Ball bearings stiffen as their balls share the load, mountings of rubber and thin oil films do either; the third power
is the first that a support which is alike in opposite directions has (A. H. Nayfeh and D. T. Mook, Nonlinear
Oscillations, 1979, ch. 4). Peaks lean to higher speeds where it stiffens, to lower ones where it softens, by more as
the unbalance grows; where they fold over, run-up and run-down differ. On a non-circular orbit the shaft also moves at
3X. A bearing that softens holds nothing at |r|² = k/|k₃|: motions so large are not described.

What acts is found by harmonic balance, and of several steady motions the one that the direction of the run leads to
(`ksmea/nonlinear/steady_motion.py`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

from ksmea.errors import SettingError
from ksmea.nonlinear.laws import LAWS, Law
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import places_of, require_on_shaft, stiffness_scale
from problems.rotor.extension.nonlinear_effect import UP, NonlinearEffect, eccentricity
from problems.rotor.extension.site_law import SiteLaw
from problems.rotor.extension.sizes import Size
from problems.rotor.response.problem import RotorProblem

DOUBLED = 10.0  # times the eccentricity of the largest unbalance: at such a motion the limit doubles the stiffness
NOTICED = (0.003, 0.3)  # of the limits, of either sign, are drawn


def _largest(problem: RotorProblem) -> float:
    return stiffness_scale(problem) / (DOUBLED * eccentricity(problem)) ** 2


@dataclass(frozen=True)
class BearingSprings(NonlinearEffect):
    """Base of springs at one or all bearings, whose force is not linear in the motion, by a `law`."""

    law: ClassVar[Law]
    is_scanned: ClassVar[bool] = False  # from 0 on fits lead to it

    positions: list[float] = setting([], "positions of these springs, alike; empty: all bearings", unit="m", at_least=0)

    def __str__(self) -> str:
        return f"at {self.positions[0]:g} m" if len(self.positions) == 1 else "all bearings"

    def locations(self, problem: RotorProblem) -> Sequence[Self]:
        if self.positions:
            return [self]
        each = [dataclasses.replace(self, positions=[position]) for position in _bearings(problem)]
        return [self.placed_on(problem), *(each if len(each) > 1 else [])]

    def placed_on(self, problem: RotorProblem) -> Self:
        placed = self if self.positions else dataclasses.replace(self, positions=_bearings(problem))
        for position in placed.positions:
            require_on_shaft(problem, position, "spring at a bearing")
        return placed

    def places(self, problem: RotorProblem) -> Sequence[float]:
        return self.placed_on(problem).positions

    def site_law(self) -> SiteLaw:
        if not self.positions:
            raise SettingError("positions: expected positions of bearings, got none; add the effect to a problem")
        first, *others = self.positions
        return SiteLaw(first, self.law, further=tuple(others), orders=self.orders, goes_up=self.direction == UP)


@dataclass(frozen=True)
class CubicStiffness(BearingSprings):
    """The bearings stiffen or soften with the size of the motion."""

    law: ClassVar[Law] = LAWS["cubic_spring"]

    words = "nonlinear bearing stiffness"
    says = "Nonlinear bearing stiffness of {cubic_stiffness:(hardening)|(softening)}, {place}"
    check_next = (
        "Repeat the run with more unbalance: peaks that lean further confirm it; then check clearance and preload."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_stiffness": "both move peaks; a run with more unbalance, a run-up and a run-down",
        "clearance_rub": "both lean peaks; a run with more unbalance",
        "bilinear_stiffness": "both lean peaks; a run with far more unbalance, which shows the amplitude where it begins",
    }

    sizes = (Size("cubic_stiffness", "MN/mm³", 1.0, drawn=NOTICED, of=_largest, makes_jumps=True),)


def _bearings(problem: RotorProblem) -> list[float]:
    return places_of(problem.rotor.bearings, problem.rotor)
