"""Identification: the values that a method finds from one measurement, with an interval beside each."""

from __future__ import annotations

import math
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
from ksmea.journal import Journal, journaled
from ksmea.measurement import Measurement
from ksmea.misfit import Misfit
from ksmea.parameters import Parameters
from ksmea.settings import Settings


@dataclass(frozen=True)
class Identify(Settings):
    """The values of the unknowns, found by the method from the measurement."""

    report: ClassVar[str] = "summary"
    ignores: ClassVar[tuple[str, ...]] = ()

    def validate(self, setup: Setup) -> None:
        plugins = setup.plugins
        plugins["method"].validate(setup.problem, plugins["surrogate"], plugins["optimizer"], setup.samples)

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        plugins, problem = setup.plugins, setup.problem
        measurement = plugins["measurement"].measure(plugins["problem"], setup.truth, generator(draw.seeds["noise"]))
        streams = Streams(*(generator(draw.seeds[component]) for component in ("design", "surrogate", "optimizer")))
        found = plugins["method"].identify(
            problem if draw.journal is None else journaled(problem, Journal(draw.journal)),
            measurement,
            plugins["surrogate"],
            plugins["optimizer"],
            setup.samples,
            streams,
        )
        record = _record(problem.parameters, setup.truth, found)
        record["misfit"] = _finite(_likelihood(problem, measurement, found))
        if draw.with_curves:
            true_response = plugins["measurement"].response(plugins["problem"], setup.truth)
            record["curves"] = response_curves(problem, measurement, true_response, found)
        return record


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
