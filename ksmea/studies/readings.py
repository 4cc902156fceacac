"""Ways in which measured data are easily misread: lag given as lead, probes reversed or swapped, other units."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ksmea.channel import ANGLES, DIRECTIONS, direction_at
from ksmea.measurement import Measurement
from ksmea.units import HERTZ, INCH, MICROMETRE, RPM

MIL = INCH / 1000  # m
MAX_CHANNELS = 8  # of more, each alone is not taken for reversed: that would be many readings

AMPLITUDES = {  # how they were given, and what they must be multiplied by
    "amplitudes are in mil where µm are expected": MIL / MICROMETRE,
    "amplitudes are in mil peak to peak where µm 0-peak are expected": MIL / MICROMETRE / 2,
    "amplitudes were converted from mil though they were in µm": MICROMETRE / MIL,
    "amplitudes are peak to peak where 0-peak is expected": 1 / 2,
    "amplitudes were halved though they were 0-peak": 2.0,
    "amplitudes are rms where 0-peak is expected": np.sqrt(2),
    "amplitudes were converted from rms though they were 0-peak": np.sqrt(1 / 2),
}
SPEEDS = {
    "speeds are in Hz where rpm are expected": HERTZ / RPM,
    "speeds are in rad/s where rpm are expected": 1 / RPM,
    "speeds are in Hz where rad/s are expected": HERTZ,
    "speeds are in rpm where rad/s are expected": RPM,
}


@dataclass(frozen=True)
class Reading:
    """Data read in another way: how they were given, in one respect or two, what mends each, and the data read so."""

    given: tuple[str, ...]
    remedies: tuple[str, ...]
    measurement: Measurement


def readings(measurement: Measurement) -> Iterator[Reading]:
    """The data, whose noise must not be known, read in each other way."""
    if not measurement.is_amplitude:
        yield _lag(measurement)
        yield from _reversed(measurement)
    across = tuple(
        dataclasses.replace(item, direction=direction_at(ANGLES["y"] - item.angle)) for item in measurement.channels
    )
    yield Reading(
        ("x and y are swapped, or the shaft turns from y to x",),
        ("exchange x and y (direction)",),
        dataclasses.replace(measurement, channels=across),
    )
    yield from _in_other_units(measurement)


def double_readings(measurement: Measurement) -> Iterator[Reading]:
    """Two ways at once: many instruments show a lag, in units of their own."""
    if not measurement.is_amplitude:
        lag = _lag(measurement)
        for other in _in_other_units(lag.measurement):
            yield Reading(lag.given + other.given, lag.remedies + other.remedies, other.measurement)


def _lag(measurement: Measurement) -> Reading:
    return Reading(
        ("phases are lags where leads are expected",),
        ("change the sign of all phases (phase_lead_deg)",),
        dataclasses.replace(measurement, values=np.conj(measurement.values)),
    )


def _reversed(measurement: Measurement) -> Iterator[Reading]:
    """Probes that measure in the opposite direction: each one, or all of x or of y. Where nobody knows where phases begin,
    the others reversed are the same."""
    channels = measurement.channels
    everyone = frozenset(range(len(channels)))
    single = [frozenset({index}) for index in everyone] if len(everyone) <= MAX_CHANNELS else []
    directions = sorted({channel.direction for channel in channels}, key=lambda name: (name not in DIRECTIONS, name))
    by_direction = [frozenset(i for i in everyone if channels[i].direction == name) for name in directions]
    done = {frozenset[int](), everyone} if not measurement.phase_known else {frozenset[int]()}
    for group in chain(single, by_direction):
        if group in done:
            continue
        same = [group] if measurement.phase_known else [group, everyone - group]
        done.update(same)
        fewest = min(map(len, same))
        probes = [", ".join(str(channels[i]) for i in sorted(each)) for each in same if len(each) == fewest]
        sign = np.where([index in group for index in range(len(channels))], -1.0, 1.0)
        yield Reading(
            (f"the phases of {' or else of '.join(probes)} are turned by 180°",),
            ("add 180° to these (phase_lead_deg)",),
            dataclasses.replace(measurement, values=sign * measurement.values),
        )


def _in_other_units(measurement: Measurement) -> Iterator[Reading]:
    for given, factor in AMPLITUDES.items():
        yield Reading(
            (f"{given} (× {factor:.4g})",),
            ("multiply amplitude_um_0pk and sigma_um by that, unless it is the model's unbalance that is wrong",),
            dataclasses.replace(measurement, values=factor * measurement.values),
        )
    for given, factor in SPEEDS.items():
        yield Reading(
            (f"{given} (× {factor:.4g})",),
            ("multiply speed_rpm by that",),
            dataclasses.replace(measurement, speed=factor * measurement.speed),
        )
