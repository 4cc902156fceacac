"""Progress of a method over its cost.

Misfit and errors of the best point so far against what it took, over all runs of a cell.

The cost of a point is the evaluations and Jacobians of the true model until then, a Jacobian at its price in the study's budget;
without one at the method's `jacobian_cost`, or where that is 0 at `JACOBIAN_AS_EVALUATIONS`. A run keeps what it has when it ends. One that has nothing yet, or has failed, counts
as infinitely far, so that medians and quartiles are of all planned runs.

The excess is the misfit above that at the maximum of the likelihood nearest to the truth, or where nobody knows that at the maximum
that the run's intervals belong to: a deviance, whatever the problem. Below about 1 the data hardly tell the point from that
maximum.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from bench.jobs.lines import RunLine
from bench.jobs.records import read_records
from bench.plan.naming import place_columns
from bench.plan.plan import Cell, Plan
from ksmea.arrays import Array
from ksmea.numerics.meter import JACOBIAN_AS_EVALUATIONS
from ksmea.records.identification import IdentificationRecord
from ksmea.records.trace import TraceRecord

STEPS_PER_DECADE = 20  # rows of the table for each tenfold of the cost, as many as a trace keeps
QUARTILES = (0.25, 0.5, 0.75)
COLUMNS = ("excess", "error")
OF_STAGES = ("stage", "on_surrogate", "evaluations", "jacobians", "excess", "error", "runs")


@dataclass(frozen=True)
class Traced:
    """A run's trace, and what the whole run took of the true model."""

    trace: TraceRecord
    evaluations: int
    jacobians: int

    def costs(self, price: int) -> Array:
        """(n,) evaluations until each improvement, a Jacobian at its price."""
        return np.array(self.trace.evaluations) + price * np.array(self.trace.jacobians)

    def cost(self, price: int) -> int:
        """Cost of the whole run."""
        return self.evaluations + price * self.jacobians

    @property
    def excess(self) -> Array:
        """(n,); not a number where nobody knows the maximum."""
        excess = self.trace.excess
        return np.full(len(self.trace.misfit), np.nan) if excess is None else excess

    @property
    def error(self) -> Array:
        """(n,) in units of the CRLB; not a number where nobody knows it."""
        return np.array(self.trace.error) if self.trace.error else np.full(len(self.trace.misfit), np.nan)


def read_traces(plan: Plan, output: Path) -> dict[str, Traced]:
    """The trace of each run that has one, by key."""
    found = read_records(output, _traced, plan)
    return {key: traced for key, traced in found.items() if traced is not None}


def _traced(line: RunLine) -> Traced | None:
    record = line.record(IdentificationRecord) if line.has_result else None
    if record is None or record.trace is None:
        return None
    trace = record.trace
    if trace.least is None and record.intervals is not None and not record.intervals.noise.estimated:
        trace = dataclasses.replace(trace, least=record.deviance)
    return Traced(trace, record.model_evaluations, record.model_jacobians)


def jacobian_price(cell: Cell) -> int:
    """Evaluations that one Jacobian of a cell's method counts as."""
    study = cell.settings.get("study") or {}
    if study.get("budget") is not None:
        return int(study["jacobian_cost"])
    return cell.settings["method"].get("jacobian_cost") or JACOBIAN_AS_EVALUATIONS


def trace_frame(plan: Plan, traces: Mapping[str, Traced]) -> pd.DataFrame:
    """A row for each cell and cost.

    Quartiles over its runs of excess and error, and medians of what else it took until then.
    """
    rows = []
    for index, cell in enumerate(plan.cells):
        planned = [run for run in plan.runs if run.cell == index]
        runs = [traces[run.key] for run in planned if run.key in traces]
        price = jacobian_price(cell)
        for cost in _grid(max((each.cost(price) for each in runs), default=0)):
            reached = [(each, int(np.searchsorted(each.costs(price), cost, side="right")) - 1) for each in runs]
            rows.append(
                {
                    "cell": index,
                    **place_columns(plan, cell),
                    "jacobian_price": price,
                    "cost": cost,
                    **{name: value for column in COLUMNS for name, value in _quartiles(column, reached, planned).items()},
                    "surrogate_evaluations": _median([each.trace.surrogate_evaluations[at] for each, at in reached if at >= 0]),
                    "seconds": _median([each.trace.seconds[at] for each, at in reached if at >= 0]),
                    "runs": len(planned),
                    "without": len(planned) - sum(at >= 0 for _, at in reached),
                }
            )  # fmt: skip
    return pd.DataFrame(rows)


def stages_frame(plan: Plan, traces: Mapping[str, Traced]) -> pd.DataFrame:
    """A row for each cell and stage of its method, as it ended.

    Medians over its runs of what all until then took, of the excess of the best point until then that the true model
    has evaluated, and of the error of the point that the stage left to the next. Stages on a surrogate, the search and
    its polish, belong to the last updating step.
    """
    rows = []
    for index, cell in enumerate(plan.cells):
        runs = [traces[run.key] for run in plan.runs if run.cell == index and run.key in traces]
        for stage in dict.fromkeys(stage.name for each in runs for stage in each.trace.stages):
            ended = [(each, end) for each in runs for end in each.trace.stages if end.name == stage]
            excesses = [
                each.excess[at]
                for each, end in ended
                if (at := _last(each.trace, end.evaluations, end.jacobians)) is not None
            ]
            rows.append(
                {
                    "cell": index,
                    **place_columns(plan, cell),
                    "stage": stage,
                    "on_surrogate": any(end.on_surrogate for _, end in ended),
                    "evaluations": _median([end.evaluations for _, end in ended]),
                    "jacobians": _median([end.jacobians for _, end in ended]),
                    "excess": _median(excesses),
                    "error": _median([np.nan if end.error is None else end.error for _, end in ended]),
                    "runs": len(ended),
                }
            )
    return pd.DataFrame(rows, columns=["cell", *plan.axes, *OF_STAGES])


def _grid(most: int) -> list[int]:
    """Costs from 1 to `most`, evenly spaced in their logarithms."""
    if most < 1:
        return []
    steps = np.arange(STEPS_PER_DECADE * np.log10(most))
    return sorted({*np.rint(10 ** (steps / STEPS_PER_DECADE)).astype(int).tolist(), most})


def _last(trace: TraceRecord, evaluations: int, jacobians: int) -> int | None:
    """The number of the last improvement until these counts, None before the first."""
    within = np.flatnonzero((np.array(trace.evaluations) <= evaluations) & (np.array(trace.jacobians) <= jacobians))
    return int(within[-1]) if len(within) else None


def _quartiles(column: str, reached: list[tuple[Traced, int]], planned: list[Any]) -> dict[str, float]:
    """Quartiles over the planned runs; what has nothing yet counts as infinite.

    Not a number where nobody knows the values.
    """
    values = [getattr(each, column)[at] for each, at in reached if at >= 0]
    if any(np.isnan(values)):
        values = [np.nan]
    else:
        values += [np.inf] * (len(planned) - len(values))
    found = np.quantile(values, QUARTILES, method="median_unbiased" if np.all(np.isfinite(values)) else "higher")
    return {f"{column}_{name}": float(value) for name, value in zip(("q1", "median", "q3"), found)}


def _median(values: list[Any]) -> float:
    return float(np.median(values)) if values else np.nan
