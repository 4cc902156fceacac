"""The trace of a run: each improvement of the best misfit that the true model has shown, and what it took until then.

The problem that a method is handed records it, whatever the method is or says. A point counts once the true model has
evaluated it, also on the way to a Jacobian. What a surrogate alone has seen is no improvement: a method with a surrogate
improves at its samples and at the points that it adds. Points of one batch count one after the other.

The misfit is the same whatever form a method minimises (`comparable_misfit`), so that traces of methods can be compared.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.contracts import Problem
from ksmea.counted_surrogate import PredictionCount
from ksmea.deviance import deviance, reference_variance
from ksmea.identification import Stage
from ksmea.kind import Kind
from ksmea.measurement import Measurement
from ksmea.misfit import Misfit
from ksmea.model import CountedProblem
from ksmea.records.trace import StageRecord, TraceRecord, stage_number

# Improvements kept for each tenfold of evaluations and Jacobians, in each stage, at most: as many as COCO logs (N. Hansen et
# al., Optim. Methods Softw. 36 (2021) 114–144, doi 10.1080/10556788.2020.1808977).
STEPS_PER_DECADE = 20
DIGITS, SECONDS_DIGITS = 10, 4  # that are kept of misfits and values, and of times


def comparable_misfit(measurement: Measurement) -> Callable[[ComplexArray], Array]:
    """What gives the misfit (k,) of responses (k, n_speed, n_channel), m, by which methods are compared.

    It is the deviance (`ksmea.deviance`). Where the noise's level is not known, it is taken as relative, at the level that fits the
    residuals of each response best; of data without noise it is the likelihood misfit (`ksmea.misfit`).
    """
    noise, values, kind = measurement.noise, measurement.values, measurement.kind
    if noise is not None and noise.is_absent:
        misfit = Misfit(measurement, "likelihood")
        return lambda response: misfit.value(misfit.observed(response))
    measured = np.abs(values)
    reference = reference_variance(measured**2 if noise is None else noise.variance(measured), values)

    def deviances(response: ComplexArray) -> Array:
        amplitude = np.abs(response)
        seen = amplitude if kind is Kind.AMPLITUDE else response
        squared = np.abs(seen - values) ** 2
        variance = _fitting_variance(amplitude, squared) if noise is None else noise.variance(amplitude)
        return deviance(squared, variance, reference, kind, axis=(1, 2))

    return deviances


def _fitting_variance(amplitude: Array, squared: Array) -> Array:
    """Variances (k, n_speed, n_channel), m², of relative noise at the most likely level of each response."""
    level = np.mean(squared / amplitude**2, axis=(1, 2), keepdims=True)
    return np.asarray(np.maximum(level, np.finfo(float).tiny) * amplitude**2)


@dataclass(frozen=True)
class Improvement:
    """A point x (d,) SI with a lower misfit than all before it, and what all until then took."""

    evaluations: int
    jacobians: int
    surrogate_evaluations: int
    seconds: float
    misfit: float
    x: Array


class TracedProblem(CountedProblem):
    """A counted problem that keeps each improvement among the points it is asked for at the measured speeds and channels."""

    def __init__(self, behind: Problem, measurement: Measurement, predictions: PredictionCount) -> None:
        super().__init__(behind)
        self.improvements: list[Improvement] = []
        self._misfit = comparable_misfit(measurement)
        self._predictions = predictions
        self._best = np.inf
        self._started = time.perf_counter()

    def response(self, x: Array) -> ComplexArray:
        before = self.count.evaluations
        response = super().response(x)
        self._keep(x, response, before + 1)
        return response

    def linearised(self, x: Array) -> tuple[ComplexArray, ComplexArray]:
        response, sensitivity = super().linearised(x)
        self._keep(x[None], response[None], self.count.evaluations)
        return response, sensitivity

    def _keep(self, x: Array, response: ComplexArray, first: int) -> None:
        """Keep what is better among points (k, d) SI with these responses, the first of which is evaluation `first`."""
        with np.errstate(all="ignore"):  # a response that is not finite is no improvement
            misfits = self._misfit(response)
        for index in np.flatnonzero(misfits < self._best):
            if misfits[index] < self._best:
                self._best = float(misfits[index])
                counts = first + int(index), self.count.jacobians, self._predictions.points
                seconds = time.perf_counter() - self._started
                self.improvements.append(Improvement(*counts, seconds, self._best, np.array(x[index])))


def thinned(improvements: Sequence[Improvement], stages: Sequence[Stage]) -> TraceRecord:
    """The record of a trace: of the improvements of a stage within a step of evaluations and Jacobians (`STEPS_PER_DECADE`)
    the last, at its own count, so that none is dated too early."""
    ends = tuple(
        StageRecord(each.name, each.evaluations, each.jacobians, tuple(map(float, each.x)), None, each.on_surrogate)
        for each in stages
    )
    kept = {}
    for each in improvements:
        step = int(np.log10(each.evaluations + each.jacobians) * STEPS_PER_DECADE)
        kept[stage_number(ends, each.evaluations, each.jacobians), step] = each
    found = list(kept.values())
    return TraceRecord(
        evaluations=tuple(each.evaluations for each in found),
        jacobians=tuple(each.jacobians for each in found),
        surrogate_evaluations=tuple(each.surrogate_evaluations for each in found),
        misfit=tuple(_rounded(each.misfit, DIGITS) for each in found),
        seconds=tuple(_rounded(each.seconds, SECONDS_DIGITS) for each in found),
        x=tuple(tuple(_rounded(value, DIGITS) for value in each.x) for each in found),
        stages=ends,
    )


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")
