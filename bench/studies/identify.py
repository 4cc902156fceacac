"""Identification: the values that a method finds from one measurement, with an interval beside each."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bench.curves import response_curves
from bench.plan import generator
from bench.setup import Setup
from bench.studies.contract import Draw
from ksmea.contracts import Problem
from ksmea.identification import Identification, Streams
from ksmea.intervals import climb, estimate
from ksmea.journal import Journal, journaled
from ksmea.likelihood import Likelihood
from ksmea.measurement import Measurement
from ksmea.misfit import Misfit
from ksmea.model import Model
from ksmea.parameters import Array, Parameters
from ksmea.settings import Settings, setting


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
        choices=("profile", "information", "none"),
    )
    level: float = setting(0.95, "confidence level of the intervals", above=0, at_most=0.9999)
    basin: bool = setting(
        False, "compare the maximum of the likelihood nearest to what was found with the one nearest to the truth"
    )

    report: ClassVar[str] = "summary"
    ignores: ClassVar[tuple[str, ...]] = ()

    def validate(self, setup: Setup) -> None:
        plugins = setup.plugins
        plugins["method"].validate(setup.problem, plugins["surrogate"], plugins["optimizer"], setup.samples)

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        plugins = setup.plugins
        problem = setup.problem if draw.journal is None else journaled(setup.problem, Journal(draw.journal))
        measurement = plugins["measurement"].measure(plugins["problem"], setup.truth, generator(draw.seeds["noise"]))
        streams = Streams(*(generator(draw.seeds[component]) for component in ("design", "surrogate", "optimizer")))
        found = plugins["method"].identify(
            problem, measurement, plugins["surrogate"], plugins["optimizer"], setup.samples, streams
        )
        record = _record(problem.parameters, setup.truth, found)
        record["misfit"] = _finite(_likelihood(setup.problem, measurement, found))
        if self.intervals != "none" and (measurement.noise is None or measurement.has_noise):
            self._add_intervals(record, problem, measurement, found, setup.true_x if self.basin else None)
        if draw.with_curves:
            true_response = plugins["measurement"].response(plugins["problem"], setup.truth)
            record["curves"] = response_curves(setup.problem, measurement, true_response, found)
        return record

    def _add_intervals(
        self,
        record: dict[str, Any],
        problem: Problem,
        measurement: Measurement,
        found: Identification,
        true_x: Array | None,
    ) -> None:
        """Put intervals, noise level and what they took into a record; what cannot be computed costs no identification."""
        started = time.perf_counter()
        model = Model(problem)
        likelihood = Likelihood(model, measurement)
        try:
            nearest = climb(likelihood, problem.parameters.to_cube(found.x))
            estimated = estimate(likelihood, nearest, level=self.level, check=self.intervals == "profile")
        except np.linalg.LinAlgError as error:
            record["interval"] = {"error": str(error)}
            return
        for parameter, interval, likely in zip(record["parameters"], estimated.intervals, estimated.x):
            parameter |= {
                "low": _finite(interval.low),
                "high": _finite(interval.high),
                "interval": interval.kind,
                "likely": float(likely),
            }
        record["interval"] = {
            "level": self.level,
            "noise": {**vars(estimated.noise), "estimated": measurement.noise is None},
            "model_evaluations": model.evaluations,
            "model_jacobians": model.jacobians,
            "seconds": time.perf_counter() - started,
        }
        if true_x is not None:
            of_truth = climb(likelihood, problem.parameters.to_cube(true_x))
            record["basin_excess"] = nearest.deviance - of_truth.deviance


def _likelihood(problem: Problem, measurement: Measurement, found: Identification) -> float:
    """The likelihood misfit of what was identified: the same form whatever a method minimised, to compare them by."""
    misfit = Misfit(measurement, "likelihood")
    return float(misfit.value(misfit.observed(problem.response(found.x[None])))[0])


def _record(parameters: Parameters, truth: Mapping[str, float], found: Identification) -> dict[str, Any]:
    if not np.all(np.isfinite(found.x)):
        raise ArithmeticError(f"the identified values are not finite: {found.x}")
    return {
        "status": "budget" if found.was_cut_short else "done",
        "stop": found.stop,
        "parameters": [
            {
                "name": parameter.name,
                "unit": parameter.unit,
                "si_per_unit": parameter.si_per_unit,
                "true": truth[parameter.name],
                "identified": float(value),
                "at_bound": on_bound,
            }
            for parameter, value, on_bound in zip(parameters, found.x, found.at_bound)
        ],
        "updates": found.updates,
        "model_evaluations": found.model_evaluations,
        "model_jacobians": found.model_jacobians,
        "surrogate_evaluations": found.surrogate_evaluations,
        "seconds": dict(found.seconds),
        "history": [
            {
                "x": update.x.tolist(),
                "predicted_misfit": _finite(update.predicted_misfit),
                "misfit": _finite(update.misfit),
                "smc": _finite(update.smc),
                "sdf": _finite(update.sdf),
            }
            for update in found.history
        ],
        "notes": {name: _finite(value) for name, value in found.notes.items()},
    }


def _finite(value: float) -> float | None:
    """JSON has no infinity: what is not finite is null."""
    return value if math.isfinite(value) else None
