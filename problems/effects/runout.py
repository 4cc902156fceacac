"""Runout: the surface under the probes is not concentric, so that they read a motion that is none.

A forward vector r is added at one measuring plane, the same at all speeds: y_x += r, y_y += −i r (API 684, slow-roll
vector; Bently & Hatch, Fundamentals of Rotating Machinery Diagnostics, 2002, chapter 7).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.contracts import Channel, ComplexArray
from ksmea.parameters import Array, Parameter
from ksmea.settings import setting
from problems.rotor.effect import RotorEffect
from problems.rotor.problem import RotorProblem

MICROMETRE = 1e-6  # m
LARGEST = 50 * MICROMETRE  # ten times what API 670 lets pass


@dataclass(frozen=True)
class Runout(RotorEffect):
    """Probes at one plane read a constant forward vector besides the motion."""

    position: float | None = setting(None, "the measuring plane; null: all of them alike", unit="m", at_least=0)

    aliases: ClassVar[Mapping[str, str]] = {
        "residual_bow": "a bow is amplified at a critical speed, runout is not: measure through one, or a second plane",
    }

    def places(self, problem: RotorProblem) -> Sequence[Runout]:
        positions = dict.fromkeys(channel.position for channel in problem.channels)
        return [dataclasses.replace(self, position=position) for position in positions]

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        return tuple(Parameter(name, "µm", MICROMETRE, -LARGEST, LARGEST) for name in ("runout_x", "runout_y"))

    def observed(self, response: ComplexArray, channels: Sequence[Channel], speed: Array, theta: Array) -> ComplexArray:
        vector = theta[:, 0] + 1j * theta[:, 1]
        seen = [
            (self.position is None or channel.position == self.position) * (1.0 if channel.direction == "x" else -1j)
            for channel in channels
        ]
        return response + vector[:, None, None] * np.array(seen)
