"""Unequal bearings: stiffness of one × (1 + a), and its damping × (1 + b), in x and y separately.

Two bearings of one type differ by their static load and clearance (J. W. Lund, Review of the concept of dynamic
coefficients for fluid film journal bearings, J. Tribology 109 (1987) 37–41). It changes the shape of the modes: one end
moves more than the other. Direct coefficients change, cross-coupled ones do not.

Each bearing is tried by itself, with its stiffness or with stiffness and damping. Two bearings that share their unknowns are one place:
a first one that is stiffer is a second one that is softer, so the second differs and the first has the common values. A coefficient
that an unknown sets for one bearing alone cannot differ from itself, and is left out.
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
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import RotorEffect, column
from problems.rotor.extension.sizes import Size
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget

LIMITS = (-0.75, 3.0)  # a quarter to four times: bearings of one type that differ by more are of two types
NOTICED = (0.04, 0.35)  # of either sign in each direction, are drawn
STIFFNESS, DAMPING = "stiffness", "damping"
CHANGES = {STIFFNESS: (STIFFNESS,), DAMPING: (DAMPING,), "stiffness and damping": (STIFFNESS, DAMPING)}
LETTERS = {STIFFNESS: "k", DAMPING: "c"}


@dataclass(frozen=True)
class UnequalBearings(RotorEffect):
    """One bearing is stiffer or softer than the others, or damps more or less."""

    bearing: int = setting(1, "which one differs, as the rotor file counts", at_least=1)
    changes: str = setting(STIFFNESS, "which of its coefficients differ", choices=tuple(CHANGES))

    picture = ORBIT
    check_next = "Measure clearance and static load of the bearings: a difference confirms it; common unknowns are of the other one."
    aliases: ClassVar[Mapping[str, str]] = {
        "unbalance": "both change the mix of modes; sensors near both ends, a trial weight on each disk",
        "bearing_position": "both change the share of each bearing; measure the width over which it carries",
    }

    @property
    def sizes(self) -> Sequence[Size]:
        names = [f"{part}_difference_{axis}" for part in CHANGES[self.changes] for axis in DIRECTIONS]
        return [Size(name, "%", LIMITS, drawn=NOTICED) for name in names]

    def __str__(self) -> str:
        return f"{self.changes} of bearing {self.bearing}"

    def locations(self, problem: RotorProblem) -> Sequence[UnequalBearings]:
        n_bearing = len(problem.rotor.bearings)
        if n_bearing < 2:
            return []
        return [
            dataclasses.replace(self, bearing=index + 1, changes=changes)
            for index in range(n_bearing)
            for changes in _possible({part for part in LETTERS if not _is_free(problem, index, part)})
            if index or not _are_exchangeable(problem, changes)
        ]

    def placed_on(self, problem: RotorProblem) -> UnequalBearings:
        n_bearing = len(problem.rotor.bearings)
        if n_bearing < 2:
            raise SettingError("unequal bearings: expected at least two bearings, got one; leave this effect out")
        if self.bearing > n_bearing:
            raise SettingError(f"bearing: expected one from 1 to {n_bearing}, got {self.bearing}")
        return self

    def places(self, problem: RotorProblem) -> Sequence[float]:
        positions = [bearing.position for bearing in problem.rotor.bearings]
        return (
            positions if len(positions) == 2 else positions[self.bearing - 1 : self.bearing]
        )  # of two, either differs

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        """Both axes in one if they agree."""
        return self._compared(sizes, "the other bearings")

    def statement_on(self, problem: RotorProblem, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        """Statement that names the other one of two bearings by its number."""
        is_of_two = len(problem.rotor.bearings) == 2
        return self._compared(sizes, f"bearing {3 - self.bearing}") if is_of_two else self.statement(sizes)

    def _compared(self, sizes: Mapping[str, SizeRecord], others: str) -> StatementRecord:
        said: list[str] = []
        used: dict[str, SizeRecord] = {}
        for part in CHANGES[self.changes]:
            phrase, own = _difference({axis: sizes[f"{part}_difference_{axis}"] for axis in DIRECTIONS}, part)
            said.append(phrase)
            used |= own
        sentence = f"Bearing {self.bearing} {' and '.join(said)} than {others}"
        return dataclasses.replace(super().statement(sizes), sentence=sentence, sizes=used)

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        changed, own = impedance.copy(), self.bearing - 1
        for index, part in enumerate(CHANGES[self.changes]):
            of = changed.real if part == STIFFNESS else changed.imag
            for axis in (0, 1):
                of[own, axis, axis] *= 1 + column(theta[:, 2 * index + axis])
        return changed


def _difference(sizes: Mapping[str, SizeRecord], part: str) -> tuple[str, dict[str, SizeRecord]]:
    """Words for a bearing's stiffness or damping, 'is {…:stiffer|softer} in x and y', and sizes by name."""
    verb, words = ("is", "stiffer|softer") if part == STIFFNESS else ("damps", "more|less")
    x, y = sizes["x"], sizes["y"]
    if x.holds(y.value) and y.holds(x.value):
        return f"{verb} {{{part}:{words}}} in x and y", {part: min(x, y, key=_width)}
    return f"{verb} {{{part}_x:{words}}} in x and {{{part}_y:{words}}} in y", {f"{part}_x": x, f"{part}_y": y}


def _width(size: SizeRecord) -> float:
    return np.inf if size.low is None or size.high is None else size.high - size.low


def _possible(shared: set[str]) -> list[str]:
    """Changes of the coefficients that a bearing shares with others or has as known.

    They are changes of damping alone if nothing else can differ.
    """
    found = [changes for changes, parts in CHANGES.items() if shared.issuperset(parts)]
    return [changes for changes in found if changes != DAMPING or len(found) == 1]


def _are_exchangeable(problem: RotorProblem, changes: str) -> bool:
    """Whether the rotor has two bearings, and unknowns set each coefficient that differs for both."""
    wanted = [LETTERS[part] + axis + axis for part in CHANGES[changes] for axis in DIRECTIONS]
    pairs = [{BearingTarget(bearing, name) for bearing in (0, 1)} for name in wanted]
    set_together = [set(item.targets) for item in problem.unknowns]
    return len(problem.rotor.bearings) == 2 and all(any(pair <= own for own in set_together) for pair in pairs)


def _is_free(problem: RotorProblem, bearing: int, part: str) -> bool:
    """Whether unknowns set a bearing's direct coefficients of stiffness or damping for it alone."""
    wanted = [BearingTarget(bearing, LETTERS[part] + axis + axis) for axis in DIRECTIONS]
    return any(item.targets == (target,) for item in problem.unknowns for target in wanted)
