"""Identifiability: how well data would determine the unknowns, and how well other data would, before any is measured.

Everything is the Cramér–Rao lower bound (CRLB) at the true values (`ksmea.inference.cramer_rao`), 1 σ; nothing is random.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import unknown
from ksmea.inference.cramer_rao import Identifiability, identifiability
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import OBSERVABLES
from ksmea.measurement.noise import Noise
from ksmea.problem.problem import Problem
from ksmea.records.identifiability import (
    DataDescription,
    Direction,
    IdentifiabilityRecord,
    Unknown,
    Value,
    Variation,
)
from ksmea.records.record import finite
from ksmea.settings.settings import Settings, setting
from ksmea.studies.design_point import DesignPoint
from ksmea.studies.stability import stability_of

VARIATIONS = ("speeds", "band", "position", "noise", "kind")


@dataclass(frozen=True)
class IdentifiabilityOptions(Settings):
    """How wide the intervals are that are printed, and what is varied."""

    level: float = setting(0.95, "probability of the intervals that are printed", above=0, at_most=0.9999)
    variations: list[str] = setting(
        list(VARIATIONS), f"what is varied, one thing at a time: any of {', '.join(VARIATIONS)}; []: nothing"
    )
    speed_factors: list[float] = setting(
        [0.25, 0.5, 1.0, 2.0, 4.0], "how many times as many steps there are between the speeds", above=0, at_most=100
    )
    top_factors: list[float] = setting(
        [1.5, 2.0], "how many times as high the band reaches, beside its halves and quarters", above=1, at_most=10
    )
    noise_factors: list[float] = setting(
        [0.1, 0.2, 0.5, 1.0, 2.0, 3.0], "how many times as much noise there is, both parts of it", above=0
    )
    n_position: int = setting(
        15, "largest number of positions of one measuring plane, out of the problem's sites", at_least=1
    )

    def check(self) -> None:
        for name in self.variations:
            if name not in VARIATIONS:
                raise unknown("entry of variations:", str(name), VARIATIONS)


@dataclass(frozen=True)
class Data:
    """Data that could be measured: on a problem's speeds and channels, of a kind, with noise."""

    problem: Problem
    noise: Noise
    kind: str
    noise_known: bool = True


def identifiability_study(point: DesignPoint, options: IdentifiabilityOptions | None = None) -> IdentifiabilityRecord:
    """The CRLB of each unknown at a point from data on the problem's speeds and channels, and how it changes with the data.

    Where the noise's level is not known, what it takes to estimate it is taken off.
    """
    options = options or IdentifiabilityOptions()
    problem, x = point.problem, point.x
    data = Data(problem, point.noise, point.kind, point.noise_known)
    present = identifiability_of(data, x)
    return IdentifiabilityRecord(
        level=options.level,
        sigmas=NormalDist().inv_cdf((1 + options.level) / 2),
        data=_description(data),
        parameters=tuple(
            Unknown(
                parameter.name,
                parameter.unit,
                parameter.si_per_unit,
                float(value),
                parameter.lower,
                parameter.upper,
                finite(crlb),
            )
            for parameter, value, crlb in zip(problem.parameters, x, present.crlb)
        ),
        correlation=tuple(tuple(finite(entry) for entry in row) for row in present.correlation),
        stability=stability_of(
            problem, x, point.noise, point.kind, noise_known=point.noise_known, level=options.level, information=present
        ),
        worst_direction=Direction(tuple(present.worst_direction.tolist()), finite(present.worst_crlb)),
        variations=tuple(
            Variation(variation, value, tuple(finite(crlb) for crlb in identifiability_of(varied, x).crlb))
            for variation in VARIATIONS
            if variation in options.variations
            for value, varied in varied_data(variation, data, options)
        ),
        lack_of_fit=point.lack_of_fit,
        remarks=point.remarks,
    )


def identifiability_of(data: Data, x: Array) -> Identifiability:
    """How well the data determine the unknowns at x (d,), SI."""
    return identifiability(data.problem, x, data.noise, data.kind, noise_known=data.noise_known)


def varied_data(variation: str, data: Data, options: IdentifiabilityOptions) -> Iterator[tuple[Value, Data]]:
    """The values of one of `VARIATIONS`, each with the data as they would be."""
    if variation == "speeds":
        return _speeds(data, options.speed_factors)
    if variation == "band":
        return _band(data, options.top_factors)
    if variation == "position":
        return _position(data, options.n_position)
    if variation == "noise":
        return _noise(data, options.noise_factors)
    return _kind(data)


def _speeds(data: Data, factors: Sequence[float]) -> Iterator[tuple[Value, Data]]:
    """More or fewer speeds between the same ends, spaced as the present ones are."""
    speed = data.problem.speed
    n_step = len(speed) - 1
    for n_speed in sorted({max(1, round(factor * n_step)) + 1 for factor in factors} if n_step else ()):
        steps = np.linspace(0, n_step, n_speed)
        yield n_speed, _at(data, np.interp(steps, np.arange(n_step + 1), speed))


def _band(data: Data, top_factors: Sequence[float]) -> Iterator[tuple[Value, Data]]:
    """As many speeds, evenly spaced, in halves and quarters of the band and up to higher speeds."""
    speed = data.problem.speed
    if len(speed) < 2:
        return
    low, width = speed[0], speed[-1] - speed[0]
    parts = [(0, 1), (0, 1 / 2), (1 / 2, 1), *((index / 4, (index + 1) / 4) for index in range(4))]
    bands = [(low + start * width, low + end * width) for start, end in parts]
    bands += [(low, factor * speed[-1]) for factor in top_factors]
    for start, end in bands:
        yield (float(start), float(end)), _at(data, np.linspace(start, end, len(speed)))


def _position(data: Data, n_position: int) -> Iterator[tuple[Value, Data]]:
    """One measuring plane instead of all present probes, in the same directions, at each of the problem's sites."""
    sites = data.problem.sites
    if len(sites) > n_position:
        sites = sites[np.linspace(0, len(sites) - 1, n_position).round().astype(int)]
    directions = dict.fromkeys(channel.direction for channel in data.problem.channels)
    for site in sites:
        channels = [Channel(float(site), direction) for direction in directions]
        yield float(site), _at(data, data.problem.speed, channels)


def _noise(data: Data, factors: Sequence[float]) -> Iterator[tuple[Value, Data]]:
    for factor in sorted(set(factors)):
        noise = data.noise.scaled(factor)
        yield factor, dataclasses.replace(data, noise=noise)


def _kind(data: Data) -> Iterator[tuple[Value, Data]]:
    for kind in OBSERVABLES:
        yield kind, dataclasses.replace(data, kind=kind)


def _at(data: Data, speed: Array, channels: Sequence[Channel] | None = None) -> Data:
    return dataclasses.replace(data, problem=data.problem.at(speed, channels or data.problem.channels))


def _description(data: Data) -> DataDescription:
    speed = data.problem.speed
    return DataDescription(
        n_speed=len(speed),
        speed_from=float(speed[0]),
        speed_to=float(speed[-1]),
        channels=tuple(str(channel) for channel in data.problem.channels),
        positions=tuple(sorted({float(channel.position) for channel in data.problem.channels})),
        kind=data.kind,
        relative=float(data.noise.relative),
        floor=float(data.noise.floor),
        noise_known=data.noise_known,
    )
