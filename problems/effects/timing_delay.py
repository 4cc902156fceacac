"""Timing delay: readings come later by τ than the mark on the shaft, y → y e^{−iΩτ}.

Their phase counts from this mark.

A filter of the signal, a multiplexer that reads one channel after the other, or the edge of a wide mark delays by a time, not by
an angle: the phase lags in proportion to speed, and amplitudes stay. A negative τ is a delay of the mark itself. Where all
channels are late alike, phases whose origin is not known take up the mean lag, so that a wide band is needed. Amplitudes do
not show it at all (D. E. Bently & C. T. Hatch, Fundamentals of Rotating Machinery Diagnostics, 2002, chapters 2 and 3; API 670 for
the response of monitors over frequency).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import Channel, require_direction
from ksmea.measurement.measurement import Measurement
from ksmea.settings.settings import setting
from ksmea.units import MICROSECOND
from problems.rotor.extension.effect import PlacedEffect, named, where
from problems.rotor.extension.sizes import Size
from problems.rotor.response.problem import RotorProblem

LARGEST = 500 * MICROSECOND  # 9° at 3000 rpm: a filter at some hundred Hz
NOTICED = (10 * MICROSECOND, 300 * MICROSECOND)  # of either sign, are drawn


@dataclass(frozen=True)
class TimingDelay(PlacedEffect):
    """Readings are late by a constant time."""

    position: float | None = setting(None, "position of the late channel; null: all positions", unit="m", at_least=0)
    direction: str | None = setting(None, "the late channel's direction: x, y or degrees; null: all")

    is_scanned: ClassVar[bool] = False
    says = "The reading of {place:probes} comes {timing_delay:late|early}"
    is_of_measurement = True
    check_next = (
        "Feed one signal into all channels: a delay of this size confirms it; then check filters and phase mark."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_damping": "both change how the phase goes with speed; a wider band, a square wave into all channels",
        "run_up_acceleration": "both make the phase late; a slower run-up, a coast-down",
    }
    stage: ClassVar[int] = 2

    what = "channel"
    sizes = (Size("timing_delay", "µs", LARGEST, drawn=NOTICED),)

    def check(self) -> None:
        if self.direction is not None:
            require_direction(self.direction)

    def __str__(self) -> str:
        if self.position is None and self.direction is None:
            return "all channels"
        return f"{named(self.direction)} {where(self.position)}"

    def seen_in(self, measurement: Measurement) -> TimingDelay | None:
        """None of amplitudes."""
        return None if measurement.is_amplitude else self

    def locations(self, problem: RotorProblem) -> Sequence[TimingDelay]:
        """All channels, and each by itself where there is another."""
        channels = dict.fromkeys(channel for channel in problem.channels if channel.is_1x)
        each = [dataclasses.replace(self, position=item.position, direction=item.direction) for item in channels]
        return [self, *each] if len(each) > 1 else [self]

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        late = np.array([channel.is_at(self.position, self.direction) * channel.harmonic for channel in channels])
        return response * np.exp(-1j * speed[:, None] * theta[:, 0, None, None] * late)
