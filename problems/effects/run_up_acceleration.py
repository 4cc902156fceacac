"""Run-up or coast-down: the speed sweeps at a constant rate α through the critical speeds while the response is measured.

The peak comes late, at a higher speed in a run-up and at a lower one in a coast-down, is lower, and beats behind it
(F. M. Lewis, Vibration during acceleration through a critical speed, Trans. ASME 54 (1932) 253–261; A. D. Dimarogonas, Vibration
for Engineers, 1996). The response counts as that at the measured speed, an instant of it: a tracking filter that averages
a turn or more blurs beats that are as fast. How it is computed, and what that leaves out: `problems/rotor/run_up.py`.

Where each row is a turn of the shaft or more, α is no higher than Ω ΔΩ/2π. Limits are twice the median of that over the rows,
which are not exactly alike. Rows must be at rising or at falling speeds, as a sweep has them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.parameters import Parameter
from ksmea.settings import setting
from ksmea.units import RPM, TURN
from problems.rotor.effect import RotorEffect, drawn_either_side
from problems.rotor.problem import RotorProblem

MARGIN = 2.0  # of the limits over one row per turn
NOTICED = (0.05, 0.5)  # of the limit: a decade up to one row per turn is drawn


@dataclass(frozen=True)
class RunUpAcceleration(RotorEffect):
    """The speed sweeps while the response is measured, faster than steady states settle."""

    largest: float | None = setting(
        None, "limit of the rate, either way; null: two rows per turn of the shaft", unit="rad/s²", above=0
    )

    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_damping": "both lower a peak; a second run-up at another rate, a coast-down",
        "speed_dependent_stiffness": "both move a peak; a second run-up at another rate, a coast-down",
    }
    sweeps: ClassVar[bool] = True

    def locations(self, problem: RotorProblem) -> Sequence[RunUpAcceleration]:
        return [self.placed_on(problem)] if self.largest or _is_sweep(problem.speed) else []

    def placed_on(self, problem: RotorProblem) -> RunUpAcceleration:
        return dataclasses.replace(self, largest=self._largest(problem))

    def _largest(self, problem: RotorProblem) -> float:
        if self.largest is not None:
            return self.largest
        if not _is_sweep(problem.speed):
            raise SettingError(
                "largest: expected rows at rising or falling speeds, got others; give a limit of the rate"
            )
        return float(MARGIN * np.median(np.abs(np.diff(problem.speed**2))) / (2 * TURN))

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        largest = self._largest(problem)
        return (Parameter("acceleration", "rpm/s", RPM, -largest, largest),)

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        return self._largest(problem) * np.array([drawn_either_side(rng, *NOTICED)])

    def acceleration(self, theta: Array) -> Array:
        return theta[:, 0]


def _is_sweep(speed: Array) -> bool:
    steps = np.diff(speed)
    return len(steps) > 0 and bool(np.all(steps > 0) or np.all(steps < 0))
