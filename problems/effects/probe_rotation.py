"""Probes at one plane that stand at other angles than assumed.

Both turned by θ from x to y, or one of them.

y_x' = cos θ y_x + sin θ y_y, y_y' = −sin θ y_x + cos θ y_y, the same at all speeds and alike for probes at other angles. On a circular orbit it is only a phase;
an ellipse turns (Bently & Hatch, Fundamentals of Rotating Machinery Diagnostics, 2002, for probes and their angles).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ksmea.measurement.channel import Channel, require_direction
from ksmea.plugins.effect import SizeRecord, StatementRecord
from ksmea.settings.settings import setting
from ksmea.units import DEGREE
from problems.rotor.extension.effect import named, planes, where
from problems.rotor.extension.sizes import Size
from problems.rotor.inputs.number_effect import MovedProbesEffect
from problems.rotor.inputs.probe_places import ProbePlace
from problems.rotor.response.problem import RotorProblem

LARGEST = 20 * DEGREE
NOTICED = (1 * DEGREE, 15 * DEGREE)  # of either sign, are drawn


@dataclass(frozen=True)
class ProbeRotation(MovedProbesEffect):
    """The x and y probes of one plane are both turned, or one of them."""

    position: float | None = setting(None, "the measuring plane; null: all of them alike", unit="m", at_least=0)
    direction: str | None = setting(None, "of the probe that is turned: x, y or degrees; null: all")

    words = "probe angle"
    check_next = (
        "Measure the mounting angle of these probes, and check the order of their cables: this angle confirms it."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "cross_coupling_symmetric": "both turn the ellipse; survey the angles of the probes",
    }
    what = "probes"
    sizes = (Size("probe_rotation", "deg", LARGEST, drawn=NOTICED),)

    def check(self) -> None:
        if self.direction is not None:
            require_direction(self.direction)

    def __str__(self) -> str:
        return where(self.position) if self.direction is None else f"{named(self.direction)} {where(self.position)}"

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        verb = "are" if self.direction is None else "is"
        sentence = f"{{place:probes}} {verb} turned by {{probe_rotation:from x towards y|from y towards x}}"
        return dataclasses.replace(super().statement(sizes), sentence=sentence)

    def locations(self, problem: RotorProblem) -> Sequence[ProbeRotation]:
        """Each plane with probes in two directions, then each probe of a machine as drawn.

        The latter only if there are others to compare it with.
        """
        whole = self.at_each(plane for plane in planes(problem) if _has_two(plane, problem.channels))
        channels = dict.fromkeys(channel for channel in problem.channels if channel.is_1x)
        if len(channels) < 2 or not problem.is_as_drawn:
            return whole
        each = (dataclasses.replace(self, position=item.position, direction=item.direction) for item in channels)
        return [*whole, *each]

    @property
    def of_probes_at(self) -> ProbePlace:
        return ProbePlace("direction", self.position, self.direction)


def _has_two(plane: float, channels: Sequence[Channel]) -> bool:
    there = [channel for channel in channels if channel.position == plane]
    return any(not channel.is_parallel_to(there[0]) for channel in there)
