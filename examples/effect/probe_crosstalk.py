"""Crosstalk of the x and y probes at one plane.

Each reads a part g of what the other one sees, y_x += g y_y, y_y += g y_x.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea import Channel, setting
from ksmea.measurement.channel import DIRECTIONS
from ksmea.problem.parameters import Parameter
from problems.rotor.extension.effect import PlacedEffect, planes, where
from problems.rotor.response.problem import RotorProblem

LARGEST = 0.3


@dataclass(frozen=True)
class ProbeCrosstalk(PlacedEffect):
    """The x and y probes at one plane read a part of each other's motion."""

    position: float | None = setting(None, "the measuring plane; null: all of them alike", unit="m", at_least=0)

    def __str__(self) -> str:
        return where(self.position)

    def locations(self, problem: RotorProblem) -> Sequence[ProbeCrosstalk]:
        places = (dataclasses.replace(self, position=position) for position in planes(problem))
        return [place for place in places if place._partners(problem.channels).any()]

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        return (Parameter("crosstalk", "%", 0.01, -LARGEST, LARGEST),)

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> np.ndarray:
        return rng.uniform(0.05, 0.2, 1) * rng.choice([-1.0, 1.0])

    def needed_channels(self, channels: Sequence[Channel]) -> Sequence[Channel]:
        """The other probe of each plane, where it is not asked for itself."""
        return [
            dataclasses.replace(channel, direction="y" if channel.direction == "x" else "x")
            for channel in channels
            if self._acts_on(channel)
        ]

    def observed(
        self, response: np.ndarray, channels: Sequence[Channel], speed: np.ndarray, theta: np.ndarray
    ) -> np.ndarray:
        return response + theta[:, 0, None, None] * (response @ self._partners(channels))

    def _acts_on(self, channel: Channel) -> bool:
        """Which probe is the other one of a skew pair, its channel does not say."""
        return channel.is_at(self.position) and channel.direction in DIRECTIONS

    def _partners(self, channels: Sequence[Channel]) -> np.ndarray:
        """(n_channel, n_channel): 1 where the row's channel is the other one at the plane of the column's."""
        return np.array(
            [
                [
                    1.0
                    if self._acts_on(one)
                    and self._acts_on(other)
                    and (one.position, one.harmonic) == (other.position, other.harmonic)
                    and one.direction != other.direction
                    else 0.0
                    for other in channels
                ]
                for one in channels
            ]
        )
