"""Thermal bow: the shaft bends as it warms up during the run, so that a bow grows from nothing.

D(Ω) q = f + g K_s q_b with the shapes of a residual bow (`problems/rotor/extension/bow.py`) and q_b its value at the end. It grows
evenly with time, g = 0 at the first row and 1 at the last. Where `time_s` is not known the order of the rows stands for time, and
where neither is, speeds count as measured from the lowest to the highest. The bow is slow: at each instant the shaft responds as
to a bow that stays. In a campaign each run-up starts cold and is followed by its coast-down, which takes as long: g goes from 0 to
1/2 in runs up and on to 1 in runs down, so that these differ at the same speed, as no steady cause makes them.

A diagnosis tries it where times, the rows of a file or the directions of a campaign's runs tell how the run went, as steady speeds
may have been measured in any order (`ksmea/measurement/speeds.py`). A run that goes up and down in one file is not one of these: make it a
campaign of two. Heat that the vibration itself brings to a journal, whose vector turns, is not meant here.

Source of the load: J. C. Nicholas, E. J. Gunter & P. E. Allaire, Effect of residual shaft bow on unbalance response and balancing of a
single mass flexible rotor, J. Eng. Power 98 (1976) 171–189; Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines, 2010,
chapter 6.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import SettingError
from ksmea.measurement.campaign import Run
from ksmea.measurement.measurement import Measurement
from ksmea.settings.settings import setting
from problems.rotor.extension.bow import Bow
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.response.problem import RotorProblem

MOST_KNOTS = 33  # of the history that is kept of a run: heat is slow, and an extended model is written to a file
ALIKE = "alike"
OF_RUN = {ALIKE: (0.0, 1.0), "up": (0.0, 0.5), "down": (1.0, -0.5), "steady": (1.0, 0.0)}  # g = offset + slope · grown


@dataclass(frozen=True)
class ThermalBow(Bow):
    """The shaft bends more and more as it warms up."""

    speeds: list[float] = setting(
        [], "rising speeds at which `grown` is known; empty: the lowest and the highest of the problem", unit="rad/s"
    )
    grown: list[float] = setting([], "part of the bow that has grown at these, from 0 to 1", at_least=0, at_most=1)
    of_run: str = setting(
        ALIKE,
        "up: half of it grows in runs that go up, the other half in runs that go down; alike: all of it in each run",
        choices=tuple(OF_RUN),
    )

    bends = "The shaft bends as it warms up,"
    check_next = (
        "Repeat the run cold and hold full speed:"
        " vibration that creeps confirms it; then look for rubs and uneven cooling."
    )
    aliases: ClassVar[Mapping[str, str]] = {
        "residual_bow": "a bow of heat is gone when the machine is cold, and run-up and run-down differ by it",
        "coupling_misalignment": "both turn with the shaft; a bow of heat is gone when the machine is cold",
    }

    vector = "thermal_bow"

    def __str__(self) -> str:
        return super().__str__() + ("" if self.of_run == ALIKE else " in runs up and down")

    def check(self) -> None:
        super().check()
        if len(self.speeds) != len(self.grown) or np.any(np.diff(self.speeds) <= 0):
            raise SettingError(f"speeds: expected rising ones, one for each of grown, got {self.speeds}")

    def seen_in(self, measurement: Measurement) -> ThermalBow | None:
        """Effect with the growth of the bow at each speed.

        None for steady states, or if the course of the run is not known.
        """
        if self.speeds:
            return self
        if measurement.campaign is not None:
            return self._in_runs({run.direction for run in measurement.campaign.runs}, measurement.speed)
        if measurement.history is None:
            return None
        time = np.arange(len(measurement.speed)) if measurement.time is None else measurement.time
        kept = np.unique(np.linspace(0, len(time) - 1, MOST_KNOTS).round().astype(int))
        speeds, first = np.unique(measurement.speed[kept], return_index=True)
        grown = np.interp(time[kept][first], (time[0], time[-1]), (0.0, 1.0))
        return dataclasses.replace(self, speeds=speeds.tolist(), grown=grown.tolist())

    def _in_runs(self, directions: set[str], speed: Array) -> ThermalBow | None:
        ends = [float(np.min(speed)), float(np.max(speed))]
        if directions == {"up", "down"}:
            return dataclasses.replace(self, speeds=ends, grown=[0.0, 1.0], of_run="up")
        if directions in ({"up"}, {"down"}):
            return dataclasses.replace(self, speeds=ends, grown=[0.0, 1.0] if directions == {"up"} else [1.0, 0.0])
        return None

    def locations(self, problem: RotorProblem) -> Sequence[ThermalBow]:
        if self.speeds or len(np.unique(problem.speed)) > 1:
            return Bow.locations(self.placed_on(problem), problem)
        return []

    def placed_on(self, problem: RotorProblem) -> ThermalBow:
        if self.speeds:
            return self
        ends = [float(np.min(problem.speed)), float(np.max(problem.speed))]
        return dataclasses.replace(self, speeds=ends, grown=[0.0, 1.0])

    def loads(self, rotor: Rotor, speed: Array) -> ComplexArray:
        if not self.speeds:
            raise SettingError("speeds: expected how the run went, got nothing; add the effect to a problem")
        offset, slope = OF_RUN[self.of_run]
        return self.bow_loads(rotor, offset + slope * np.interp(speed, self.speeds, self.grown))

    def going(self, run: Run) -> ThermalBow:
        return self if self.of_run == ALIKE else dataclasses.replace(self, of_run=run.direction)
