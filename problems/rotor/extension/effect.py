"""Effects on rotors: hooks into the rotor, the problem that has the effect, and helpers that several effects share.

Limits of an effect's unknowns follow from sizes of the rotor: its weight, stiffness and response.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.measurement.channel import named as in_words
from ksmea.plugins.effect import Effect
from ksmea.problem.campaign_problem import CampaignProblem
from ksmea.problem.problem import Problem
from problems.rotor.extension.extended import ExtendedProblem
from problems.rotor.extension.hooks import RotorHooks
from problems.rotor.finite_elements.data import SAME_PLACE, STIFFNESSES
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, UnbalanceTarget


@dataclass(frozen=True)
class RotorEffect(RotorHooks, Effect[RotorProblem]):
    """Base of effects on rotors; the fields of an effect say where it sits."""

    def __str__(self) -> str:
        """Where it sits, for people."""
        return "whole rotor"

    def placed_on(self, problem: RotorProblem) -> Self:
        """This effect as it sits on a problem; `SettingError` where it cannot sit there."""
        return self

    def added_to(self, problem: Problem) -> Problem:
        """The problem with this effect, in all its runs."""
        if isinstance(problem, CampaignProblem):
            return problem.changed(self.added_to)
        if isinstance(problem, ExtendedProblem):
            return ExtendedProblem(problem.base, (*problem.effects, self.placed_on(problem.base)))
        if not isinstance(problem, RotorProblem):
            raise SettingError(f"effects: expected a rotor of this project, got {type(problem).__name__}")
        return ExtendedProblem(problem, (self.placed_on(problem),))


class PlacedEffect(RotorEffect):
    """Base of those that act at one position alone; None: where `placed_on` puts it, or at all."""

    position: float | None  # a setting of each, with what it means there

    def places(self, problem: RotorProblem) -> Sequence[float]:
        return () if self.position is None else (self.position,)


def named(direction: str | None) -> str:
    """The direction of the channels that an effect is about, in words; None: all."""
    return "x and y" if direction is None else in_words(direction)


def column(values: Array) -> Array:
    """Values (n,) of an unknown as they multiply arrays (n, n_speed)."""
    return np.asarray(values)[:, None]


def forward_vector(theta: Array) -> ComplexArray:
    """Two Cartesian components (n, 2) as one complex number (n,): r_x + i r_y is the x amplitude of the forward vector
    r (1, −i), which at t = 0 points to (r_x, r_y)."""
    return theta[:, 0] + 1j * theta[:, 1]


def is_at(channel: Channel, position: float | None) -> bool:
    """Whether a channel looks at a position; None is anywhere."""
    return position is None or abs(channel.position - position) <= SAME_PLACE  # m


def planes(problem: RotorProblem) -> list[float]:
    """Where the probes look, each position once, m."""
    return list(dict.fromkeys(channel.position for channel in problem.channels))


def require_on_shaft(problem: RotorProblem, position: float | None, what: str) -> None:
    """`SettingError` where a position is off the shaft. No probe need look there now: a problem may be seen by others."""
    if position is not None:
        problem.rotor.require_on_shaft(position, what)


def where(position: float | None) -> str:
    return "all planes" if position is None else f"at {position:g} m"


def drawn(rng: np.random.Generator, least: float, most: float) -> float:
    """A number between `least` and `most`, each factor between them as likely as any other."""
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))


def drawn_either_side(rng: np.random.Generator, least: float, most: float) -> float:
    """A number between `least` and `most`, or its negative."""
    return float(rng.choice([-1.0, 1.0]) * drawn(rng, least, most))


def drawn_vector(rng: np.random.Generator, least: float, most: float) -> Array:
    """Cartesian components (2,) of a vector as long as between `least` and `most`, at any angle."""
    length, angle = drawn(rng, least, most), rng.uniform(0, 2 * np.pi)
    return length * np.array([np.cos(angle), np.sin(angle)])


def stiffness_scale(problem: RotorProblem) -> float:
    """The largest stiffness that a bearing has or may have, N/m."""
    limits = [
        item.parameter.upper
        for item in problem.unknowns
        for target in item.targets
        if isinstance(target, BearingTarget) and target.coefficient in STIFFNESSES
    ]
    return float(max([*limits, *(np.abs(bearing.stiffness).max() for bearing in problem.rotor.bearings)]))


def unbalance_scale(problem: RotorProblem) -> float:
    """The largest unbalance that a plane has or may have, kg m."""
    limits = [
        item.parameter.upper
        for item in problem.unknowns
        for target in item.targets
        if isinstance(target, UnbalanceTarget) and target.part == "magnitude"
    ]
    return float(max([*limits, *(plane.magnitude for plane in problem.rotor.unbalance)]))


def rotor_mass(problem: RotorProblem) -> float:
    """Mass of the shaft and its disks, kg."""
    rotor = problem.rotor
    shaft = sum(segment.material.density * segment.area * segment.length for segment in rotor.segments)
    return float(shaft + sum(disk.mass for disk in rotor.disks))
