"""What an effect on a rotor may do: hooks, each of which leaves things as they are unless an effect overrides it.

Values of an effect's unknowns are rows of θ (n, e), SI, in the order of its `parameters`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.channel import Channel
from ksmea.contracts import Problem
from ksmea.errors import SettingError
from ksmea.parameters import Parameter
from ksmea.settings import Settings
from problems.rotor.data import SAME_PLACE, Rotor
from problems.rotor.extended import ExtendedProblem
from problems.rotor.problem import RotorProblem


@dataclass(frozen=True)
class RotorEffect(Settings):
    """Base of effects on rotors; the fields of an effect say where it sits."""

    aliases: ClassVar[Mapping[str, str]] = MappingProxyType({})
    is_scanned: ClassVar[bool] = True
    changes_rotor: ClassVar[bool] = False  # overrides `rotor`
    couples_axes: ClassVar[bool] = False  # its `impedance` has entries beside the diagonal
    has_loads: ClassVar[bool] = False  # overrides `loads` and `load_sizes`
    # Effects act from the lowest stage to the highest, in whatever order they were added: a bearing (0) before what
    # carries it (1); what a probe sees (0) before its angle (1), and that before its gain (2).
    stage: ClassVar[int] = 0

    def __str__(self) -> str:
        """Where it sits, for people."""
        return "whole rotor"

    def places(self, problem: RotorProblem) -> Sequence[Self]:
        """This effect at each place of the rotor where it may sit."""
        return (self,)

    def placed_on(self, problem: RotorProblem) -> Self:
        """This effect as it sits on a problem; `SettingError` where it cannot sit there."""
        return self

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        """Its unknowns, with bounds that hold 0, where the model is as without it."""
        raise NotImplementedError

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        """Values (e,) of its unknowns as they may well occur, large enough to be noticed."""
        raise NotImplementedError

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        """The rotor as changed by one set of values (e,)."""
        return rotor

    def impedance(self, impedance: ComplexArray, speed: Array, theta: Array) -> ComplexArray:
        """Impedances of the bearings, (n_bearing, 2, 2, n, n_speed) N/m from motion (second 2) to force (first 2)."""
        return impedance

    def loads(self, rotor: Rotor, speed: Array) -> ComplexArray:
        """Nodal forces per unit of each load, (n_speed, n_dof, n_load)."""
        raise NotImplementedError

    def load_sizes(self, theta: Array) -> ComplexArray:
        """How large each load is, (n, n_load)."""
        raise NotImplementedError

    def needed_channels(self, channels: Sequence[Channel]) -> Sequence[Channel]:
        """Further channels whose motion its `observed` makes these channels of."""
        return ()

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        """What the probes make of a motion, (n, n_speed, n_channel) m."""
        return response

    def added_to(self, problem: Problem) -> ExtendedProblem:
        """The problem with this effect."""
        if isinstance(problem, ExtendedProblem):
            return ExtendedProblem(problem.base, (*problem.effects, self.placed_on(problem.base)))
        if not isinstance(problem, RotorProblem):
            raise SettingError(f"effects: expected a rotor of this project, got {type(problem).__name__}")
        return ExtendedProblem(problem, (self.placed_on(problem),))


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
