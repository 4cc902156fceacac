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

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import Channel, direction_at, require_direction
from ksmea.plugins.effect import SizeRecord, StatementRecord
from ksmea.settings.settings import setting
from ksmea.units import DEGREE
from problems.rotor.extension.effect import PlacedEffect, is_at, named, planes, where
from problems.rotor.extension.sizes import Size
from problems.rotor.response.problem import RotorProblem

RIGHT_ANGLE = 90.0  # degrees
LARGEST = 20 * DEGREE
NOTICED = (1 * DEGREE, 15 * DEGREE)  # of either sign, are drawn


@dataclass(frozen=True)
class ProbeRotation(PlacedEffect):
    """The x and y probes of one plane are both turned, or one of them."""

    position: float | None = setting(None, "the measuring plane; null: all of them alike", unit="m", at_least=0)
    direction: str | None = setting(None, "of the probe that is turned: x, y or degrees; null: all")

    is_scanned: ClassVar[bool] = False
    words = "probe angle"
    is_of_measurement = True
    check_next = (
        "Measure the mounting angle of these probes, and check the order of their cables: this angle confirms it."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "cross_coupling_symmetric": "both turn the ellipse; survey the angles of the probes",
    }
    stage: ClassVar[int] = 1

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

    def needed_channels(self, channels: Sequence[Channel]) -> Sequence[Channel]:
        return [_partner(channel) for channel in channels if self._turns(channel)]

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        cosine, sine = np.cos(theta), np.sin(theta)  # (n, 1), over speed
        turned = response.copy()
        for index, channel in enumerate(channels):
            if self._turns(channel):
                other = response[..., channels.index(_partner(channel))]
                turned[..., index] = cosine * response[..., index] + _sense(channel) * sine * other
        return turned

    def _turns(self, channel: Channel) -> bool:
        return is_at(channel, self.position) and self.direction in (None, channel.direction)


def _partner(channel: Channel) -> Channel:
    """The channel at right angles to one: of x it is y, and of y it is x."""
    return dataclasses.replace(channel, direction=direction_at(channel.angle + _sense(channel) * RIGHT_ANGLE))


def _sense(channel: Channel) -> int:
    """Whether its partner is a quarter of a turn ahead of it or behind."""
    return 1 if channel.angle % (2 * RIGHT_ANGLE) < RIGHT_ANGLE else -1


def _has_two(plane: float, channels: Sequence[Channel]) -> bool:
    there = [channel for channel in channels if channel.position == plane]
    return any(not channel.is_parallel_to(there[0]) for channel in there)
