"""The table of runs: a row per planned run with what became of it and what it identified."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from bench.jobs.lines import RunLine
from bench.jobs.records import NOT_RUN, read_records
from bench.plan.naming import place_columns
from bench.plan.plan import Plan, Run
from ksmea.errors import SettingError
from ksmea.records.identification import IdentificationRecord, IntervalEffort, ParameterRecord
from ksmea.show.text import HIDDEN_COLUMN, hidden_in_one_line

FITTED_INPUTS = "fitted_inputs"  # numbers known to a tolerance in a joint fit


def runs_frame(plan: Plan, output: Path) -> pd.DataFrame:
    """A row for every planned run, in the order of the plan; values in the units of the parameters."""
    rows = read_records(output, lambda line: _line_row(line, plan.report.exact), plan)
    not_run = {"status": NOT_RUN, "error": ""}
    return pd.DataFrame([_place_row(plan, run) | rows.get(run.key, not_run) for run in plan.runs])


def of_identifications(plan: Plan, output: Path) -> pd.DataFrame:
    """A row for every planned identification, with one reported value of each unknown.

    `kxx_value` is the reported value, `kxx_search_end` the end of the method's search, which tables of methods compare
    as `kxx`.
    """
    runs = runs_frame(plan, output)
    unknowns = dict.fromkeys(facts.name for cell in plan.cells for facts in cell.parameters)
    for name in unknowns.keys() & set(runs.columns):
        search_end = runs[name]
        likely = f"{name}_most_likely"
        runs[name] = runs[likely].fillna(search_end) if likely in runs else search_end
        _put_beside(runs, name, [f"{likely}_at_limit", f"{name}_at_limit"])
        runs.insert(runs.columns.get_loc(f"{name}_error_pct"), f"{name}_search_end", search_end)
        runs = runs.drop(columns=likely, errors="ignore").rename(
            columns={name: f"{name}_value", f"{name}_error_pct": f"{name}_search_end_error_pct"}
        )
    return runs


def _put_beside(runs: pd.DataFrame, name: str, flags: Sequence[str]) -> None:
    """Put one column NAME_at_limit behind the value that it flags.

    It has the values of the first of these columns that has one.
    """
    found = [runs.pop(flag) for flag in flags if flag in runs]
    if found:
        whole = found[0] if len(found) == 1 else found[0].where(found[0].notna(), found[1])
        runs.insert(runs.columns.get_loc(name) + 1, f"{name}_at_limit", whole)


def _place_row(plan: Plan, run: Run) -> dict[str, Any]:
    cell = plan.cells[run.cell]
    return {
        "key": run.key,
        "cell": run.cell,
        **place_columns(plan, cell),
        "seed": cell.seed,
        "repetition": run.repetition,
    }


def _line_row(line: RunLine, exact: float | None) -> dict[str, Any]:
    """Row of runs.csv for a run, its names shared among all rows."""
    found = _result_row(line.record(IdentificationRecord), exact) if line.has_result else {}
    return {"status": sys.intern(line.status), **found, "error": line.error}


def _result_row(record: IdentificationRecord, exact: float | None) -> dict[str, Any]:
    row: dict[str, Any] = {}
    for parameter in record.parameters:
        name = parameter.name
        row[sys.intern(name)] = parameter.in_unit(parameter.identified)
        row[sys.intern(f"{name}_error_pct")] = parameter.error_pct
        if parameter.crlb is not None:
            row[sys.intern(f"{name}_crlb")] = parameter.in_unit(parameter.crlb)
        if parameter.most_likely is None:  # else the flag is of that value
            row[sys.intern(f"{name}_at_limit")] = parameter.at_limit
        if parameter.kind is not None:
            row |= _interval_columns(parameter, parameter.kind)
    seconds = record.seconds
    row |= {
        "misfit": record.misfit,
        "stop": sys.intern(record.stop),
        "updates": record.updates,
        "model_evaluations": record.model_evaluations,
        "model_jacobians": record.model_jacobians,
        "surrogate_evaluations": record.surrogate_evaluations,
        "time_model": seconds.model,
        "time_surrogate": seconds.surrogate,
        "time_search": seconds.search,
        "time": seconds.total,
    }
    if record.intervals is not None:
        row |= _interval_effort(record.intervals)
        row |= {"search_excess": record.search_excess, "ended_short": record.ended_short}
    if record.inputs:
        row[FITTED_INPUTS] = len(record.inputs)
    if record.trace is not None:
        row["stage"] = sys.intern(record.stage)
    if gains := [update.polish_gain for update in record.history if update.polish_gain is not None]:
        row["polish_gain"] = float(np.median(gains))
    if record.hidden:
        row[HIDDEN_COLUMN] = hidden_in_one_line(record.hidden)
    if record.remarks:
        row["remarks"] = "; ".join(record.remarks)
    if record.basin_excess is not None:
        row["basin_excess"] = record.basin_excess
    if exact is not None and all(parameter.true for parameter in record.parameters):
        row |= _exactness(record, exact)
    return row


def _interval_columns(parameter: ParameterRecord, basis: str) -> dict[str, Any]:
    """Most likely value, ends of its interval in the parameter's unit, basis and coverage.

    Ends are empty if open, coverage is empty if the true value is not known.
    """
    name = parameter.name
    return {
        sys.intern(f"{name}_most_likely"): parameter.in_unit(parameter.most_likely),
        sys.intern(f"{name}_most_likely_at_limit"): parameter.at_limit,
        sys.intern(f"{name}_low"): parameter.in_unit(parameter.low),
        sys.intern(f"{name}_high"): parameter.in_unit(parameter.high),
        sys.intern(f"{name}_interval"): sys.intern(basis),
        sys.intern(f"{name}_covered"): parameter.is_covered,
    }


def _interval_effort(effort: IntervalEffort) -> dict[str, Any]:
    """Noise that the intervals were made with, and what they took."""
    return {
        "noise_relative": effort.noise.relative,
        "noise_floor": effort.noise.floor,
        "interval_evaluations": effort.model_evaluations,
        "interval_jacobians": effort.model_jacobians,
        "interval_seconds": effort.seconds,
    }


def _exactness(record: IdentificationRecord, exact: float) -> dict[str, Any]:
    """Whether all parameters came within `exact` per cent (100 or 0), and the first step at which.

    It is an updating step.
    """
    true = np.array([parameter.true for parameter in record.parameters])
    steps = [_worst_error_pct(update.x, true) <= exact for update in record.history]
    return {
        "exact": 100.0 * (_worst_error_pct(record.x, true) <= exact),
        "updates_to_exact": steps.index(True) + 1 if True in steps else None,
    }


def _worst_error_pct(x: Sequence[float] | np.ndarray, true: np.ndarray) -> float:
    return float(100 * np.max(np.abs(np.asarray(x) / true - 1)))


def without_class(error: str) -> str:
    """Why a run has no result, in a sentence.

    The class of an error that is a sentence by itself is left out.

    >>> without_class("SettingError: expected one"), without_class("ValueError: singular")
    ('expected one', 'ValueError: singular')
    """
    return error.removeprefix(f"{SettingError.__name__}: ")
