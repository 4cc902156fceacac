"""What an effect on a rotor may do: four hooks, each of which leaves things as they are unless an effect overrides it.

Values of an effect's unknowns are rows of θ (n, e), SI, in the order of its `parameters`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Self

import numpy as np

from ksmea.contracts import Channel, ComplexArray, Problem
from ksmea.errors import SettingError
from ksmea.parameters import Array, Parameter
from ksmea.settings import Settings
from problems.rotor.data import Rotor
from problems.rotor.extended import ExtendedProblem
from problems.rotor.problem import RotorProblem


@dataclass(frozen=True)
class RotorEffect(Settings):
    """Base of effects on rotors; the fields of an effect say where it sits."""

    aliases: ClassVar[Mapping[str, str]] = MappingProxyType({})
    changes_rotor: ClassVar[bool] = False  # overrides `rotor`
    couples_axes: ClassVar[bool] = False  # its `impedance` has entries beside the diagonal
    has_loads: ClassVar[bool] = False  # overrides `loads` and `load_sizes`

    def places(self, problem: RotorProblem) -> Sequence[Self]:
        """This effect at each place of the rotor where it may sit."""
        return (self,)

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        """Its unknowns, with bounds that hold 0, where the model is as without it."""
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

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        """What the probes make of a motion, (n, n_speed, n_channel) m."""
        return response

    def added_to(self, problem: Problem) -> ExtendedProblem:
        """The problem with this effect."""
        if isinstance(problem, ExtendedProblem):
            return ExtendedProblem(problem.base, (*problem.effects, self))
        if not isinstance(problem, RotorProblem):
            raise SettingError(f"effects: expected a rotor of this project, got {type(problem).__name__}")
        return ExtendedProblem(problem, (self,))


def column(values: Array) -> Array:
    """Values (n,) of an unknown as they multiply arrays (n, n_speed)."""
    return np.asarray(values)[:, None]
