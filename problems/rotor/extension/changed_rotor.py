"""The rotor itself as effects change it, by the values of their unknowns.

Values of all unknowns are x (d,) or rows (n, d), SI: first the rotor's own unknowns, then the unknowns of each effect.
"""

from __future__ import annotations

import itertools
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ksmea.arrays import Array, Indices, Mask
from ksmea.numerics.differences import recent
from ksmea.problem.parameters import Parameter, Parameters
from problems.rotor.extension.hooks import RotorHooks, effect_unknowns
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.problem import RotorProblem

MAX_ROTORS = 8  # kept as effects have changed them


@dataclass(frozen=True, eq=False)
class ChangedRotor:
    """A rotor and the effects that change it, by their hooks (`problems/rotor/extension/hooks.py`)."""

    base: RotorProblem  # without effects
    effects: tuple[RotorHooks, ...]

    @cached_property
    def _unknowns(self) -> tuple[tuple[Parameter, ...], ...]:
        return (self.base.parameters.items, *effect_unknowns(self.base, self.effects))

    @cached_property
    def parameters(self) -> Parameters:
        return Parameters(tuple(itertools.chain(*self._unknowns)))

    @cached_property
    def _columns(self) -> list[Indices]:
        """Columns of the rotor's own unknowns, then of the unknowns of each effect."""
        counts = [len(items) for items in self._unknowns]
        return np.split(np.arange(sum(counts)), np.cumsum(counts)[:-1])

    def parts(self, x: Array) -> tuple[Array, list[Array]]:
        """Values (n, …) of the rotor's own unknowns, and of the unknowns of each effect."""
        own, *of_effects = (x[:, columns] for columns in self._columns)
        return own, of_effects

    @cached_property
    def _costly(self) -> list[Indices]:
        """Indices, for each effect, of its own unknowns that change the rotor itself or move its probes."""
        return [effect.costly(len(columns)) for effect, columns in zip(self.effects, self._columns[1:])]

    @cached_property
    def costly(self) -> Indices:
        """Indices of the unknowns that change the rotor itself or move its probes."""
        found = [columns[own] for own, columns in zip(self._costly, self._columns[1:])]
        return np.concatenate([np.empty(0, dtype=int), *found])

    @cached_property
    def linear(self) -> Mask:
        """Mask (d,) of the unknowns on which the rotor's matrices depend linearly, and jointly."""
        is_alone = len(self.changing_rotor) == 1
        return self._mask(lambda effect, n: effect.linear(n) & (is_alone or not effect.multiplies))

    @cached_property
    def of_probes(self) -> Mask:
        """Which unknowns (d,) move probes, and change nothing of the rotor."""
        return self._mask(lambda effect, n_unknown: effect.of_probes(n_unknown))

    def _mask(self, asked: Callable[[RotorHooks, int], Mask]) -> Mask:
        found = np.zeros(len(self.parameters), dtype=bool)
        for effect, columns in zip(self.effects, self._columns[1:]):
            found[columns] = asked(effect, len(columns))
        return found

    @property
    def loads_follow_rotor(self) -> bool:
        """Whether effects load the rotor, as its matrices may say."""
        return any(effect.has_loads for effect in self.effects)

    @cached_property
    def changing_rotor(self) -> tuple[RotorHooks, ...]:
        """The effects that change the rotor or move its probes."""
        return tuple(effect for effect, own in zip(self.effects, self._costly) if len(own) or effect.is_held)

    def rotor_with(self, x: Array) -> Rotor:
        """The rotor as effects change it at values (d,) SI; its bearings and unbalance are nominal."""
        return self.changed_rotor(self.base.rotor, x[self.costly])

    def changed_rotor(self, rotor: Rotor, changing: Array) -> Rotor:
        """A rotor as effects change it, by the values of the costly unknowns."""

        def made() -> Rotor:
            changed = rotor
            for effect, theta in self._changing(changing):
                if effect.changes_rotor:
                    changed = effect.rotor(changed, theta)
            return changed

        return recent(self._rotors, changing.tobytes(), made, MAX_ROTORS) if rotor is self.base.rotor else made()

    @cached_property
    def _rotors(self) -> OrderedDict[Hashable, Rotor]:
        return OrderedDict()

    def _changing(self, changing: Array) -> Iterator[tuple[RotorHooks, Array]]:
        """Effects that change the rotor or move its probes, and the values of their own unknowns.

        The value is 0 for each one that is not costly.
        """
        start = 0
        for effect, own, columns in zip(self.effects, self._costly, self._columns[1:]):
            if len(own) or effect.is_held:
                theta = np.zeros(len(columns))
                theta[own] = changing[start : start + len(own)]
                start += len(own)
                yield effect, theta
