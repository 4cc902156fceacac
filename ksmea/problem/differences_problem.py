"""Differences of the runs of a campaign from one of them, as a problem and a measurement.

Searches use them like any other.

At speeds that this run lacks they are differences from the first run that has them.
Their noise is not independent, which a search need not know. `ksmea.likelihood.difference_likelihood` is exact.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray, Indices
from ksmea.measurement.noise import Noise
from ksmea.measurement.speeds import COMMON_SPEED, equal_speeds
from ksmea.problem.case import Case
from ksmea.problem.forwarding import ProblemProxy
from ksmea.problem.load import Load
from ksmea.problem.problem import Problem


def as_searched(case: Case) -> Case:
    """Case of the differences from the reference run if only they count; otherwise the case itself."""
    measurement = case.measurement
    if not measurement.is_by_differences or measurement.campaign is None:
        return case
    names = [run.name for run in measurement.campaign.runs]
    of_reference = measurement.rows[names.index(measurement.campaign.reference)]
    rows, references = [], []
    for group in equal_speeds(measurement.speed, COMMON_SPEED):
        is_reference = (group >= of_reference.start) & (group < of_reference.stop)
        if not np.any(is_reference):
            is_reference[0] = True
        rows += group[~is_reference].tolist()
        references += [int(group[is_reference][0])] * int(np.sum(~is_reference))
    taken, away = np.array(rows), np.array(references)
    values, noise = measurement.values, measurement.noise
    if noise is not None:
        sd = noise.sd(np.abs(values))
        noise = Noise(0.0, np.hypot(sd[taken], sd[away]))
    differences = dataclasses.replace(
        measurement, speed=measurement.speed[taken], values=values[taken] - values[away], noise=noise, campaign=None
    )
    return Case(DifferencesProblem(case.problem, taken, away), differences)


@dataclass(frozen=True, eq=False)
class DifferencesProblem(ProblemProxy):
    """The response of a problem at some of its speeds (`rows`), less that at others (`references`)."""

    base: Problem
    rows: Indices
    references: Indices

    @property
    def behind(self) -> Problem:
        return self.base

    def around(self, behind: Problem) -> DifferencesProblem:
        return dataclasses.replace(self, base=behind)

    @property
    def speed(self) -> Array:
        return self.base.speed[self.rows]

    @property
    def campaign(self) -> None:
        return None

    def response(self, x: Array) -> ComplexArray:
        """(n, d) SI → (n, n_row, n_channel), m."""
        return self._differences(self.base.response(x), 1)

    def load_response(self, x: Array, loads: Sequence[Load]) -> ComplexArray:
        return self._differences(self.base.load_response(x, loads), 1)

    def dense_response(self, x: Array) -> ComplexArray:
        return self._differences(self.base.dense_response(x), 1)

    def sensitivity(self, x: Array) -> ComplexArray:
        return self._differences(self.base.sensitivity(x), 0)

    def _differences(self, values: ComplexArray, axis: int) -> ComplexArray:
        return values.take(self.rows, axis) - values.take(self.references, axis)
