"""Identifiability: what these data would tell about the unknowns, and what other data would, before anything is measured.

Everything is the Cramér–Rao bound at the true values (`ksmea.identifiability`), 1 σ; nothing is random.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, ClassVar

import numpy as np

from bench.plan.draw import Draw
from bench.plan.setup import Setup
from bench.plan.study import Study
from ksmea.arrays import Array
from ksmea.channel import Channel
from ksmea.contracts import Problem
from ksmea.errors import SettingError, unknown
from ksmea.identifiability import Identifiability, identifiability
from ksmea.measurement import KINDS, Noise
from ksmea.records.record import finite
from ksmea.settings import setting

VARIATIONS = ("speeds", "band", "position", "noise", "kind")


@dataclass(frozen=True)
class Data:
    """Data that could be measured: on a problem's speeds and channels, of a kind, with noise."""

    problem: Problem
    noise: Noise
    kind: str
    noise_known: bool


@dataclass(frozen=True)
class IdentifiabilityStudy(Study):
    """How well the unknowns can be known from such data, by the Cramér–Rao bound, and how other data would change that."""

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
        15, "most positions of one measuring plane that are tried, out of the problem's sites", at_least=1
    )

    report: ClassVar[str] = "identifiability"
    ignores: ClassVar[tuple[str, ...]] = ("samples", "surrogate", "optimizer", "method")

    def check(self) -> None:
        for name in self.variations:
            if name not in VARIATIONS:
                raise unknown("entry of variations:", str(name), VARIATIONS)

    def validate(self, setup: Setup) -> None:
        setup.require_truth("study=identifiability")
        noise = setup.plugins["measurement"].noise
        if noise is None or noise.is_absent:
            raise SettingError(
                "study=identifiability: expected noise, without which everything is known exactly; say"
                " measurement.relative=0.1 or measurement.floor=0.5 (µm)"
            )

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        measurement, parameters, x = setup.plugins["measurement"], setup.problem.parameters, setup.true_x
        data = Data(setup.problem, measurement.noise, measurement.kind, measurement.noise_known)
        told = told_by(data, x)
        return {
            "status": "done",
            "level": self.level,
            "sigmas": NormalDist().inv_cdf((1 + self.level) / 2),
            "data": _description(data),
            "parameters": [
                {
                    "name": parameter.name,
                    "unit": parameter.unit,
                    "si_per_unit": parameter.si_per_unit,
                    "true": float(value),
                    "lower": parameter.lower,
                    "upper": parameter.upper,
                    "bound": finite(bound),
                }
                for parameter, value, bound in zip(parameters, x, told.crlb)
            ],
            "correlation": [[finite(entry) for entry in row] for row in told.correlation],
            "least_told": {"direction": told.worst_direction.tolist(), "bound": finite(told.worst_crlb)},
            "variations": [
                {"variation": variation, **place, "bound": [finite(bound) for bound in told_by(varied, x).crlb]}
                for variation in VARIATIONS
                if variation in self.variations
                for place, varied in getattr(self, f"_{variation}")(data)
            ],
        }

    def _speeds(self, data: Data) -> Iterator[tuple[dict[str, Any], Data]]:
        """More or fewer speeds between the same ends, spaced as the present ones are."""
        speed = data.problem.speed
        n_step = len(speed) - 1
        for n_speed in sorted({max(1, round(factor * n_step)) + 1 for factor in self.speed_factors} if n_step else ()):
            places = np.linspace(0, n_step, n_speed)
            yield {"value": n_speed}, _at(data, np.interp(places, np.arange(n_step + 1), speed))

    def _band(self, data: Data) -> Iterator[tuple[dict[str, Any], Data]]:
        """As many speeds, evenly spaced, in halves and quarters of the band and up to higher speeds."""
        speed = data.problem.speed
        if len(speed) < 2:
            return
        low, width = speed[0], speed[-1] - speed[0]
        parts = [(0, 1), (0, 1 / 2), (1 / 2, 1), *((index / 4, (index + 1) / 4) for index in range(4))]
        bands = [(low + start * width, low + end * width) for start, end in parts]
        bands += [(low, factor * speed[-1]) for factor in self.top_factors]
        for start, end in bands:
            yield {"value": [float(start), float(end)]}, _at(data, np.linspace(start, end, len(speed)))

    def _position(self, data: Data) -> Iterator[tuple[dict[str, Any], Data]]:
        """One measuring plane in place of all present probes, in the same directions, at each of the problem's sites."""
        sites = data.problem.sites
        if len(sites) > self.n_position:
            sites = sites[np.linspace(0, len(sites) - 1, self.n_position).round().astype(int)]
        directions = dict.fromkeys(channel.direction for channel in data.problem.channels)
        for site in sites:
            channels = [Channel(float(site), direction) for direction in directions]
            yield {"value": float(site)}, _at(data, data.problem.speed, channels)

    def _noise(self, data: Data) -> Iterator[tuple[dict[str, Any], Data]]:
        for factor in sorted(set(self.noise_factors)):
            noise = Noise(factor * data.noise.relative, factor * data.noise.floor)
            yield {"value": factor}, dataclasses.replace(data, noise=noise)

    def _kind(self, data: Data) -> Iterator[tuple[dict[str, Any], Data]]:
        for kind in KINDS:
            yield {"value": kind}, dataclasses.replace(data, kind=kind)


def told_by(data: Data, x: Array) -> Identifiability:
    """What the data tell of the unknowns at x (d,), SI."""
    return identifiability(data.problem, x, data.noise, data.kind, noise_known=data.noise_known)


def _at(data: Data, speed: Array, channels: Sequence[Channel] | None = None) -> Data:
    return dataclasses.replace(data, problem=data.problem.at(speed, channels or data.problem.channels))


def _description(data: Data) -> dict[str, Any]:
    speed = data.problem.speed
    return {
        "n_speed": len(speed),
        "speed_from": float(speed[0]),
        "speed_to": float(speed[-1]),
        "channels": [str(channel) for channel in data.problem.channels],
        "positions": sorted({float(channel.position) for channel in data.problem.channels}),
        "kind": data.kind,
        "relative": data.noise.relative,
        "floor": data.noise.floor,
        "noise_known": data.noise_known,
    }
