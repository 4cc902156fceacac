"""A block of concrete on springs, shaken by a rotating exciter.

No rotor, and a response in closed form,

    q = u Ω² / (k − m Ω² + i Ω c),  u the unbalance of the exciter, Re(q e^{iΩt})

(Richart, Hall & Woods, *Vibrations of Soils and Foundations*, 1970).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ksmea import Channel, Problem, ProblemSettings, SettingError, setting
from ksmea.problem.parameters import Parameter, Parameters

PARAMETERS = Parameters(
    (
        Parameter("k", "MN/m", 1e6, 5e6, 50e6),
        Parameter("c", "kN s/m", 1e3, 5e3, 100e3),
    )
)
ON_THE_BLOCK = Channel(0.0, "x")


@dataclass(frozen=True)
class ShakenBlock(Problem):
    """Unknown are the stiffness and the damping of the ground below."""

    mass: float  # kg
    unbalance_of_exciter: float  # kg m
    speed: np.ndarray  # (n_speed,) rad/s
    channels: tuple[Channel, ...] = (ON_THE_BLOCK,)
    parameters: Parameters = field(default=PARAMETERS)

    def at(self, speed: np.ndarray, channels: Sequence[Channel]) -> ShakenBlock:
        if any(channel != ON_THE_BLOCK for channel in channels):
            raise SettingError(
                f"channels: expected {ON_THE_BLOCK}, in which the block moves, got others; leave them out"
            )
        return replace(self, speed=speed, channels=tuple(channels))

    def response(self, x: np.ndarray) -> np.ndarray:
        response = self.unbalance_of_exciter * self.speed**2 / self._dynamic_stiffness(x)
        return np.repeat(response[:, :, None], len(self.channels), axis=2)

    def sensitivity(self, x: np.ndarray) -> np.ndarray:
        by_stiffness = -self.response(x[None])[0] / self._dynamic_stiffness(x[None])[0][:, None]
        return np.stack([by_stiffness, 1j * self.speed[:, None] * by_stiffness], axis=-1)

    def _dynamic_stiffness(self, x: np.ndarray) -> np.ndarray:
        """(n, n_speed) N/m."""
        return x[:, :1] - self.mass * self.speed**2 + 1j * self.speed * x[:, 1:]


@dataclass(frozen=True)
class FoundationBlock(ProblemSettings):
    """A block of concrete on the ground, shaken by a rotating exciter."""

    mass: float = setting(10_000.0, "mass of the block", unit="kg", above=0)
    exciter: float = setting(1.0, "unbalance of the exciter", unit="kg m", above=0)
    n_speed: int = setting(40, "number of equally spaced speeds from 10 to 100 rad/s", at_least=2)

    def build(self) -> ShakenBlock:
        return ShakenBlock(self.mass, self.exciter, np.linspace(10.0, 100.0, self.n_speed))

    def reference(self) -> Mapping[str, float]:
        return {"k": 20e6, "c": 40e3}
