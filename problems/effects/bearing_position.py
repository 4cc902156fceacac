"""A bearing that holds the shaft elsewhere than assumed: its forces act beside the node of the model.

The centre of pressure of a journal bearing lies in its middle only where it is aligned; one that bears at an edge holds the shaft by
half its width nearer to that edge.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ksmea.arrays import Array
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import SeatedEffect, is_near, shaft_length
from problems.rotor.extension.sizes import Size
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.02  # of the shaft's length, to either side
NOTICED = (0.002, 0.015)  # of the shaft's length, to either side, are drawn


@dataclass(frozen=True)
class BearingPosition(SeatedEffect):
    """A bearing holds the shaft elsewhere."""

    position: float | None = setting(None, "where the model has it; null: the first bearing", unit="m", at_least=0)

    is_scanned: ClassVar[bool] = False
    aliases: ClassVar[Mapping[str, str]] = {
        "unequal_bearings": "both change the share of each bearing; measure the width over which it carries",
    }
    what, default_place, needs = "bearing", "the first bearing", "a rotor with a bearing"
    sizes = (Size("bearing_position_change", "mm", LARGEST, drawn=NOTICED, of=shaft_length),)

    def is_offered(self, problem: RotorProblem) -> bool:
        return problem.is_as_drawn

    def seats(self, problem: RotorProblem) -> Sequence[float]:
        return list(dict.fromkeys(bearing.position for bearing in problem.rotor.bearings))

    def rotor(self, rotor: Rotor, theta: Array) -> Rotor:
        bearings = tuple(
            dataclasses.replace(each, offset=each.offset + float(theta[0]))
            if is_near(each.position, self.place)
            else each
            for each in rotor.bearings
        )
        return dataclasses.replace(rotor, bearings=bearings)
