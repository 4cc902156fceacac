"""Identification: the values that a method finds from one measurement, with an interval beside each."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bench.plan.draw import Draw
from bench.plan.plan import generator
from bench.plan.setup import Setup
from bench.plan.study import Study
from bench.studies.curves import fit_curves, response_curves
from ksmea.arrays import Array
from ksmea.contracts import Problem
from ksmea.diagnosis.fit_quality import fit_quality
from ksmea.diagnosis.fitting import Fit
from ksmea.errors import SettingError
from ksmea.identifiability import identifiability
from ksmea.identification import Identification, Streams, at_limit
from ksmea.intervals import Interval, estimate
from ksmea.journal import Journal, JournaledProblem
from ksmea.likelihood import Likelihood
from ksmea.maximisation import nearest_maximum
from ksmea.measurement import Measurement, Noise
from ksmea.misfit import Misfit
from ksmea.model import Model
from ksmea.parameters import Parameter, Parameters
from ksmea.records.record import finite
from ksmea.settings import setting
from ksmea.units import TURN

LACK_OF_FIT_LEVEL = 0.01  # chance of rejecting a right model


@dataclass(frozen=True)
class Identify(Study):
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
    details: bool = setting(
        False,
        "keep what a report on one identification shows: data and fit over speed, bounds and correlations at the identified"
        " values",
    )

    report: ClassVar[str] = "summary"

    def validate(self, setup: Setup) -> None:
        plugins = setup.plugins
        if self.basin and not setup.truth:
            raise SettingError(
                "study.basin: expected true values to compare with, got a measurement without; leave it out"
            )
        plugins["method"].validate(setup.problem)

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        plugins = setup.plugins
        problem = setup.problem if draw.journal is None else JournaledProblem(setup.problem, Journal(draw.journal))
        measurement = setup.measure(draw)
        streams = Streams(*(generator(draw.seeds[component]) for component in ("design", "surrogate", "optimizer")))
        found = plugins["method"].identify(problem, measurement, streams)
        found = _within_a_turn(problem.parameters, found)
        record = _record(problem.parameters, setup.truth, found)
        record["misfit"] = finite(_likelihood(problem, measurement, found))
        noise = measurement.noise
        if self.intervals != "none" and (noise is None or measurement.has_noise):
            true_x = setup.true_x if self.basin else None
            rng = generator(draw.seeds["diagnosis"]) if self.details else None
            noise = self._add_intervals(record, problem, measurement, found, true_x, rng)
        if noise is not None and not noise.is_absent and (self.details or not setup.truth):
            _add_bounds(record, problem, measurement, found.x, noise)
        if self.details:
            record["data"] = _description(measurement, plugins["measurement"].remarks)
            record["fit"] = fit_curves(problem, measurement, found.x, noise)
        if draw.with_curves:
            record["curves"] = response_curves(problem, measurement, setup.true_response(draw), found)
        if hidden := setup.hidden(draw):
            record["hidden"] = hidden
        return record

    def _add_intervals(
        self,
        record: dict[str, Any],
        problem: Problem,
        measurement: Measurement,
        found: Identification,
        true_x: Array | None,
        rng: np.random.Generator | None,
    ) -> Noise | None:
        """Put intervals, noise level and what they took into a record, and return the noise, estimated where it was not
        known; what cannot be computed costs no identification. With a generator the fit is tested too."""
        started = time.perf_counter()
        model = Model(problem)
        likelihood = Likelihood(model, measurement)
        try:
            nearest = nearest_maximum(likelihood, problem.parameters.to_cube(found.x))
            estimated = estimate(likelihood, nearest, level=self.level, check=self.intervals == "profile")
        except np.linalg.LinAlgError as error:
            record["interval"] = {"error": str(error)}
            return measurement.noise
        for facts, parameter, interval, likely in zip(
            problem.parameters, record["parameters"], estimated.intervals, estimated.x
        ):
            if facts.is_full_turn and not interval.high - interval.low < TURN:  # an angle that may be any
                interval = Interval(-np.inf, np.inf, "not identifiable")
            parameter |= {
                "low": finite(interval.low),
                "high": finite(interval.high),
                "interval": interval.kind,
                "likely": float(likely),
            }
        record["interval"] = {
            "level": self.level,
            "noise": {
                "relative": estimated.noise.relative,
                "floor": float(np.sqrt(np.mean(np.square(estimated.noise.floor)))),  # rms where each datum has its own
                "estimated": measurement.noise is None,
            },
            "model_evaluations": model.evaluations,
            "model_jacobians": model.jacobians,
            "seconds": time.perf_counter() - started,
        }
        if rng is not None:
            tested = fit_quality(Fit(problem, likelihood, estimated.point), rng)
            rejected = tested.p < LACK_OF_FIT_LEVEL
            record["lack_of_fit"] = {"p": tested.p, "statistic": tested.worst_statistic, "rejected": rejected}
        if true_x is not None:
            of_truth = nearest_maximum(likelihood, problem.parameters.to_cube(true_x))
            record["basin_excess"] = nearest.deviance - of_truth.deviance
        return estimated.noise


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
                "true": _nearest_turn(parameter, truth.get(parameter.name), float(value)),
                "identified": float(value),
                "at_bound": on_bound,
            }
            for parameter, value, on_bound in zip(parameters, found.x, found.at_limit)
        ],
        "updates": found.updates,
        "model_evaluations": found.model_evaluations,
        "model_jacobians": found.model_jacobians,
        "surrogate_evaluations": found.surrogate_evaluations,
        "seconds": dict(found.seconds),
        "history": [
            {
                "x": update.x.tolist(),
                "predicted_misfit": finite(update.predicted_misfit),
                "misfit": finite(update.misfit),
                "smc": finite(update.smc),
                "sdf": finite(update.sdf),
            }
            for update in found.history
        ],
        "notes": {name: finite(value) for name, value in found.notes.items()},
    }


def _within_a_turn(parameters: Parameters, found: Identification) -> Identification:
    """The same identification with angles that are free to turn in (−180°, 180°], far from the bounds of their search."""
    x = np.array([parameter.turned(value) for parameter, value in zip(parameters, found.x)])
    if np.array_equal(x, found.x):
        return found
    return dataclasses.replace(found, x=x, at_limit=at_limit(parameters.to_cube(x)))


def _nearest_turn(parameter: Parameter, true: float | None, identified: float) -> float | None:
    """The true value; of an angle that is free to turn, the one of its turns that is nearest to what was identified."""
    if true is None or not parameter.is_full_turn:
        return true
    return true + TURN * round((identified - true) / TURN)


def _add_bounds(record: dict[str, Any], problem: Problem, measurement: Measurement, x: Array, noise: Noise) -> None:
    """Put Cramér–Rao bounds and correlations at the identified values into a record; null where they are infinite."""
    try:
        told = identifiability(problem, x, noise, measurement.kind, noise_known=measurement.noise is not None)
    except np.linalg.LinAlgError:
        return
    for parameter, bound in zip(record["parameters"], told.crlb):
        parameter["bound"] = finite(float(bound))
    record["correlation"] = [[finite(float(value)) for value in row] for row in told.correlation]


def _description(measurement: Measurement, remarks: Sequence[str]) -> dict[str, Any]:
    """What was measured, as a report says it, SI."""
    return {
        "source": measurement.source,
        "kind": measurement.kind,
        "n_speed": len(measurement.speed),
        "speed_from": float(np.min(measurement.speed)),
        "speed_to": float(np.max(measurement.speed)),
        "channels": [str(channel) for channel in measurement.channels],
        "remarks": list(remarks),
    }
