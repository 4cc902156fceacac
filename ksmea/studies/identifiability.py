"""Identifiability: precision of the unknowns from these and other data, before any are measured.

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
from ksmea.inference.cramer_rao import Identifiability, identifiability, joint_sensitivity
from ksmea.inference.input_budget import by_noise_and_inputs
from ksmea.inference.known_numbers import Numbers
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import OBSERVABLES
from ksmea.records.identifiability import (
    ALL_NUMBERS,
    DataDescription,
    Direction,
    IdentifiabilityRecord,
    Unknown,
    Value,
    Variation,
)
from ksmea.records.inputs import Origin
from ksmea.records.record import finite
from ksmea.settings.settings import Settings, setting
from ksmea.studies.design_point import DesignPoint
from ksmea.studies.inputs import origins
from ksmea.studies.stability import stability_of

VARIATIONS = ("speeds", "band", "position", "noise", "kind", "numbers")


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
        [1.5, 2.0], "factor by which the band is extended, in addition to its halves and quarters", above=1, at_most=10
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


def identifiability_study(point: DesignPoint, options: IdentifiabilityOptions | None = None) -> IdentifiabilityRecord:
    """CRLB of each unknown at a point from data on the problem's speeds and channels, and with other data.

    If the noise level is not known, the information that its estimate takes is subtracted.
    """
    options = options or IdentifiabilityOptions()
    problem, x = point.problem, point.x
    present = identifiability_of(point)
    return IdentifiabilityRecord(
        level=options.level,
        sigmas=NormalDist().inv_cdf((1 + options.level) / 2),
        data=_description(point),
        parameters=tuple(
            Unknown(
                *(item.name, item.unit, item.si_per_unit, float(value), item.lower, item.upper),
                *(finite(crlb), origin if np.isfinite(crlb) else None),
            )
            for item, value, crlb, origin in zip(problem.parameters, x, present.crlb, _origins(point))
        ),
        correlation=tuple(tuple(finite(entry) for entry in row) for row in present.correlation),
        stability=stability_of(
            problem, x, point.noise, point.kind, noise_known=point.noise_known, level=options.level, information=present
        ),
        worst_direction=Direction(tuple(present.worst_direction.tolist()), finite(present.worst_crlb)),
        variations=tuple(
            Variation(variation, value, tuple(finite(crlb) for crlb in identifiability_of(varied).crlb))
            for variation in VARIATIONS
            if variation in options.variations
            for value, varied in varied_data(variation, point, options)
        ),
        lack_of_fit=point.lack_of_fit,
        remarks=(*problem.remarks_at(problem.speed), *point.remarks),
        numbers=Numbers.of(problem).words,
    )


def identifiability_of(point: DesignPoint) -> Identifiability:
    """How well the data determine the unknowns."""
    return identifiability(
        point.problem,
        point.x,
        point.noise,
        point.kind,
        noise_known=point.noise_known,
        beside=point.joint_x,
        exact=point.exact,
    )


def _origins(point: DesignPoint) -> tuple[Origin | None, ...]:
    """Shares of noise and numbers in the CRLB of each unknown.

    None if all numbers of the problem are exact.
    """
    joint, names = point.problem.joint, point.problem.parameters.names
    if not Numbers.of(point.problem):
        return (None,) * len(names)
    parameters = joint.parameters
    whitened = joint_sensitivity(joint, point.joint_x, point.noise, point.kind, noise_known=point.noise_known)
    stated = parameters.priors[1] * parameters.width[parameters.with_prior]
    by_noise, by_input, _ = by_noise_and_inputs(whitened, len(parameters), parameters.with_prior, stated)
    return origins(parameters, [parameters.names.index(name) for name in names], by_noise, by_input)


def varied_data(
    variation: str, point: DesignPoint, options: IdentifiabilityOptions
) -> Iterator[tuple[Value, DesignPoint]]:
    """The values of one of `VARIATIONS`, each with the data as they would be."""
    if variation == "speeds":
        return _speeds(point, options.speed_factors)
    if variation == "band":
        return _band(point, options.top_factors)
    if variation == "position":
        return _position(point, options.n_position)
    if variation == "noise":
        return _noise(point, options.noise_factors)
    return _kind(point) if variation == "kind" else _numbers(point)


def _speeds(point: DesignPoint, factors: Sequence[float]) -> Iterator[tuple[Value, DesignPoint]]:
    """More or fewer speeds between the same ends, spaced as the present ones are."""
    speed = point.problem.speed
    n_step = len(speed) - 1
    for n_speed in sorted({max(1, round(factor * n_step)) + 1 for factor in factors} if n_step else ()):
        steps = np.linspace(0, n_step, n_speed)
        yield n_speed, _at(point, np.interp(steps, np.arange(n_step + 1), speed))


def _band(point: DesignPoint, top_factors: Sequence[float]) -> Iterator[tuple[Value, DesignPoint]]:
    """Variations with equally many, evenly spaced speeds.

    They are in halves and quarters of the band and up to higher speeds.
    """
    speed = point.problem.speed
    if len(speed) < 2:
        return
    low, width = speed[0], speed[-1] - speed[0]
    parts = [(0, 1), (0, 1 / 2), (1 / 2, 1), *((index / 4, (index + 1) / 4) for index in range(4))]
    bands = [(low + start * width, low + end * width) for start, end in parts]
    bands += [(low, factor * speed[-1]) for factor in top_factors]
    for start, end in bands:
        yield (float(start), float(end)), _at(point, np.linspace(start, end, len(speed)))


def _position(point: DesignPoint, n_position: int) -> Iterator[tuple[Value, DesignPoint]]:
    """One measuring plane in place of all present probes, at each of the problem's sites.

    It has the directions of the probes.
    """
    sites = point.problem.sites
    if len(sites) > n_position:
        sites = sites[np.linspace(0, len(sites) - 1, n_position).round().astype(int)]
    directions = dict.fromkeys(channel.direction for channel in point.problem.channels)
    for site in sites:
        channels = [Channel(float(site), direction) for direction in directions]
        yield float(site), _at(point, point.problem.speed, channels)


def _noise(point: DesignPoint, factors: Sequence[float]) -> Iterator[tuple[Value, DesignPoint]]:
    for factor in sorted(set(factors)):
        noise = point.noise.scaled(factor)
        yield factor, dataclasses.replace(point, noise=noise)


def _kind(point: DesignPoint) -> Iterator[tuple[Value, DesignPoint]]:
    for kind in OBSERVABLES:
        yield kind, dataclasses.replace(point, kind=kind)


def _numbers(point: DesignPoint) -> Iterator[tuple[Value, DesignPoint]]:
    """Each number that is known to a tolerance is exact, one at a time, then all of them."""
    numbers = Numbers.of(point.problem)
    for name, words in zip(numbers.names, numbers.words):
        yield words, dataclasses.replace(point, exact=(name,))
    if len(numbers) > 1:
        yield ALL_NUMBERS, dataclasses.replace(point, exact=numbers.names)


def _at(point: DesignPoint, speed: Array, channels: Sequence[Channel] | None = None) -> DesignPoint:
    return dataclasses.replace(point, problem=point.problem.at(speed, channels or point.problem.channels))


def _description(point: DesignPoint) -> DataDescription:
    speed = point.problem.speed
    return DataDescription(
        n_speed=len(speed),
        speed_from=float(speed[0]),
        speed_to=float(speed[-1]),
        channels=tuple(str(channel) for channel in point.problem.channels),
        positions=tuple(sorted({float(channel.position) for channel in point.problem.channels})),
        kind=point.kind,
        relative=float(point.noise.relative),
        floor=float(point.noise.floor),
        noise_known=point.noise_known,
    )
