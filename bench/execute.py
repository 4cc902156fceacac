"""One run: from its settings and seeds to its record. It is called in a worker process and returns plain data."""

from __future__ import annotations

import math
import time
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bench.curves import response_curves
from bench.plan import generator
from ksmea import registry
from ksmea.contracts import Problem
from ksmea.errors import SettingError
from ksmea.identification import Identification, Streams
from ksmea.journal import Journal, journaled
from ksmea.measurement import Measurement
from ksmea.misfit import Misfit
from ksmea.parameters import Parameters


def execute(
    settings: Mapping[str, Any],
    seeds: Mapping[str, list[int]],
    journal: Path | None = None,
    with_curves: bool = False,
) -> dict[str, Any]:
    """The record of a run; an error inside it is a record too, with its traceback.

    `with_curves` adds the response curves that figures are made of. With a journal, model evaluations that an earlier attempt finished are replayed from it.
    """
    started = time.perf_counter()
    try:
        record = _identify(settings, seeds, journal, with_curves)
    except (Exception, SystemExit) as error:  # a plugin that calls sys.exit costs its own run only
        record = {
            "status": "error",
            "error": f"{type(error).__name__}: {error}",
            "traceback": traceback.format_exc(),
        }
    return {**record, "elapsed": time.perf_counter() - started}


def plugins_of(settings: Mapping[str, Any]) -> dict[str, Any]:
    """The plugins that a run's settings name, their settings checked; a part that is ignored is None."""
    return {
        group: registry.create(group, settings[group]["name"], _without_name(settings[group]))
        if settings.get(group) is not None
        else None
        for group in registry.GROUPS
    }


def _without_name(settings: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in settings.items() if key != "name"}


def _identify(
    settings: Mapping[str, Any], seeds: Mapping[str, list[int]], journal: Path | None, with_curves: bool
) -> dict[str, Any]:
    plugins = plugins_of(settings)
    if "fingerprint" in settings and plugins["problem"].fingerprint() != settings["fingerprint"]:
        raise SettingError("the problem's file has changed since the experiment was planned; give its command again")
    problem = plugins["problem"].build()
    truth = plugins["measurement"].true_values(plugins["problem"], problem)
    measurement = plugins["measurement"].measure(plugins["problem"], truth, generator(seeds["noise"]))
    streams = Streams(*(generator(seeds[component]) for component in ("design", "surrogate", "optimizer")))
    found = plugins["method"].identify(
        problem if journal is None else journaled(problem, Journal(journal)),
        measurement,
        plugins["surrogate"],
        plugins["optimizer"],
        settings.get("samples") or 0,
        streams,
    )
    record = _record(problem.parameters, truth, found)
    record["misfit"] = _finite(_likelihood(problem, measurement, found))
    if with_curves:
        true_response = plugins["measurement"].response(plugins["problem"], truth)
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
