"""Trace of a run: each improvement of the best misfit of the true model, and its cost.

It does not depend on the method.

The problem that a method is handed records it. A point counts once the true model has evaluated it, also on the way to a
Jacobian; a point that only a surrogate has evaluated is not an improvement. A method with a surrogate improves at its samples and
at the points that it adds. Points of one batch count one after the other. The misfit has one form whatever a method minimises
(`comparable_misfit`), so that traces of methods can be compared.

Predictions of a surrogate are counted here as well, and a method whose budget is spent ends with the best point of its trace.
"""

from __future__ import annotations

import copy
import dataclasses
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import MethodType
from typing import Any, TypeVar

import numpy as np

from ksmea.arrays import Array, ComplexArray
from ksmea.errors import BudgetSpent
from ksmea.likelihood.misfit import Misfit, deviance, reference_variance
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.observable import Observable
from ksmea.numerics.meter import SPENT_BEHIND, Meter
from ksmea.numerics.objective import ROUNDING
from ksmea.plugins.identification import Identification, Method, Stage, Streams, at_limit
from ksmea.plugins.surrogate import Predictor, Surrogate, Unsuited
from ksmea.problem.counted import CountedProblem
from ksmea.problem.parameters import Parameters
from ksmea.problem.problem import Problem
from ksmea.records.record import rounded
from ksmea.records.trace import StageRecord, TraceRecord, stage_number

# Improvements kept for each tenfold of evaluations and Jacobians, in each stage, at most: as many as COCO logs (N. Hansen et
# al., Optim. Methods Softw. 36 (2021) 114–144, doi 10.1080/10556788.2020.1808977).
STEPS_PER_DECADE = 20
DIGITS, SECONDS_DIGITS = 10, 4  # that are kept of misfits and values, and of times


def comparable_misfit(measurement: Measurement) -> Callable[[ComplexArray], Array]:
    """Function of responses (k, n_speed, n_channel), m, to the misfit (k,) by which methods are compared.

    It is the deviance (`ksmea.likelihood.misfit`). If the noise level is not known, the noise is taken as relative, at the
    level that fits the residuals of each response best; for data without noise it is the likelihood misfit
    (`ksmea.likelihood.misfit`).
    """
    noise, values, observable = measurement.noise, measurement.values, measurement.kind
    if noise is not None and noise.is_absent:
        misfit = Misfit(measurement, "likelihood")
        return lambda response: misfit.value(misfit.observed(response))
    measured = np.abs(values)
    reference = reference_variance(measured**2 if noise is None else noise.variance(measured), values)

    def deviances(response: ComplexArray) -> Array:
        amplitude = np.abs(response)
        seen = amplitude if observable is Observable.AMPLITUDE else response
        squared = np.abs(seen - values) ** 2
        variance = _fitting_variance(amplitude, squared) if noise is None else noise.variance(amplitude)
        return deviance(squared, variance, reference, observable, axis=(1, 2))

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
    """Counted problem that keeps each improvement among the points at the measured speeds and channels.

    Each has the count of predictions by surrogates until then (`predictions`).
    """

    def __init__(self, behind: Problem, measurement: Measurement, meter: Meter | None = None) -> None:
        super().__init__(behind, meter, self._keep)
        self.predictions = Meter()
        self.improvements: list[Improvement] = []
        self.points = 0  # that were compared with the measurement
        self._misfit = comparable_misfit(measurement)
        self._best = np.inf
        self._started = time.perf_counter()

    def _keep(self, x: Array, response: ComplexArray, first: int) -> None:
        """Keep improvements among points (k, d) SI with these responses.

        The first of them is evaluation `first`.
        """
        self.points += len(x)
        with np.errstate(all="ignore"):  # a response that is not finite is no improvement
            misfits = self._misfit(response)
        for index in np.flatnonzero(misfits < self._best):
            if misfits[index] < self._best:
                self._best = float(misfits[index])
                counts = first + int(index), self.meter.jacobians, self.predictions.evaluations
                seconds = time.perf_counter() - self._started
                self.improvements.append(Improvement(*counts, seconds, self._best, np.array(x[index])))


def thinned(improvements: Sequence[Improvement], stages: Sequence[Stage]) -> TraceRecord:
    """Record of a trace, thinned to the last improvement within each step of cost.

    Steps are of evaluations and Jacobians (`STEPS_PER_DECADE`), within a stage. Each is kept at its own count, so that
    none is dated too early.
    """
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
        misfit=tuple(rounded(each.misfit, DIGITS) for each in found),
        seconds=tuple(rounded(each.seconds, SECONDS_DIGITS) for each in found),
        x=tuple(tuple(rounded(value, DIGITS) for value in each.x) for each in found),
        stages=ends,
    )


AnyMethod = TypeVar("AnyMethod")


