"""Effects on rotors: hooks into the rotor, the problem with the effect, and shared helpers.

Limits of an effect's unknowns follow from sizes of the rotor: its weight, stiffness and response.
"""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self, cast

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import named as in_words
from ksmea.plugins.effect import Effect
from ksmea.problem.campaign_problem import CampaignProblem
from ksmea.problem.parameters import Parameter
from ksmea.problem.problem import Problem
from problems.rotor.extension.extended import ExtendedPhysics
from problems.rotor.extension.hooks import RotorHooks
from problems.rotor.extension.sizes import Size, VectorSize, drawn, drawn_either_side, drawn_vector  # noqa: F401 – for effects
from problems.rotor.finite_elements.bearing import STIFFNESSES
from problems.rotor.finite_elements.data import SAME_PLACE, Rotor
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, UnbalanceTarget

WHOLE_ROTOR, ALL_BEARINGS = "whole rotor", "all bearings"


class HasPosition(Protocol):
    """A part of a rotor at a position along the shaft, m."""

    @property
    def position(self) -> float: ...


@dataclass(frozen=True)
class RotorEffect(RotorHooks, Effect[RotorProblem]):
    """Base of effects on rotors; the fields of an effect state its location.

    A subclass has `sizes`, or `parameters` and `draw`, and overrides the hooks (`RotorHooks`) by which it acts.
    """

    extent: ClassVar[str] = WHOLE_ROTOR  # location of an effect without one place, in words
    for_drawings_only: ClassVar[bool] = (
        False  # tried without its name on a machine as drawn alone: a published rotor is exact
    )

    def __str__(self) -> str:
        """Location of the effect, in words."""
        return self.extent

    def is_offered(self, problem: RotorProblem) -> bool:
        return problem.is_as_drawn or not self.for_drawings_only

    @property
    def sizes(self) -> Sequence[Size]:
        """Unknowns of the effect, in one line each.

        Default: `parameters` and `draw` are overridden.
        """
        raise NotImplementedError(
            f"{type(self).__name__}: expected `sizes`, or `parameters` and `draw`, got none of them"
        )

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        return tuple(parameter for size in self.sizes for parameter in size.parameters(problem))

    def vectors(self) -> Sequence[str]:
        if type(self).sizes is RotorEffect.sizes:
            return ()
        return [size.name for size in self.sizes if isinstance(size, VectorSize)]

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        return np.concatenate([size.draw(problem, rng) for size in self.sizes])

    def load_sizes(self, theta: Array) -> ComplexArray:
        """Size of each load.

        Default: one load that turns forward, whose components x and y are the first two unknowns.

        Args:
            theta: values (n, e), SI.

        Returns:
            Complex sizes (n, n_load), in the units of `loads`.
        """
        return forward_vector(theta)[:, None]

    def placed_on(self, problem: RotorProblem) -> Self:
        """This effect at its location on a problem.

        Args:
            problem: rotor without the effect.

        Raises:
            SettingError: it cannot sit there.
        """
        return self

    def added_to(self, problem: Problem) -> Problem:
        """Problem with this effect, in all its runs.

        Args:
            problem: rotor, or its runs, without the effect.

        Returns:
            Problem whose unknowns are followed by the effect's own.

        Raises:
            SettingError: the problem is not a rotor of this project, or the effect cannot sit on it.
        """
        if isinstance(problem, CampaignProblem):
            return problem.changed(self.added_to)
        if not isinstance(problem, RotorProblem):
            raise SettingError(f"effects: expected a rotor of this project, got {type(problem).__name__}")
        return problem.with_effects((*problem.effects, self.placed_on(problem.plain)))

    def physics(
        self, plain: RotorProblem, effects: tuple[RotorHooks, ...], near: ComplexArray | None = None
    ) -> ExtendedPhysics:
        """Motion of a rotor with effects, this one among them.

        Args:
            plain: rotor without effects.
            effects: all effects.
            near: motion (n_speed, n_order, n_unit), m, of the sites of nonlinear forces next to which the steady-state response is
                sought. Default: the response of a slow run.
        """
        return ExtendedPhysics(plain, effects, near)


