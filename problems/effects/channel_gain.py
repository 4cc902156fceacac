"""Gain of one channel or of one plane other than assumed.

Y_j (1 + g), real and the same at all speeds.

A probe's scale factor depends on the shaft's material and the cable's length; API 670 lets an eddy-current probe err by
5 %. A factor of 2 or 25.4 is a unit: peak to peak for 0-peak, mil for µm. A gain that all channels have in common
cannot be distinguished from the size of the unbalance, and one of all x channels looks like anisotropic bearings: only
calibration separates these. One oscillator or one shaft material at a plane scales all of its channels.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import Channel, require_direction
from ksmea.settings.settings import setting
from problems.rotor.extension.effect import PlacedEffect, named, where
from problems.rotor.extension.sizes import Size
from problems.rotor.inputs.probe_places import ProbePlace, scaled
from problems.rotor.response.problem import RotorProblem

LIMITS = (-0.98, 30.0)  # of g: from 1/50, so that mil for µm (1/25.4, 25.4) and peak to peak for 0-peak (2) lie within
NOTICED = (0.08, 0.25)  # of either sign, are drawn


@dataclass(frozen=True)
class ChannelGain(PlacedEffect):
    """One channel, or all of a plane, read too much or too little."""

    position: float | None = setting(None, "position of the channel; null: all positions", unit="m", at_least=0)
    direction: str | None = setting(None, "the channel's direction: x, y or degrees; null: all")

    is_scanned: ClassVar[bool] = False
    says = "The reading of {place:probes} is {channel_gain:too high|too low}"
    is_of_measurement = True
    check_next = (
        "Calibrate probe, cable and monitor of this channel: a scale factor that is off by this much confirms it."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "probe_position": "both scale what the plane reads; measure the position of the probes, or calibrate them",
    }
    stage: ClassVar[int] = 2

    what = "channel"
    sizes = (Size("channel_gain", "%", LIMITS, drawn=NOTICED),)

    def check(self) -> None:
        if self.direction is not None:
            require_direction(self.direction)

    def __str__(self) -> str:
        return f"{named(self.direction)} {where(self.position)}"

    def locations(self, problem: RotorProblem) -> Sequence[ChannelGain]:
        """Each channel; on a machine as drawn also each plane of several channels, if others exist."""
        channels = dict.fromkeys(channel for channel in problem.channels if channel.is_1x)
        if len(channels) < 2:
            return []
        each = [dataclasses.replace(self, position=item.position, direction=item.direction) for item in channels]
        if not problem.is_as_drawn:
            return each
        of_plane = Counter(channel.position for channel in channels)
        whole = [position for position, count in of_plane.items() if 1 < count < len(channels)]
        return [*each, *(dataclasses.replace(self, position=position, direction=None) for position in whole)]

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        return scaled(response, channels, [(ProbePlace("gain", self.position, self.direction), theta[:, 0])])