def with_counted_surrogate(method: AnyMethod, count: Meter) -> AnyMethod:
    """Method with counted predictions of its surrogate.

    Unchanged without a surrogate, or with one that is the true model.
    """
    surrogate = getattr(method, "surrogate", None)
    counted = _counted(surrogate, count)
    if counted is surrogate:
        return method
    copied = copy.copy(method)
    object.__setattr__(copied, "surrogate", counted)  # settings are frozen
    return copied


class _Counted:
    """Stands before a surrogate or a predictor and counts predictions.

    The one behind answers everything else, also members of the contract that have a default: hence no subclass of it,
    though an instance. Surrogates that its methods return are counted too.
    """

    def __init__(self, behind: Any, count: Meter) -> None:
        self.behind = behind
        self.count = count

    def __getattr__(self, name: str) -> Any:
        if name in ("behind", "count") or name.startswith("__"):  # of a copy in the making
            raise AttributeError(name)
        member = getattr(self.behind, name)
        if not isinstance(member, MethodType):
            return member

        def call(*arguments: Any, **named: Any) -> Any:
            return _counted(member(*arguments, **named), self.count)

        return call


@Predictor.register
class CountedPredictor(_Counted):
    """A predictor that counts the points it predicts."""

    def predict(self, u: Array) -> Array:
        return self.count.ask(u, self.behind.predict)

    def append(self, u: Array, y: Array) -> CountedPredictor | None:
        appended = self.behind.append(u, y)
        return None if appended is None else CountedPredictor(appended, self.count)


@Surrogate.register
class CountedSurrogate(_Counted):
    """A surrogate whose predictors count."""

    def fit(self, u: Array, y: Array, rng: np.random.Generator) -> CountedPredictor:
        return self._counted(lambda: self.behind.fit(u, y, rng))

    def refit(self, previous: Any, u: Array, y: Array, rng: np.random.Generator) -> CountedPredictor:
        bare = previous.behind if isinstance(previous, CountedPredictor) else previous
        return self._counted(lambda: self.behind.refit(bare, u, y, rng))

    def _counted(self, made: Callable[[], Predictor]) -> CountedPredictor:
        """A predictor that counts; so does what takes over where the surrogate is not suited."""
        try:
            return CountedPredictor(made(), self.count)
        except Unsuited as unsuited:
            unsuited.substitute = _counted(unsuited.substitute, self.count)
            raise


def _counted(surrogate: Any, count: Meter) -> Any:
    """A surrogate that counts; the true model, or anything else, as it is."""
    if not isinstance(surrogate, Surrogate) or surrogate.is_true_model:
        return surrogate
    return CountedSurrogate(surrogate, count)


def _require_within_limits(x: Array, parameters: Parameters) -> None:
    """Raise ValueError if a method returns other values than the search allows: no table should show them."""
    d = len(parameters)
    if np.iscomplexobj(x) or np.shape(x) != (d,):
        raise ValueError(f"method: expected {d} real values, got {np.shape(x)} of type {np.asarray(x).dtype}")
    u = parameters.to_cube(np.asarray(x, dtype=float))
    outside = (u < -ROUNDING) | (u > 1 + ROUNDING)  # what is not finite is another error
    if np.any(outside):
        name = parameters.names[int(np.argmax(outside))]
        raise ValueError(f"method: expected values within their search limits, got another of {name}")


def within_budget(method: Method, traced: TracedProblem, measurement: Measurement, streams: Streams) -> Identification:
    """Identification by a method within a budget.

    If the method requests more than the budget holds, the result is the best point that the true model has shown
    (`comparable_misfit`), whatever the method returns or raises then."""
    meter, started = traced.meter, time.perf_counter()
    found = None
    try:
        found = with_counted_surrogate(method, traced.predictions).identify(traced, measurement, streams)
    except Exception as error:
        if not (meter.was_refused or isinstance(error, BudgetSpent)):
            raise
    if found is not None and not meter.was_refused:
        _require_within_limits(found.x, traced.parameters)
        return found
    if not traced.improvements:
        raise ArithmeticError(
            f"none of the {traced.points} points of the method has a finite misfit"
            if traced.points
            else f"{SPENT_BEHIND}: no point was compared with the measurement"
        )
    best, total = traced.improvements[-1], time.perf_counter() - started
    at_best = at_limit(traced.parameters.to_cube(best.x))
    if found is None:
        return Identification(
            x=best.x,
            at_limit=at_best,
            misfit=best.misfit,
            stop="budget",
            updates=0,
            model_evaluations=meter.evaluations,
            model_jacobians=meter.jacobians,
            surrogate_evaluations=traced.predictions.evaluations,
            seconds={"model": meter.seconds, "surrogate": 0.0, "search": total - meter.seconds, "total": total},
        )
    last = (
        dataclasses.replace(stage, x=best.x, evaluations=meter.evaluations, jacobians=meter.jacobians)
        for stage in found.stages[-1:]
    )
    stages = (*found.stages[:-1], *last)
    return dataclasses.replace(found, x=best.x, at_limit=at_best, misfit=best.misfit, stop="budget", stages=stages)