class PlacedEffect(RotorEffect):
    """Base of effects that act at one position alone; None: the position that `placed_on` chooses, or all."""

    what: ClassVar[str] = ""  # what sits or looks there, in messages; '': the position is not checked
    position: float | None  # a setting of each, with what it means there

    def places(self, problem: RotorProblem) -> Sequence[float]:
        return () if self.position is None else (self.position,)

    def placed_on(self, problem: RotorProblem) -> Self:
        """At its position. No probe need look there now: a problem may be seen by others."""
        if self.what:
            require_on_shaft(problem, self.position, self.what)
        return self

    def at_each(self, positions: Iterable[float]) -> list[Self]:
        """This effect at each of these positions, m."""
        return [dataclasses.replace(cast(Any, self), position=position) for position in positions]

    @property
    def place(self) -> float:
        """Its position, m, once it sits on a problem."""
        if self.position is None:
            raise SettingError(
                f"position: expected the place of the {self.what}, got none; add the effect to a problem"
            )
        return self.position


class SeatedEffect(PlacedEffect):
    """Base of effects that sit on the shaft, at the first of their `seats` if no position is given."""

    default_place: ClassVar[str]  # the first of its seats, in words
    needs: ClassVar[str] = "a position"  # for the message if a rotor has no seat

    @abstractmethod
    def seats(self, problem: RotorProblem) -> Sequence[float]:
        """Positions on the shaft at which it may sit.

        Args:
            problem: rotor without the effect.

        Returns:
            Positions, m, the default one first.
        """

    def __str__(self) -> str:
        return self.default_place if self.position is None else f"at {self.position:g} m"

    def locations(self, problem: RotorProblem) -> Sequence[Self]:
        return [placed.placed_on(problem) for placed in self.at_each(self.seats(problem))]

    def placed_on(self, problem: RotorProblem) -> Self:
        if self.position is None:
            if not (seats := self.seats(problem)):
                raise SettingError(f"position: expected {self.needs}, got none; give its position, or leave it out")
            return self.at_each(seats[:1])[0].placed_on(problem)
        return super().placed_on(problem)


def named(direction: str | None) -> str:
    """The direction of the channels that an effect is about, in words; None: all."""
    return "x and y" if direction is None else in_words(direction)


def column(values: Array) -> Array:
    """Values (n,) of an unknown as they multiply arrays (n, n_speed)."""
    return np.asarray(values)[:, None]


def forward_vector(theta: Array) -> ComplexArray:
    """Two Cartesian components (n, 2) as one complex number (n,).

    R_x + i r_y is the x amplitude of the forward vector r (1, −i), which at t = 0 points to (r_x, r_y).
    """
    return theta[:, 0] + 1j * theta[:, 1]


def is_near(position: float, other: float) -> bool:
    """Whether two positions (m) are one."""
    return abs(position - other) <= SAME_PLACE


def places_of(parts: Iterable[HasPosition], rotor: Rotor) -> list[float]:
    """Positions of parts of a rotor, each place once, m."""
    return distinct((part.position for part in parts), rotor)


def distinct(positions: Iterable[float], rotor: Rotor) -> list[float]:
    """Positions, m, each once: equal ones may differ by rounding."""
    found: list[float] = []
    for position in positions:
        if all(abs(position - other) > SAME_PLACE * rotor.length for other in found):
            found.append(position)
    return found


def planes(problem: RotorProblem) -> list[float]:
    """Positions of the probes, each once, m."""
    return list(dict.fromkeys(channel.position for channel in problem.channels))


def require_on_shaft(problem: RotorProblem, position: float | None, what: str) -> None:
    """Raise `SettingError` for a position off the shaft."""
    if position is not None:
        problem.rotor.require_on_shaft(position, what)


def where(position: float | None) -> str:
    return "all planes" if position is None else f"at {position:g} m"


def stiffness_scale(problem: RotorProblem) -> float:
    """The largest stiffness that a bearing has or may have, N/m."""
    limits = [
        item.parameter.upper
        for item in problem.unknowns
        for target in item.targets
        if isinstance(target, BearingTarget) and target.coefficient in STIFFNESSES
    ]
    return float(max([*limits, *(bearing.largest_stiffness for bearing in problem.rotor.bearings)]))


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
    """Mass of all that turns, kg."""
    return float(problem.rotor.mass)


def shaft_length(problem: RotorProblem) -> float:
    """m."""
    return problem.rotor.length
