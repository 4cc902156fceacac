"""Identification as a run of the bench: `ksmea.studies.identify`, and beside what it found what only the bench knows."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar

from bench.plan.draw import Draw
from bench.plan.plan import generator
from bench.plan.setup import Setup
from ksmea.arrays import Array
from ksmea.contracts import Problem
from ksmea.errors import SettingError
from ksmea.identification import Identification, Streams
from ksmea.intervals import climb
from ksmea.journal import Journal, journaled
from ksmea.likelihood import Likelihood
from ksmea.measurement import Measurement
from ksmea.model import Model
from ksmea.settings import Settings, setting
from ksmea.studies.identify import INTERVALS, identification


@dataclass(frozen=True)
class Identify(Settings):
    """The values of the unknowns, found by the method from the measurement, with an interval beside each.

    The intervals belong to the maximum of the true model's likelihood nearest to what the method found. They take
    Jacobians of the true model, which are counted apart from the method's.
    """

    intervals: str = setting(
        "profile",
        "how intervals are made: profile (from the information, checked and where needed replaced by the profile"
        " likelihood: some ten Jacobians an unknown), information (unchecked: a few in all), none",
        choices=INTERVALS,
    )
    level: float = setting(0.95, "confidence level of the intervals", above=0, at_most=0.9999)
    basin: bool = setting(
        False, "compare the maximum of the likelihood nearest to what was found with the one nearest to the truth"
    )
    details: bool = setting(
        False,
        "keep what a report on one identification shows: data and fit over speed, Cramér–Rao bounds and correlations at the"
        " identified values",
    )

    report: ClassVar[str] = "summary"
    ignores: ClassVar[tuple[str, ...]] = ()

    def validate(self, setup: Setup) -> None:
        plugins = setup.plugins
        if self.basin and not setup.truth:
            raise SettingError(
                "study.basin: expected true values to compare with, got a measurement without; leave it out"
            )
        plugins["method"].validate(setup.problem, plugins["surrogate"], plugins["optimizer"], setup.samples)

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        problem = setup.problem if draw.journal is None else journaled(setup.problem, Journal(draw.journal))
        measurement = setup.measure(draw)
        record = identification(
            problem,
            measurement,
            _Method(setup),
            Streams(*(generator(draw.seeds[component]) for component in ("design", "surrogate", "optimizer"))),
            intervals=self.intervals,
            level=self.level,
            crlb=self.details or not setup.truth,
            details=self.details,
            curves=draw.with_curves,
            remarks=getattr(setup.plugins["measurement"], "remarks", ()),
            rng=generator(draw.seeds["diagnosis"]),
        )
        response = setup.true_response(draw) if draw.with_curves else None
        record = record.with_truth(problem.parameters, setup.truth, response)
        if self.basin and record.deviance is not None:
            excess = record.deviance - _deviance_near(setup.true_x, problem, measurement)
            record = dataclasses.replace(record, basin_excess=excess)
        return dataclasses.replace(record, hidden=tuple(setup.hidden(draw))).to_data()


@dataclass(frozen=True)
class _Method:
    """The method with the surrogate, the optimiser and the number of samples of a run."""

    setup: Setup

    def identify(self, problem: Problem, measurement: Measurement, streams: Streams) -> Identification:
        plugins = self.setup.plugins
        found: Identification = plugins["method"].identify(
            problem, measurement, plugins["surrogate"], plugins["optimizer"], self.setup.samples, streams
        )
        return found


def _deviance_near(x: Array, problem: Problem, measurement: Measurement) -> float:
    """The deviance at the maximum of the likelihood nearest to x (d,) SI."""
    return climb(Likelihood(Model(problem), measurement), problem.parameters.to_cube(x)).deviance
