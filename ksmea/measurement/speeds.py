"""Speeds of a measurement: equal ones (repeats, runs measured alike), and their course in time."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, Indices

SAME_SPEED = 1e-4  # relative: beside a resonance of quality 100 a response changes by 2 % over as much

COMMON_SPEED = (
    1e-3  # relative, of differences: each run is modelled at its own speed, only what cancels has to be the same
)


def equal_speeds(speed: Array, tolerance: float = SAME_SPEED) -> list[Indices]:
    """Indices of speeds (n_speed,) that are equal within a relative tolerance, by rising speed.

    The tolerance is relative to the lowest of them.

    >>> equal_speeds(np.array([2.0, 1.0, 2.0]))
    [array([1]), array([0, 2])]
    """
    order = np.argsort(speed, kind="stable")
    groups: list[list[int]] = []
    for index in order.tolist():
        if groups and speed[index] <= speed[groups[-1][0]] * (1 + tolerance):
            groups[-1].append(index)
        else:
            groups.append([index])
    return [np.array(sorted(group)) for group in groups]


TWO = 2  # runs, from which on a speed shows a difference


def compared_speeds(speed: Array, rows: Sequence[slice]) -> Indices:
    """Rising indices of the speeds (n_speed,) that two runs or more have, within `COMMON_SPEED`.

    Each run is at its rows.

    >>> compared_speeds(np.array([1.0, 2.0, 2.0, 3.0]), [slice(0, 2), slice(2, 4)])
    array([1, 2])
    """
    run = np.repeat(np.arange(len(rows)), [each.stop - each.start for each in rows])
    groups = [group for group in equal_speeds(speed, COMMON_SPEED) if len(np.unique(run[group])) >= TWO]
    return np.sort(np.concatenate(groups)) if groups else np.empty(0, dtype=int)


ACCELERATION = "acceleration"  # the unknown that is the rate of a sweep
DIRECTIONS = ("run-up", "coast-down")
CONSTANT = 0.2  # of the mean rate, by which the rates of the two halves of a run may differ
CLOSED_FORM = 0.02  # of the rate: as far as the closed form of a swept response may be off (docs/diagnosis.md)


def rate_name(run: str) -> str:
    """The unknown that is the rate of one run of a campaign, as one word.

    >>> rate_name("coast-down.2")
    'acceleration_coast_down_2'
    """
    return "_".join([ACCELERATION, *re.findall(r"\w+", run)])


@dataclass(frozen=True)
class SpeedHistory:
    """Direction of the speed over a run, and its rates.

    `direction` is one of `DIRECTIONS`, or "either" if the speeds are in order but the direction is unknown. `rates`
    (rad/s²) belong to the first and the second half of the run: from times, or as if each row were one turn of the
    shaft; None if unknown.
    """

    direction: str
    rates: tuple[float, float] | None = None
    from_times: bool = False

    @property
    def rate(self) -> float | None:
        """The mean rate, rad/s², negative in a coast-down."""
        return None if self.rates is None else sum(self.rates) / 2

    @property
    def sd(self) -> float | None:
        """Standard deviation of the rate from times, rad/s²; None without times.

        It combines half of the difference between the two halves, since either rate may hold at a critical speed, with
        the error of the closed form.
        """
        if not self.from_times or self.rates is None or self.rate is None:
            return None
        return float(np.hypot((self.rates[1] - self.rates[0]) / 2, CLOSED_FORM * self.rate))

    @property
    def is_constant(self) -> bool:
        """Whether the rate is known, and the same in both halves."""
        if self.rates is None or self.rate is None:
            return False
        return abs(self.rates[1] - self.rates[0]) <= CONSTANT * abs(self.rate)
