"""Runout: the surface under the probes is not concentric, so that they read a motion that is none.

A forward vector r is added at one measuring plane, the same at all speeds: y_x += r, y_y += −i r, and e^{−iθ} r to what a probe
at θ reads (API 684, slow-roll vector; Bently & Hatch, Fundamentals of Rotating Machinery Diagnostics, 2002, chapter 7).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.measurement.channel import Channel
from ksmea.settings.settings import setting
from ksmea.units import MICROMETRE
from problems.rotor.extension.effect import (
    PlacedEffect,
    forward_vector,
    is_at,
    planes,
    where,
)
from problems.rotor.extension.sizes import VectorSize
from problems.rotor.response.problem import RotorProblem

LARGEST = 50 * MICROMETRE  # ten times what API 670 lets pass
NOTICED = (0.3 * MICROMETRE, 15 * MICROMETRE)  # vectors as long as these are drawn


@dataclass(frozen=True)
class Runout(PlacedEffect):
    """Probes at one plane read a constant forward vector besides the motion."""

    position: float | None = setting(None, "the measuring plane; null: all of them alike", unit="m", at_least=0)

    says = "Runout of {runout:reading}, seen by {place:probes}"
    check_next = "It is no fault of the rotor: record a slow-roll vector, or the probe track's surface and magnetism."
    aliases: ClassVar[Mapping[str, str]] = {
        "residual_bow": "a bow is amplified at a critical speed, runout is not: measure through one, or a second plane",
    }

    what = "runout"
    sizes = (VectorSize("runout", "µm", LARGEST, drawn=NOTICED),)

    def __str__(self) -> str:
        return where(self.position)

    def locations(self, problem: RotorProblem) -> Sequence[Runout]:
        return self.at_each(planes(problem))

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        seen = [channel.is_1x and is_at(channel, self.position) for channel in channels]
        read = [each * channel.forward_factor for each, channel in zip(seen, channels)]
        return response + forward_vector(theta)[:, None, None] * np.array(read)
