"""Base of effects in which one part of a rotor, a disk or a bearing, is other than a drawing says."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, Generic, TypeVar

from ksmea.arrays import Array
from problems.rotor.extension.effect import SeatedEffect, is_near, places_of
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.response.problem import RotorProblem

Part = TypeVar("Part", Disk, Bearing)


class PartEffect(SeatedEffect, Generic[Part]):
    """One of the disks or bearings is other than drawn; rotors that are not of a file have no drawing."""

    of_rotor: ClassVar[str]  # the field of a rotor that has the parts: disks or bearings
    is_scanned: ClassVar[bool] = False
    for_drawings_only: ClassVar[bool] = True

    @abstractmethod
    def changed(self, part: Part, size: float) -> Part:
        """The part with the effect of a size, SI."""

    def has(self, part: Part) -> bool:
        """Whether a part can have the effect."""
        return True

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        return places_of((part for part in self._all(problem.rotor) if self.has(part)), problem.rotor)

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        size = float(theta[0])
        parts = (self.changed(each, size) if is_near(each.position, self.place) else each for each in self._all(rotor))
        replaced: dict[str, Any] = {self.of_rotor: tuple(parts)}
        return dataclasses.replace(rotor, **replaced)

    def _all(self, rotor: Rotor) -> Sequence[Part]:
        found: Sequence[Part] = getattr(rotor, self.of_rotor)
        return found
