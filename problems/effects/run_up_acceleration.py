"""Run-up or coast-down: the speed sweeps through the critical speeds while the response is measured.

It changes at a constant rate α.

The peak comes late, at a higher speed in a run-up and at a lower one in a coast-down, is lower, and beats behind it
(F. M. Lewis, Vibration during acceleration through a critical speed, Trans. ASME 54 (1932) 253–261). The response is
taken at the instant of the measured speed: a tracking filter that averages a turn or more blurs beats that are as fast.
How it is computed, and what is neglected: `problems/rotor/extension/run_up.py`.

A diagnosis tries it if a file has its rows in the order of time or a campaign gives the direction of its runs
(`ksmea/measurement/speeds.py`). If the direction is unknown, run-up and coast-down are tried apart: amplitudes alone
hardly distinguish one from the other, reversed about another critical speed, and searches end in either. Every beat is
a maximum of the likelihood; the search goes from steady states along rising rates, where each fit begins where the last
one ended.

A rate from times is known to a tolerance (`SpeedHistory.sd`): it is an unknown with a prior. Without times it lies
between 0 and a limit, 1.5 times the rate if each row is a turn. If rows are no turns either, |α| is at most Ω ΔΩ/2π if
each is a turn or more, and the limit is 1.5 times the median of this bound. A rate that is exact is the setting `rate`
alone: the effect has no unknown then. Each run of a campaign has its own rate; a run without one, such as a further
run, has the rate of the first run in its direction.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.measurement.campaign import Campaign, Run
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.speeds import ACCELERATION, rate_name
from ksmea.plugins.effect import SizeRecord, StatementRecord
from ksmea.problem.parameters import Parameter, Prior
from ksmea.settings.settings import setting
from ksmea.units import RPM, TURN
from problems.rotor.extension.effect import RotorEffect, drawn
from problems.rotor.extension.run_up import Sweep
from problems.rotor.response.problem import RotorProblem

MARGIN = 1.5  # of the limit over the rate that is known, or that of one row per turn
REACH = 6.0  # standard deviations that a rate with a prior is searched in
PATH = (1e-3, 32)  # of the limit, where the path of rates begins; and how many, a factor of 1.25 from one to the next
NOTICED = (0.05, 0.5)  # of the limit: a decade is drawn
SIGNS = {"either": (-1.0, 1.0), "run-up": (0.0, 1.0), "coast-down": (-1.0, 0.0)}
OF_DIRECTION = {"up": 1.0, "down": -1.0}  # sign of the rate in runs of a campaign; steady ones have none


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
    rate_sd: float | None = setting(
        None, "standard deviation of `rate`, which is an unknown with a prior then; null: exact", unit="rpm/s", above=0
    )
    runs: list[str] = setting([], "runs of a campaign in which the speed sweeps; empty: the speed sweeps in all alike")
    rates: list[float] = setting(
        [], "the rate in each of `runs`, negative in a coast-down, where its `rate_sds` is 0 its limit", unit="rpm/s"
    )
    rate_sds: list[float] = setting(
        [], "standard deviation of each of `rates`; 0: the rate is unknown", unit="rpm/s", at_least=0
    )
    full_speed: float | None = setting(
        None, "the highest speed that modes must suit; null: the highest of the problem", unit="rad/s", above=0
    )

    words = "fast speed sweep"
    is_of_measurement = True
    check_next = "Repeat the run at a slower sweep rate, or record a coast-down: peaks that move confirm it."
    aliases: ClassVar[Mapping[str, str]] = {
        "speed_dependent_damping": "both lower a peak; a second run-up at another rate, a coast-down",
        "speed_dependent_stiffness": "both move a peak; a second run-up at another rate, a coast-down",
        "timing_delay": "both make the phase late; a slower run-up, a coast-down",
    }

    is_scanned: ClassVar[bool] = False

    def __str__(self) -> str:
        ways = [way for way, sign in OF_DIRECTION.items() if sign in np.sign(self.rates)]
        if ways:
            return f"runs {' and '.join(ways)}"
        return "whole rotor" if self.direction == "either" else self.direction

    def statement(self, sizes: Mapping[str, SizeRecord]) -> StatementRecord:
        """The rate, of runs that sweep by themselves the rate of each; none if it is known exactly."""
        in_run = {rate_name(run): f" in run {run.replace('{', '{{').replace('}', '}}')}" for run in self.runs}
        rates = [f"{{{name}}}{in_run.get(name, '')}" for name in sizes]
        at = f" at {' and '.join(rates)}," if rates else ""
        sentence = f"The speed sweeps{at} too fast for steady states"
        return dataclasses.replace(super().statement(sizes), sentence=sentence)

    def check(self) -> None:
        if not len(self.runs) == len(self.rates) == len(self.rate_sds) == len({*map(rate_name, self.runs)}):
            raise SettingError(
                f"runs: expected different names, each with one of rates and one of rate_sds, got {', '.join(self.runs)}"
            )
        if 0 in self.rates:
            raise SettingError("rates: expected rates or limits other than 0, got 0; leave the run out")

    def seen_in(self, measurement: Measurement) -> RunUpAcceleration | None:
        """Effect with the direction and rate of the runs, if known.

        None for steady states, or if the direction is not known.
        """
        if measurement.campaign is not None:
            return self._in_runs(measurement.campaign, measurement.speed)
        history = measurement.history
        if history is None or self.direction != "either":
            return None if history is None else self
        if self.largest is not None or history.rate is None:
            return dataclasses.replace(self, direction=history.direction)
        if (sd := history.sd) is not None:
            return dataclasses.replace(self, direction=history.direction, rate=history.rate / RPM, rate_sd=sd / RPM)
        return dataclasses.replace(self, direction=history.direction, largest=MARGIN * abs(history.rate))

    def _in_runs(self, campaign: Campaign, speed: Array) -> RunUpAcceleration | None:
        """With the rate of each run, or its limit; None unless the way of every run is known and some sweep."""
        signs = [OF_DIRECTION.get(run.direction, 0.0) for run in campaign.runs]
        if self.runs or not all(run.direction for run in campaign.runs) or not any(signs):
            return self if self.runs else None
        limits = [_limit(run, speed[rows]) for run, rows in zip(campaign.runs, campaign.rows)]
        known = [limit for limit in limits if limit]
        if not known:
            return None
        found = []
        for run, sign, limit in zip(campaign.runs, signs, limits):
            history = run.history
            if sign and history is not None and history.rate is not None and history.sd is not None:
                found.append((run.name, history.rate / RPM, history.sd / RPM))
            elif sign:
                found.append((run.name, sign * (limit or max(known)) / RPM, 0.0))
        names, rates, sds = map(list, zip(*found))
        return dataclasses.replace(self, runs=names, rates=rates, rate_sds=sds)

    def path(self, problem: RotorProblem) -> Array:
        """All rates rising alike; with priors to what these say."""
        if self.rate is not None and self.rate_sd is None:
            return np.empty((0, 0))
        ends = [
            max(item.lower, item.upper, key=abs) if item.prior is None else item.prior.value
            for item in self.parameters(problem)
        ]
        return np.outer(np.geomspace(PATH[0], 1, PATH[1]), ends)

    def locations(self, problem: RotorProblem) -> Sequence[RunUpAcceleration]:
        if len(problem.speed) < 2 and self.largest is None:
            return []
        given = self.placed_on(problem)
        if self.direction != "either" or self.rate is not None or self.runs:
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
        return MARGIN * _row_per_turn(problem.speed)

    def parameters(self, problem: RotorProblem) -> tuple[Parameter, ...]:
        if self.runs:
            return tuple(
                _of_run(rate_name(run), rate, sd) for run, rate, sd in zip(self.runs, self.rates, self.rate_sds)
            )
        if self.rate is not None:
            return () if self.rate_sd is None else (_of_run(ACCELERATION, self.rate, self.rate_sd),)
        lower, upper = (sign * self._largest(problem) for sign in SIGNS[self.direction])
        return (Parameter(ACCELERATION, "rpm/s", RPM, lower, upper),)

    def draw(self, problem: RotorProblem, rng: np.random.Generator) -> Array:
        found = []
        for item in self.parameters(problem):
            if item.prior is not None:
                found.append(rng.normal(item.prior.value, item.prior.sd))
                continue
            end = rng.choice([end for end in (item.lower, item.upper) if end])
            found.append(end * drawn(rng, *NOTICED))
        return np.array(found)

    def sweep(self, theta: Array) -> Sweep:
        if self.full_speed is None:
            raise SettingError("full_speed: expected the highest speed, got none; add the effect to a problem")
        is_exact = self.rate is not None and self.rate_sd is None
        acceleration = np.full(len(theta), self.rate * RPM) if is_exact and self.rate is not None else theta[:, 0]
        return Sweep(acceleration, self.full_speed)

    def going(self, run: Run) -> RunUpAcceleration:
        """The effect with the rate of this run, or of the first run in its direction; else steady states."""
        if not self.runs:
            return self
        sign = OF_DIRECTION.get(run.direction, 0.0)
        alike = [index for index, rate in enumerate(self.rates) if rate * sign > 0]
        own = [self.runs.index(run.name)] if run.name in self.runs else alike[:1]
        return dataclasses.replace(
            self,
            runs=[self.runs[index] for index in own],
            rates=[self.rates[index] for index in own],
            rate_sds=[self.rate_sds[index] for index in own],
            rate=None if own else 0.0,
        )


def _row_per_turn(speed: Array) -> float:
    """Rate at which each row (n,) rad/s would be a turn of the shaft, rad/s²."""
    return float(np.median(np.abs(np.diff(speed**2))) / (2 * TURN))


def _limit(run: Run, speed: Array) -> float:
    """Limit of the rate of a run without times, rad/s²; 0 with fewer than two speeds."""
    if run.history is not None and run.history.rate is not None:
        return MARGIN * abs(run.history.rate)
    return MARGIN * _row_per_turn(speed) if len(speed) > 1 else 0.0


def _of_run(name: str, rate: float, sd: float) -> Parameter:
    """A rate (rpm/s) known to a standard deviation, or with sd 0 one between 0 and `rate`."""
    if not sd:
        return Parameter(name, "rpm/s", RPM, min(rate, 0.0) * RPM, max(rate, 0.0) * RPM)
    ends = (rate - REACH * sd, rate + REACH * sd)
    lower, upper = min(*ends, 0.0), max(*ends, 0.0)
    prior = Prior(rate * RPM, sd * RPM)
    return Parameter(name, "rpm/s", RPM, lower * RPM, upper * RPM, prior=prior, words=f"rate of the sweep, {name}")
