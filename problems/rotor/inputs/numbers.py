"""Numbers of a rotor and of its probes as unknowns.

Young's modulus of a material, the mass of a disk, the position of a probe.

Each is a `Parameter` with what it sets. With a prior it is known to a tolerance (`problems/rotor/inputs/uncertain.py`); with limits
alone it is unknown. `RotorNumbers` are the hooks by which a rotor has them in addition to its effects.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices, Mask
from ksmea.measurement.channel import Channel
from ksmea.problem.parameters import Parameter
from problems.rotor.extension.extended import ExtendedPhysics
from problems.rotor.extension.hooks import RotorHooks
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.inputs.places import Place, with_changes
from problems.rotor.inputs.probe_places import ProbePlace, moved, scaled, with_moved_housing_probes
from problems.rotor.response.problem import RotorProblem


@dataclass(frozen=True)
class RotorNumber:
    """A number of the rotor, its value in the rotor file (SI) and its places.

    `is_linear`: the matrices of the rotor are linear in it, whatever other numbers that are linear are.
    """

    parameter: Parameter
    stated: float
    places: tuple[Place, ...]
    is_linear: bool = False


@dataclass(frozen=True)
class ProbeNumber:
    """A number of probes, its value in the rotor file (SI) and its place.

    Several gains of one probe multiply.
    """

    parameter: Parameter
    stated: float
    place: ProbePlace


def are_known_to_tolerance(problem: RotorProblem, field: str) -> bool:
    """Whether numbers of this name, such as 'mass', have a prior in a joint problem."""
    return any(
        number.parameter.prior is not None and place.path[-1] == field
        for effect in problem.effects
        if isinstance(effect, RotorNumbers)
        for number in effect.numbers
        for place in number.places
    )


@dataclass(frozen=True)
class RotorNumbers(RotorHooks):
    """Numbers as the unknowns of a rotor: first numbers of the rotor, then numbers of its probes."""

    numbers: tuple[RotorNumber, ...] = ()
    probes: tuple[ProbeNumber, ...] = ()
    name: str = "numbers of the rotor"  # apart from that of others on the same rotor
    held: tuple[float, ...] = ()  # values, SI, of numbers that are no unknowns

    stage = 3  # a gain acts on whatever a probe sees

    def __str__(self) -> str:
        return self.name

    def physics(
        self, plain: RotorProblem, effects: tuple[Any, ...], near: ComplexArray | None = None
    ) -> ExtendedPhysics:
        return ExtendedPhysics(plain, effects, near)

    @property
    def is_held(self) -> bool:
        return bool(self.held)

    @property
    def _parameters(self) -> tuple[Parameter, ...]:
        return (*(item.parameter for item in self.numbers), *(item.parameter for item in self.probes))

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        return () if self.held else self._parameters

    def holding_inputs(self, theta: Array) -> Self:
        if not all(item.is_input for item in self._parameters):
            return self
        return replace(self, held=tuple(map(float, theta)))

    def _values(self, theta: Array) -> Array:
        """Values (n, e) of its numbers for values (n, …) of its unknowns."""
        return np.broadcast_to(self.held, (len(theta), len(self.held))) if self.held else theta

    def costly(self, n_unknown: int) -> Indices:
        """All but gains."""
        if self.held:
            return np.empty(0, dtype=int)
        return np.array([*range(len(self.numbers)), *(index for index, _ in self._moving)], dtype=int)

    def of_probes(self, n_unknown: int) -> Mask:
        return np.arange(n_unknown) >= len(self.numbers)

    def linear(self, n_unknown: int) -> Mask:
        return np.array([number.is_linear for number in self.numbers] + [False] * len(self.probes), dtype=bool)[
            :n_unknown
        ]

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        changes = [
            (place, float(value) - number.stated)
            for number, value in zip(self.numbers, self._values(theta[None])[0])
            for place in number.places
        ]
        changed = with_changes(rotor, changes)
        return with_moved_housing_probes(changed, self._moves(theta)) if changed.housing_probes else changed

    @property
    def _moving(self) -> list[tuple[int, ProbeNumber]]:
        """Probe numbers but gains, with their index among the unknowns."""
        return [(index, probe) for index, probe in self._of_probes if probe.place.reading != "gain"]

    @property
    def _of_probes(self) -> list[tuple[int, ProbeNumber]]:
        return list(enumerate(self.probes, start=len(self.numbers)))

    def _moves(self, theta: Array) -> list[tuple[ProbePlace, float]]:
        values = self._values(theta[None])[0]
        return [(number.place, float(values[index]) - number.stated) for index, number in self._moving]

    def moved(self, looking: Sequence[Channel], channels: Sequence[Channel], theta: Array) -> tuple[Channel, ...]:
        return moved(looking, channels, self._moves(theta))

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        gains = [(index, number) for index, number in self._of_probes if number.place.reading == "gain"]
        values = self._values(theta)
        changes = [(number.place, values[:, index] - number.stated) for index, number in gains]
        return scaled(response, channels, changes)
