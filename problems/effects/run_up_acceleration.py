"""Run-up or coast-down: the speed sweeps at a constant rate α through the critical speeds while the response is measured.

The peak comes late, at a higher speed in a run-up and at a lower one in a coast-down, is lower, and beats behind it
(F. M. Lewis, Vibration during acceleration through a critical speed, Trans. ASME 54 (1932) 253–261). The response counts as that at the measured speed, an instant of it: a tracking filter that averages
a turn or more blurs beats that are as fast. How it is computed, and what that leaves out: `problems/rotor/extension/run_up.py`.

A diagnosis tries it where a file has its rows in the order of time or a campaign says which way its runs went
(`ksmea/measurement/speeds.py`). Where nothing says which way, run-up and coast-down are tried apart: amplitudes alone hardly tell one
from the other, reversed about another critical speed, and searches end in either. Every beat is a maximum of the likelihood; the
search goes from steady states along rising rates, where each fit begins where the last one ended.

The limit of the rate is 1.5 times what times or rows of a turn each say it is. Without these it is as if each row were a turn:
|α| is no higher than Ω ΔΩ/2π where each is a turn or more, and the limit 1.5 times the median of that. A rate that is known is
the setting `rate`: the effect has no unknown then. Runs of a campaign that go up and down have one rate, with both signs: what
beats behind the peak in one beats before it in the other, as nothing else does.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.speeds import ACCELERATION, SpeedHistory
from ksmea.problem.parameters import Parameter
from ksmea.settings.settings import setting
from ksmea.units import RPM, TURN
from problems.rotor.extension.effect import RotorEffect, drawn
from problems.rotor.extension.run_up import Sweep
from problems.rotor.response.problem import RotorProblem

MARGIN = 1.5  # of the limit over the rate that is known, or that of one row per turn
PATH = (1e-3, 32)  # of the limit, where the path of rates begins; and how many, a factor of 1.25 from one to the next
NOTICED = (0.05, 0.5)  # of the limit: a decade is drawn
SIGNS = {"either": (-1.0, 1.0), "run-up": (0.0, 1.0), "coast-down": (-1.0, 0.0)}
ALIKE = "alike"
OF_RUN = {ALIKE: 1.0, "up": 1.0, "down": -1.0, "steady": 0.0}  # times the rate


@dataclass(frozen=True)
class RunUpAcceleration(RotorEffect):
    """The speed sweeps while the response is measured, faster than steady states settle."""

    direction: str = setting("either", "which way the speed goes", choices=tuple(SIGNS))
    largest: float | None = setting(
        None, "limit of the rate, either way; null: 1.5 rows per turn of the shaft", unit="rad/s²", above=0
    )
    rate: float | None = setting(
        None, "the rate where it is known, negative in a coast-down; null: an unknown", unit="rpm/s"
    )
    of_run: str = setting(
        ALIKE,
        "up: runs of a campaign that go up have the rate, those that go down minus that; alike: all have it",
        choices=tuple(OF_RUN),
    )
    full_speed: float | None = setting(
        None, "the highest speed that modes must suit; null: that of the problem", unit="rad/s", above=0
    )

    words = "fast speed sweep"
    says = "The speed sweeps at {acceleration}, too fast for steady states"
    check_next = "Sweep rate of the run; repeat it slower, or add a coast-down."
    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_damping": "both lower a peak; a second run-up at another rate, a coast-down",
        "speed_dependent_stiffness": "both move a peak; a second run-up at another rate, a coast-down",
        "timing_delay": "both make the phase late; a slower run-up, a coast-down",
    }

    is_scanned: ClassVar[bool] = False

    def __str__(self) -> str:
        if self.of_run != ALIKE:
            return "runs up and down"
        return "whole rotor" if self.direction == "either" else self.direction

    def seen_in(self, measurement: Measurement) -> RunUpAcceleration | None:
        """With the direction of the runs, and the limit that a known rate sets; None of steady states, or where nobody says."""
        history = measurement.history
        if measurement.campaign is not None:
            directions = {run.direction for run in measurement.campaign.runs}
            if self.direction == "either" and len(directions) > 1 and directions <= {*OF_RUN} - {ALIKE}:
                return dataclasses.replace(self, direction="run-up", of_run="up")
            history = _of_runs(directions)
        if history is None or self.direction != "either":
            return None if history is None else self
        if self.largest is not None or history.rate is None:
            return dataclasses.replace(self, direction=history.direction)
        return dataclasses.replace(self, direction=history.direction, largest=MARGIN * abs(history.rate))

    def path(self, problem: RotorProblem) -> Array:
        signs = SIGNS[self.direction]
        return np.outer(np.geomspace(PATH[0], 1, PATH[1]), self._largest(problem) * (signs[0] or signs[1]))

    def locations(self, problem: RotorProblem) -> Sequence[RunUpAcceleration]:
        if len(problem.speed) < 2 and self.largest is None:
            return []
        given = self.placed_on(problem)
        if self.direction != "either" or self.rate is not None:
            return [given]
        return [dataclasses.replace(given, direction=direction) for direction in SIGNS if direction != "either"]

    def placed_on(self, problem: RotorProblem) -> RunUpAcceleration:
        full_speed = float(np.max(problem.speed)) if self.full_speed is None else self.full_speed
        return dataclasses.replace(self, largest=self._largest(problem), full_speed=full_speed)

    def _largest(self, problem: RotorProblem) -> float:
        if self.largest is not None:
            return self.largest
        if len(problem.speed) < 2:
            raise SettingError("largest: expected a limit of the rate where one speed is measured, got none; give it")
        return float(MARGIN * np.median(np.abs(np.diff(problem.speed**2))) / (2 * TURN))

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        if self.rate is not None:
            return ()
        lower, upper = (sign * self._largest(problem) for sign in SIGNS[self.direction])
        return (Parameter(ACCELERATION, "rpm/s", RPM, lower, upper),)

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        if self.rate is not None:
            return np.empty(0)
        lower, upper = SIGNS[self.direction]
        return (
            self._largest(problem)
            * rng.choice([sign for sign in (lower, upper) if sign])
            * np.array([drawn(rng, *NOTICED)])
        )

    def sweep(self, theta: Array) -> Sweep:
        if self.full_speed is None:
            raise SettingError("full_speed: expected the highest speed, got none; add the effect to a problem")
        acceleration = theta[:, 0] if self.rate is None else np.full(len(theta), self.rate * RPM)
        return Sweep(OF_RUN[self.of_run] * acceleration, self.full_speed)

    def going(self, direction: str) -> RunUpAcceleration:
        return self if self.of_run == ALIKE else dataclasses.replace(self, of_run=direction)


def _of_runs(directions: set[str]) -> SpeedHistory | None:
    """What runs of a campaign have in common."""
    known = {"up": "run-up", "down": "coast-down"}
    return SpeedHistory(known[direction]) if len(directions) == 1 and (direction := directions.pop()) in known else None
