"""Diagnosis: what the model gets wrong about a measurement, which physical cause mends it, and what that is worth."""

from __future__ import annotations

import dataclasses
import threading
import time
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from tqdm import tqdm

from bench.plan.draw import Draw
from bench.plan.plan import generator
from bench.plan.setup import Setup
from bench.plan.study import Study
from ksmea import registry
from ksmea.contracts import Effect
from ksmea.diagnosis.diagnosis import Diagnosis, diagnose
from ksmea.diagnosis.fit_quality import FitQuality, whirl_parts
from ksmea.diagnosis.fitting import Effort, Fit, fit_from_values
from ksmea.diagnosis.trials import Candidate, Trial, candidates
from ksmea.errors import SettingError, unknown
from ksmea.intervals import Estimate, estimate
from ksmea.measurement import Measurement, Noise
from ksmea.parameters import Parameter
from ksmea.records.record import finite
from ksmea.settings import setting

AT_BOUND = 1e-3  # parts of the range within which a value lies on its bound


@dataclass(frozen=True)
class Diagnose(Study):
    """What the model gets wrong about the measurement, why, and what an extension is worth."""

    level: float = setting(
        0.01,
        "chance of speaking against a right model; 4000 simulations tell no smaller one",
        at_least=0.002,
        at_most=0.5,
    )
    interval_level: float = setting(0.95, "confidence level of intervals", above=0, at_most=0.9999)
    effects: list[str] = setting([], "names of the effects that are tried; an empty list: all that are registered")
    without: list[str] = setting([], "names of effects that are not tried")
    blocks: int = setting(6, "contiguous blocks of speeds that are left out in turn to measure the gain", at_least=2)
    screening: int = setting(4096, "points of the plain model's box that are screened", at_least=64)
    starts: int = setting(12, "fits of the plain model from the best of them", at_least=1)
    scan: int = setting(
        200, "of these points, those that are screened again at values of an effect, most of them the best", at_least=1
    )
    scan_values: int = setting(
        16,
        "values of an effect with one unknown, all over its bounds; twice as many for each further unknown",
        at_least=1,
    )
    effect_starts: int = setting(5, "fits of each effect from the best of those", at_least=1)

    report: ClassVar[str] = "diagnosis"
    ignores: ClassVar[tuple[str, ...]] = ("samples", "surrogate", "optimizer", "method")

    @property
    def parts(self) -> list[Effect]:
        return list(self._chosen().values())

    def validate(self, setup: Setup) -> None:
        noise = setup.plugins["measurement"].noise
        if noise is not None and noise.is_absent:
            raise SettingError(
                "study=diagnose: expected noise, without which any difference is a misfit, got none; say"
                " measurement.relative=0.05 or measurement.floor=0.1 (µm)"
            )
        try:
            found = candidates(setup.problem, self._chosen())
        except AttributeError as error:
            kind = type(setup.problem).__name__
            raise SettingError(
                f"study=diagnose: expected a problem that effects can be added to, got {kind}"
            ) from error
        if not found:
            raise SettingError(
                "study.effects: expected effects that this problem has a place for and does not have already, got none"
            )
        n_data = len(setup.problem.speed) * len(setup.problem.channels)
        least = 2 * len(setup.problem.parameters)
        if n_data < least:
            raise SettingError(
                f"study=diagnose: expected at least {least} data, twice the unknowns, got {n_data}; measure more speeds"
            )

    def run(self, setup: Setup, draw: Draw) -> dict[str, Any]:
        started = time.perf_counter()
        measurement = setup.measure(draw)
        effects = self._chosen()
        tqdm.set_lock(threading.RLock())  # a lock between processes would outlive this worker
        n_candidate = len(candidates(setup.problem, effects))
        steps = 1 + 3 * n_candidate + self.blocks  # candidates are tried, searched, and tried as second effects
        with tqdm(total=steps, desc="diagnosis", disable=None if draw.with_progress else True) as bar:

            def progress() -> None:
                bar.total = max(bar.total, bar.n + 1)
                bar.update()

            found = diagnose(
                setup.problem,
                measurement,
                effects,
                generator(draw.seeds["diagnosis"]),
                level=self.level,
                effort=self._effort,
                n_block=self.blocks,
                interval_level=self.interval_level,
                progress=progress,
            )
            bar.update(max(bar.total - bar.n, 0))
        return {
            "status": "done",
            **diagnosis_record(found, measurement, self.interval_level),
            "hidden": setup.hidden(draw),
            "hidden_fall": _fall_of_truth(setup, draw, measurement, found.plain),
            "seconds": time.perf_counter() - started,
        }

    @property
    def _effort(self) -> Effort:
        return Effort(
            screening=self.screening,
            starts=self.starts,
            scan=self.scan,
            scan_values=self.scan_values,
            effect_starts=self.effect_starts,
        )

    def _chosen(self) -> dict[str, Effect]:
        known = list(registry.registered("effect"))
        for name in (*self.effects, *self.without):
            if name not in known:
                raise unknown("effect", name, known)
        return {name: registry.create("effect", name, {}) for name in self.effects or known if name not in self.without}


