"""What a method finds with the evaluations that it is given."""

from __future__ import annotations

import dataclasses
import time

from ksmea.budget import Budget, BudgetedProblem
from ksmea.contracts import Method
from ksmea.counted_surrogate import PredictionCount
from ksmea.identification import Identification, Streams, at_limit
from ksmea.measurement import Measurement
from ksmea.trace import TracedProblem


def within_budget(
    method: Method,
    traced: TracedProblem,
    measurement: Measurement,
    streams: Streams,
    budget: Budget | None,
    predictions: PredictionCount,
) -> Identification:
    """What a method finds. Where it asks for more than the budget holds, that is the best point that the true model has shown
    (`ksmea.trace.comparable_misfit`), whatever the method returns or raises then."""
    if budget is None:
        return method.identify(traced, measurement, streams)
    started = time.perf_counter()
    found = None
    try:
        found = method.identify(BudgetedProblem(traced, budget), measurement, streams)
    except Exception:
        if not budget.was_refused:
            raise
    if found is not None and not budget.was_refused:
        return found
    if found is None:
        total, model = time.perf_counter() - started, traced.count.seconds
        found = _nothing(
            traced, predictions, {"model": model, "surrogate": 0.0, "search": total - model, "total": total}
        )
    return _best_so_far(found, traced)


def _nothing(traced: TracedProblem, predictions: PredictionCount, seconds: dict[str, float]) -> Identification:
    """What a method has found that did not return."""
    middle = (traced.parameters.lower + traced.parameters.upper) / 2
    return Identification(
        x=middle,
        at_limit=(),
        misfit=float("inf"),
        stop="budget",
        updates=0,
        model_evaluations=traced.count.evaluations,
        model_jacobians=traced.count.jacobians,
        surrogate_evaluations=predictions.points,
        seconds=seconds,
    )


def _best_so_far(found: Identification, traced: TracedProblem) -> Identification:
    """The same with the best point of the trace, as its last stage left it."""
    count = traced.count
    if not traced.improvements:
        raise ArithmeticError(f"none of the {count.evaluations} points of the method has a finite misfit")
    best = traced.improvements[-1]
    last = (
        dataclasses.replace(stage, x=best.x, evaluations=count.evaluations, jacobians=count.jacobians)
        for stage in found.stages[-1:]
    )
    return dataclasses.replace(
        found,
        x=best.x,
        at_limit=at_limit(traced.parameters.to_cube(best.x)),
        misfit=best.misfit,
        stop="budget",
        stages=(*found.stages[:-1], *last),
    )
