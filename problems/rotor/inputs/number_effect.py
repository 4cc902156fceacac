"""Bases of effects that are a wrong number of the rotor file, or of its probes.

They act as a number that is known to a tolerance does (`problems/rotor/inputs/numbers.py`): by places of the rotor and of its probes.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, Indices, Mask
from ksmea.measurement.channel import Channel
from problems.rotor.extension.effect import PlacedEffect, RotorEffect, SeatedEffect, is_near, places_of
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.inputs.places import Place, with_changes
from problems.rotor.inputs.probe_places import ProbePlace, moved, with_moved_housing_probes
from problems.rotor.response.problem import RotorProblem

Part = Disk | Bearing


class NumberEffect(RotorEffect):
    """Numbers of the rotor are others.

    Its one size is the change of all of them, times the scale of each place.
    """

    multiplies: ClassVar[bool] = True
    is_linear: ClassVar[bool] = False  # the rotor's matrices are linear in its size, and nothing else depends on it

    def linear(self, n_unknown: int) -> Mask:
        return np.full(n_unknown, self.is_linear)

    @abstractmethod
    def numbers_of(self, rotor: Rotor) -> Iterator[Place]:
        """Places of these numbers in a rotor."""

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        return with_changes(rotor, ((place, float(theta[0])) for place in self.numbers_of(rotor)))


class PartEffect(NumberEffect, SeatedEffect):
    """Numbers of one of the disks or bearings are others; rotors that are not of a file have no drawing."""

    of_rotor: ClassVar[str]  # the field of a rotor that has the parts: disks or bearings
    fields: ClassVar[tuple[str, ...]]  # of a part
    is_relative: ClassVar[bool]  # whether the size is in parts of each number
    is_scanned: ClassVar[bool] = False
    for_drawings_only: ClassVar[bool] = True

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        parts = self._parts(problem.rotor)
        return places_of((part for part in parts if any(scale for _, scale in self._scales(part))), problem.rotor)

    def numbers_of(self, rotor: Rotor) -> Iterator[Place]:
        for index, part in enumerate(self._parts(rotor)):
            if is_near(part.position, self.place):
                yield from (Place((self.of_rotor, index, field), scale) for field, scale in self._scales(part))

    def _scales(self, part: Part) -> list[tuple[str, float]]:
        return [(field, getattr(part, field) if self.is_relative else 1.0) for field in self.fields]

    def _parts(self, rotor: Rotor) -> Sequence[Part]:
        found: Sequence[Part] = getattr(rotor, self.of_rotor)
        return found


class MovedProbesEffect(PlacedEffect):
    """Probes stand elsewhere, or look in another direction; its one size is the change."""

    is_of_measurement: ClassVar[bool] = True
    is_scanned: ClassVar[bool] = False

    @property
    @abstractmethod
    def of_probes_at(self) -> ProbePlace:
        """The number of the probes that is another."""

    def of_probes(self, n_unknown: int) -> Mask:
        return np.ones(n_unknown, dtype=bool)

    def costly(self, n_unknown: int) -> Indices:
        return np.arange(n_unknown)

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        return with_moved_housing_probes(rotor, self._changes(theta)) if rotor.housing_probes else rotor

    def moved(self, looking: Sequence[Channel], channels: Sequence[Channel], theta: Array) -> tuple[Channel, ...]:
        return moved(looking, channels, self._changes(theta))

    def _changes(self, theta: Array) -> list[tuple[ProbePlace, float]]:
        return [(self.of_probes_at, float(theta[0]))]