def _fall_of_truth(setup: Setup, draw: Draw, measurement: Measurement, plain: Fit) -> float | None:
    """How far the deviance falls from the plain model's fit to that of the model that made the data, fitted from its true
    values: how plain to see is what the data hide. None where nothing is hidden."""
    truth = setup.with_hidden(draw)
    return None if truth is None else plain.deviance - fit_from_values(*truth, measurement).deviance


def diagnosis_record(found: Diagnosis, measurement: Measurement, level: float) -> dict[str, Any]:
    """A diagnosis as JSON data; values of parameters in their units."""
    return {
        "verdict": found.verdict,
        "named": list(found.named),
        "class": list(found.alike),
        "places": list(found.places),
        "applied": [_effect(candidate) for candidate in found.applied],
        "ranking": [_trial(trial, level) for trial in found.trials],
        "lack_of_fit": {
            "before": _quality(found.plain_quality, found.plain, measurement),
            "after": None
            if found.best_quality is None or found.best is None
            else _quality(found.best_quality, found.best, measurement),
            "level": found.level / 2,
        },
        "noise": {
            "known": measurement.noise is not None,
            "by_datum": measurement.noise is not None and np.ndim(measurement.noise.floor) > 0,
            "before": _noise(found.plain.noise),
            "after": None if found.best is None else _noise(found.best.noise),
        },
        "coefficients": _coefficients(found),
        "gain": None
        if found.gain is None
        else {
            "log_score": found.gain.log_score,
            "standard_error": found.gain.standard_error,
            "by_block": found.gain.by_block.tolist(),
            "rmse_before": found.gain.rmse_before,
            "rmse_after": found.gain.rmse_after,
            "is_proven": found.gain.is_proven,
        },
        "min_detectable": {
            name: [
                {
                    "place": place,
                    "parameter": each.parameter.name,
                    "unit": each.parameter.unit,
                    "size": finite(each.size / each.parameter.si_per_unit),
                    "largest": each.largest / each.parameter.si_per_unit,
                    "observable": each.is_observable,
                }
                for each in parts
            ]
            for name, (place, parts) in found.detectable.items()
        },
        "split": None if found.split is None else dict(vars(found.split)),
        "likeness": dict(found.likeness),
        "aliases": {name: text for candidate in found.applied for name, text in candidate.effect.aliases.items()},
        "tried": list(dict.fromkeys(trial.name for trial in found.trials)),
        "curves": _curves(found, measurement),
    }


def _effect(candidate: Candidate) -> dict[str, Any]:
    """What a problem file needs to have this effect at its place."""
    settings = dataclasses.asdict(candidate.effect)
    return {"name": candidate.name, "place": str(candidate.effect), "settings": settings}


