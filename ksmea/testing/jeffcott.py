"""Rotor of the contract tests: a disk amid a massless shaft on springs and dampers.

Its response has a closed form.

H. H. Jeffcott, Phil. Mag. 37 (1919) 304–314. In x and y, with D = k − m Ω² + i Ω c of each direction and u the unbalance,

    q_x = u Ω² / D_x,    q_y = −i u Ω² / D_y,

real responses being Re(q e^{iΩt}). Within its limits damping ratios are from 0.06 to 0.33, so that surrogates can follow it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.channel import DIRECTIONS, Channel
from ksmea.plugins.source import ProblemSettings
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem
from ksmea.settings.settings import setting
from ksmea.units import GRAM_MILLIMETRE, MEGANEWTON_PER_METRE

MASS = 10.0  # kg


@dataclass(frozen=True)
class Jeffcott(Problem):
    """Unknown are stiffness and damping in x and y, and the unbalance; every probe looks at the disk."""

    parameters: ClassVar[Parameters] = Parameters(
        (
            Parameter("kxx", "MN/m", MEGANEWTON_PER_METRE, 0.6e6, 1.4e6),
            Parameter("kyy", "MN/m", MEGANEWTON_PER_METRE, 0.6e6, 1.4e6),
            Parameter("cxx", "N s/m", 1.0, 400.0, 1600.0),
            Parameter("cyy", "N s/m", 1.0, 400.0, 1600.0),
            Parameter("u", "g mm", GRAM_MILLIMETRE, 100 * GRAM_MILLIMETRE, 900 * GRAM_MILLIMETRE),
        )
    )
    speed: Array = field(default_factory=lambda: np.linspace(100.0, 500.0, 9))
    channels: tuple[Channel, ...] = (Channel(0.0, "x"), Channel(0.0, "y"))

    def at(self, speed: Array, channels: Sequence[Channel]) -> Jeffcott:
        if not all(channel.is_1x for channel in channels):
            raise SettingError(
                "channels: expected 1X, got another harmonic, at which this rotor is at rest; leave it out"
            )
        if not all(channel.direction in DIRECTIONS for channel in channels):
            raise SettingError(
                "channels: expected directions x and y, got another one, which nobody asks of this rotor"
            )
        return replace(self, speed=speed, channels=tuple(channels))

    def response(self, x: Array) -> ComplexArray:
        stiffness = self._dynamic_stiffness(x)
        return self._turn * (x[:, 4, None, None] * self.speed[:, None] ** 2 / stiffness)

    def sensitivity(self, x: Array) -> ComplexArray:
        response, stiffness = self.response(x[None])[0], self._dynamic_stiffness(x[None])[0]
        by_stiffness = -response / stiffness
        by_damping = by_stiffness * 1j * self.speed[:, None]
        in_y = self._in_y
        return np.stack(
            [by_stiffness * ~in_y, by_stiffness * in_y, by_damping * ~in_y, by_damping * in_y, response / x[4]], axis=-1
        )

    def _dynamic_stiffness(self, x: Array) -> ComplexArray:
        """D (n, n_speed, n_channel), N/m."""
        in_y = self._in_y.astype(int)
        k, c, speed = x[:, None, in_y], x[:, None, 2 + in_y], self.speed[:, None]
        return np.asarray(k - MASS * speed**2 + 1j * speed * c)

    @property
    def _in_y(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        return np.array([channel.direction == "y" for channel in self.channels])

    @property
    def _turn(self) -> ComplexArray:  # y follows x by a quarter of a turn
        return np.where(self._in_y, -1j, 1.0 + 0j)


@dataclass(frozen=True)
class JeffcottRotor(ProblemSettings):
    """A disk amid a massless shaft on springs and dampers."""

    n_speed: int = setting(9, "number of equally spaced speeds from 100 to 500 rad/s", at_least=2)

    def build(self) -> Jeffcott:
        return Jeffcott(speed=np.linspace(100.0, 500.0, self.n_speed))

    def reference(self) -> Mapping[str, float]:
        return {"kxx": 0.9e6, "kyy": 1.1e6, "cxx": 900.0, "cyy": 1200.0, "u": 400 * GRAM_MILLIMETRE}
