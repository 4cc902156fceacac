"""A measurement and the problem that is compared with it.

One immutable thing, made once and carried by whatever is found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ksmea.measurement.measurement import Measurement
from ksmea.numerics.screening import sobol
from ksmea.problem.alignment import aligned, require_aligned, through
from ksmea.problem.problem import Problem

MOST_SCREENED = 200  # speeds at which points of a whole box are compared


@dataclass(frozen=True, eq=False)
class Case:
    """A problem at the speeds, channels and runs of its measurement.

    Raises `SettingError` if they are not aligned (`ksmea.problem.alignment`).
    """

    problem: Problem
    measurement: Measurement

    def __post_init__(self) -> None:
        require_aligned(self.problem, self.measurement)

    @classmethod
    def of(cls, problem: Problem, measurement: Measurement) -> Case:
        """A problem as a measurement sees it. Raises `SettingError` if it cannot be seen so."""
        return cls(aligned(problem, measurement), measurement)

    def by(self, problem: Problem) -> Case:
        """The measurement compared with another problem that is seen alike."""
        return Case(problem, self.measurement)

    def of_measurement(self, measurement: Measurement) -> Case:
        """Problem compared with another measurement by these probes at these speeds.

        An example is one with other noise.
        """
        return Case(self.problem, measurement)

    def for_screening(self) -> Case:
        """At no more than `MOST_SCREENED` of its speeds, evenly chosen; itself where it has no more.

        Points are ranked by means over speeds and channels, which few of many speeds give as well.
        """
        n = len(self.measurement.speed)
        if n <= MOST_SCREENED:
            return self
        kept = np.unique(np.linspace(0, n - 1, MOST_SCREENED).astype(int))
        return Case.of(self.problem, self.measurement.part(kept))

    def answered(self) -> Case:
        """Through the channels at whose harmonics the problem moves at all.

        A linear model answers unbalance at 1X alone, and data at others tell nothing of it. Itself where that is all of
        them.

        The problem is asked at one set of values that is nothing special: the third point of a Sobol' sequence.
        """
        if all(channel.is_1x for channel in self.measurement.channels):
            return self
        x = self.problem.parameters.to_si(sobol(4, len(self.problem.parameters))[2:3])
        moves = np.any(self.problem.response(x)[0] != 0, axis=0)
        return self._through([bool(each) for each in moves])

    def at_1x(self) -> Case:
        """At the speed of rotation alone; itself where the data are."""
        return self._through([channel.is_1x for channel in self.measurement.channels])

    def _through(self, is_kept: list[bool]) -> Case:
        channels = self.measurement.channels
        kept = [index for index, each in enumerate(is_kept) if each or channels[index].is_1x]
        if len(kept) == len(channels):
            return self
        part = self.measurement.through(kept)
        return Case(through(self.problem, part.channels), part)