def _trial(trial: Trial, level: float) -> dict[str, Any]:
    estimated = estimate(trial.fit.likelihood, trial.fit.point, level=level, check=False)
    own = range(trial.fit.likelihood.d - trial.n_unknown, trial.fit.likelihood.d)
    return {
        "effect": trial.name,
        "place": str(trial.candidate.effect),
        "fall": trial.fall,
        "delta_bic": trial.delta_bic,
        "p": trial.p,
        "parameters": [_value(trial.fit.problem.parameters.items[index], estimated, index) for index in own],
    }


def _value(parameter: Parameter, estimated: Estimate, index: int) -> dict[str, Any]:
    """An estimate with its interval, in the parameter's unit; an angle that may be any between −180° and 180°."""
    interval, value = estimated.intervals[index], float(estimated.x[index])
    turn = value - parameter.turned(value)
    near = AT_BOUND * (parameter.upper - parameter.lower)
    return {
        "name": parameter.name,
        "unit": parameter.unit,
        "value": (value - turn) / parameter.si_per_unit,
        "low": finite((interval.low - turn) / parameter.si_per_unit),
        "high": finite((interval.high - turn) / parameter.si_per_unit),
        "interval": interval.kind,
        "at_bound": bool(min(value - parameter.lower, parameter.upper - value) <= near),
    }


def _coefficients(found: Diagnosis) -> list[dict[str, Any]]:
    """Every unknown before and after the extension; those of effects have no before."""
    n_plain = len(found.plain.problem.parameters)
    rows = []
    items = (found.best or found.plain).problem.parameters.items
    for index, parameter in enumerate(items):
        rows.append(
            {
                "name": parameter.name,
                "before": _value(parameter, found.plain_estimate, index) if index < n_plain else None,
                "after": None if found.best_estimate is None else _value(parameter, found.best_estimate, index),
            }
        )
    return rows


def _quality(quality: FitQuality, fit: Fit, measurement: Measurement) -> dict[str, Any]:
    return {
        "p": quality.p,
        "p_by_statistic": quality.p_by_statistic,
        "statistic": quality.worst_statistic,
        "reduced_chi2": quality.reduced_chi2,
        "band": list(quality.worst_band),
        "channel": str(measurement.channels[quality.worst_channel]),
        "excess": quality.worst_excess,
        "whirl": _whirl(quality, measurement),
    }


def _whirl(quality: FitQuality, measurement: Measurement) -> dict[str, list[float]]:
    """Mean squares of the residuals' forward and backward parts by plane, in units of the noise."""
    if measurement.is_amplitude:
        return {}
    parts = whirl_parts(quality.residuals, measurement.channels)
    return {f"{position:g}": np.mean(np.abs(both) ** 2, axis=1).tolist() for position, both in parts.items()}


def _curves(found: Diagnosis, measurement: Measurement) -> dict[str, Any]:
    """What figures are drawn from: real and imaginary parts, m; residuals in units of the noise."""
    curves = {"measured": measurement.values, "before": measurement.seen(found.plain.response())}
    residuals = {"before": found.plain_quality.residuals}
    if found.best is not None and found.best_quality is not None:
        curves["after"] = measurement.seen(found.best.response())
        residuals["after"] = found.best_quality.residuals
    return {
        "speed": measurement.speed.tolist(),
        "channels": [str(channel) for channel in measurement.channels],
        "responses": {name: _parts(values) for name, values in curves.items()},
        "residuals": {name: _parts(values) for name, values in residuals.items()},
    }


def _parts(values: Any) -> list[Any]:
    """Complex values as pairs of real and imaginary parts, real ones as they are, to five digits."""
    parts = np.stack([values.real, values.imag], axis=-1) if np.iscomplexobj(values) else values
    return np.vectorize(lambda value: float(f"{value:.5g}"))(parts).tolist()


def _noise(noise: Noise) -> dict[str, Any]:
    return {"relative": float(noise.relative), "floor": float(np.median(noise.floor))}
