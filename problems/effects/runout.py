"""Runout: the surface under the probes is not concentric.

The probes read a displacement although the shaft does not move.

A constant forward vector r is added to the readings of one measuring plane: y_x += r, y_y += −i r, and e^{−iθ} r to the
reading of a probe at θ. A surface that is not round, or magnetised unevenly, gives each probe a vector of its own (slow
roll): y_j += a_j + i b_j for each probe of a plane, or of all planes. One circle is the special case in which all
probes of a plane trace one eccentric surface (API 684, slow-roll vector; Bently & Hatch, Fundamentals of Rotating
Machinery Diagnostics, 2002, chapter 7).
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.plugins.effect import SizeRecord, StatementRecord
from ksmea.problem.parameters import Parameter, name_at
from ksmea.settings.settings import setting
from ksmea.units import MICROMETRE
from problems.rotor.extension.effect import (
    PlacedEffect,
    forward_vector,
    planes,
    where,
)
from problems.rotor.extension.sizes import VectorSize
from problems.rotor.response.problem import RotorProblem

LARGEST = 50 * MICROMETRE  # ten times what API 670 lets pass
NOTICED = (0.3 * MICROMETRE, 15 * MICROMETRE)  # vectors as long as these are drawn
PARTS = ("x", "y")  # of a vector a + ib = A (cos φ + i sin φ), φ its phase lead


@dataclass(frozen=True)
class Runout(PlacedEffect):
    """Probes read a constant vector in addition to the motion.

    One circle of a plane, or a vector for each probe.
    """

    position: float | None = setting(None, "the measuring plane; null: all of them alike", unit="m", at_least=0)
    probes: list[str] = setting(
        [], "probes with a vector each, as direction@position (m), such as x@0.05; empty: one circle at the plane"
    )

    adds_readings: ClassVar[bool] = True
    says = "Runout of {runout:reading}, seen by {place:probes}"
    is_of_measurement = True
    check_next = "Record a slow-roll vector of these probes: this length and angle confirm it."
    aliases: ClassVar[Mapping[str, str]] = {
        "residual_bow": "a bow is amplified at a critical speed, runout is not: measure through one, or a second plane",
    }

    what = "runout"
    sizes = (VectorSize("runout", "µm", LARGEST, drawn=NOTICED),)

    def check(self) -> None:
        if len(set(self._channels)) < len(self.probes):
            raise SettingError(f"probes: expected each probe once, got {', '.join(self.probes)}")

    def __str__(self) -> str:
        if not self.probes:
            return where(self.position)
        planes_of = dict.fromkeys(channel.position for channel in self._channels)
        at = ", ".join(f"{position:g}" for position in planes_of)
        if Counter(channel.position for channel in self._channels).most_common(1)[0][1] == 1:
            return ", ".join(map(str, self._channels))
        return f"each probe at {at} m"

    @property
    def _channels(self) -> list[Channel]:
        return [_probe(text) for text in self.probes]

    def places(self, problem: RotorProblem) -> Sequence[float]:
        """The plane whose readings it changes; none of several, as a location is at one."""
        if not self.probes:
            return super().places(problem)
        found = list(dict.fromkeys(channel.position for channel in self._channels))
        return found if len(found) == 1 else ()

    def locations(self, problem: RotorProblem) -> Sequence[Runout]:
        """Circle at each plane.

        A machine as drawn also has a vector for each probe of a plane with several, and for all probes.
        """
        found = planes(problem)
        circles = self.at_each(found)
        if not problem.is_as_drawn:
            return circles
        channels = list(dict.fromkeys(channel for channel in problem.channels if channel.is_1x))
        groups = [[channel for channel in channels if channel.is_at(position)] for position in found]
        groups = [group for group in groups if len(group) > 1] + ([channels] if len(found) > 1 else [])
        each = [dataclasses.replace(self, position=None, probes=list(map(_text, group))) for group in groups]
        return [*circles, *each]

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        if not self.probes:
            return super().parameters(problem)
        names = [f"{name}_{part}" for name in self.vectors() for part in PARTS]
        return tuple(Parameter(name, "µm", MICROMETRE, -LARGEST, LARGEST) for name in names)

    def vectors(self) -> Sequence[str]:
        if not self.probes:
            return super().vectors()
        return [name_at("slow_roll_of", str(channel).replace("-", "minus ")) for channel in self._channels]

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        said = super().statement(sizes)
        if not self.probes:
            return said
        of_probes = (f"{{{name}:reading}} in {channel}" for name, channel in zip(self.vectors(), self._channels))
        return dataclasses.replace(said, sentence=f"Slow roll of {', '.join(of_probes)}")

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        return np.concatenate([super(Runout, self).draw(problem, rng) for _ in range(max(1, len(self.probes)))])

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        if self.probes:
            vectors = theta.reshape(len(theta), -1, 2) @ np.array([1, 1j])  # (n, n_probe)
            read = np.array(
                [
                    [channel.is_1x and channel.is_at(probe.position, probe.direction) for channel in channels]
                    for probe in self._channels
                ]
            )
            return response + (vectors @ read)[:, None]
        seen = [channel.is_1x and channel.is_at(self.position) for channel in channels]
        factors = [each * channel.forward_factor for each, channel in zip(seen, channels)]
        return response + forward_vector(theta)[:, None, None] * np.array(factors)


def _probe(text: str) -> Channel:
    """A probe written as direction@position (m)."""
    direction, _, position = text.partition("@")
    try:
        return Channel(float(position), direction)
    except (ValueError, SettingError) as error:
        raise SettingError(f"probes: expected direction@position such as x@0.05, got {text!r} ({error})") from None


def _text(channel: Channel) -> str:
    return f"{channel.direction}@{channel.position!r}"
