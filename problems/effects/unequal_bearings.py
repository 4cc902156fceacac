"""Bearings that differ: the first one's stiffness × (1 + a), that of all others × (1 − a), in x and y separately.

Two bearings of one type differ by their static load and clearance (J. W. Lund, Review of the concept of dynamic
coefficients for fluid film journal bearings, J. Tribology 109 (1987) 37–41). It changes the shape of the modes: one end
moves more than the other. Direct stiffnesses change, cross-coupled ones do not.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import DIRECTIONS
from ksmea.plugins.effect import ORBIT, SizeRecord, StatementRecord
from problems.rotor.extension.effect import ALL_BEARINGS, RotorEffect, column
from problems.rotor.extension.sizes import Size
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.5
WORDS = "stiffer|softer"
NOTICED = (0.04, 0.35)  # of either sign in each direction, are drawn


@dataclass(frozen=True)
class UnequalBearings(RotorEffect):
    """The first bearing is stiffer or softer than the others."""

    extent = ALL_BEARINGS
    picture = ORBIT
    check_next = "Clearance and static load of both bearings."
    aliases: ClassVar[Mapping[str, str]] = {
        "unbalance": "both change the mix of modes; sensors near both ends, a trial weight on each disk",
        "bearing_position": "both change the share of each bearing; measure the width over which it carries",
    }

    sizes = tuple(Size(f"stiffness_difference_{axis}", "%", LARGEST, drawn=NOTICED) for axis in DIRECTIONS)

    def locations(self, problem: RotorProblem) -> Sequence[UnequalBearings]:
        return [self] if len(problem.rotor.bearings) > 1 else []

    def placed_on(self, problem: RotorProblem) -> UnequalBearings:
        if not self.locations(problem):
            raise SettingError("unequal bearings: expected at least two bearings, got one; leave this effect out")
        return self

    def places(self, problem: RotorProblem) -> Sequence[float]:
        first, *others = (bearing.position for bearing in problem.rotor.bearings)
        return [first, *others] if len(others) == 1 else [first]  # of two, either differs from the other

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        """The ratio (1 − a)/(1 + a) of the others' stiffness to the first one's, in per cent; both axes in one if they agree."""
        x, y = (sizes[f"stiffness_difference_{axis}"] for axis in DIRECTIONS)
        others = {axis: size.mapped(others_over_first, "%") for axis, size in (("x", x), ("y", y))}
        if others["x"].holds(others["y"].value) and others["y"].holds(others["x"].value):
            mean = others["x"] if _width(others["x"]) < _width(others["y"]) else others["y"]
            sentence, used = f"Bearing 2 is {{both:{WORDS}}} than bearing 1 in x and y", {"both": mean}
        else:
            sentence, used = f"Bearing 2 is {{x:{WORDS}}} in x and {{y:{WORDS}}} in y than bearing 1", others
        return dataclasses.replace(super().statement(sizes), sentence=sentence, sizes=used)

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        changed = impedance.copy()
        for axis in (0, 1):
            changed.real[:1, axis, axis] *= 1 + column(theta[:, axis])
            changed.real[1:, axis, axis] *= 1 - column(theta[:, axis])
        return changed


def others_over_first(percent: float) -> float:
    """Stiffness of the other bearings over that of the first, less 1, in per cent.

    >>> others_over_first(8.0)
    -14.814814814814815
    """
    return -200 * percent / (100 + percent)


def _width(size: SizeRecord) -> float:
    return np.inf if size.low is None or size.high is None else size.high - size.low
