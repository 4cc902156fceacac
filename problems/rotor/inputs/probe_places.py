"""Places of numbers among probes, and what probes look at and read with other numbers there.

>>> ProbePlace("gain", 0.5, "x")  # of one probe
ProbePlace(reading='gain', position=0.5, direction='x')
>>> ProbePlace("position", 0.5)  # of all probes of a plane
ProbePlace(reading='position', position=0.5, direction=None)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import Channel, direction_at
from ksmea.units import DEGREE
from problems.rotor.finite_elements.data import HousingProbe, Rotor

READINGS = ("position", "direction", "gain")
MAX_KEPT = 512  # channels elsewhere: of one number after the other, all others are as they were


@dataclass(frozen=True)
class ProbePlace:
    """One number of probes: `position` (m), `direction` (rad from x towards y) or `gain`.

    It is of the probes at one position and in one direction; None: of all.
    """

    reading: str
    position: float | None = None  # m
    direction: str | None = None

    def reads(self, channel: Channel) -> bool:
        return channel.is_at(self.position, self.direction)


def moved(
    looking: Sequence[Channel], channels: Sequence[Channel], changes: Sequence[tuple[ProbePlace, float]]
) -> tuple[Channel, ...]:
    """Probes with changes of their positions and directions.

    Args:
        looking: channels without these changes.
        channels: channels as the measurement states them, by which places are found.
        changes: places with changes, SI.
    """
    return tuple(
        _moved(seen, _change_of("position", stated, changes), _change_of("direction", stated, changes))
        for seen, stated in zip(looking, channels, strict=True)
    )


def _change_of(reading: str, channel: Channel, changes: Sequence[tuple[ProbePlace, float]]) -> float:
    own = (change for place, change in changes if change and place.reading == reading and place.reads(channel))
    return sum(own, start=0.0)


@lru_cache(maxsize=MAX_KEPT)
def _moved(channel: Channel, along: float, turned: float) -> Channel:
    """A channel further along the shaft by so much (m), and turned from x towards y (rad)."""
    if along:
        channel = replace(channel, position=channel.position + along)
    return replace(channel, direction=direction_at(channel.angle + turned / DEGREE)) if turned else channel


def with_moved_housing_probes(rotor: Rotor, changes: Sequence[tuple[ProbePlace, float]]) -> Rotor:
    """The rotor with probes that its housings carry where changes (SI) move them."""
    return replace(rotor, housing_probes=tuple(_carried(probe, changes) for probe in rotor.housing_probes))


def _carried(probe: HousingProbe, changes: Sequence[tuple[ProbePlace, float]]) -> HousingProbe:
    stated = [Channel(probe.position, probe.direction or "x")]
    [seen] = moved(stated, stated, changes)
    return replace(probe, position=seen.position, direction=probe.direction and seen.direction)


def scaled(
    response: ComplexArray, channels: Sequence[Channel], changes: Sequence[tuple[ProbePlace, Array]]
) -> ComplexArray:
    """Readings (n, n_speed, n_channel) with changes (n,) of gains that are 1.

    Several gains of one probe multiply.
    """
    gain = np.ones((len(response), len(channels)))
    for place, change in changes:
        gain[:, [place.reads(channel) for channel in channels]] *= 1 + change[:, None]
    return response * gain[:, None]
