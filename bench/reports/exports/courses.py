"""Course of each run for other programs.

Numbers for functions and instances, one axis of cost, one value at each.

A *function* is a family of instances, an *algorithm* a method, as in a contest (`bench.reports.contest.cells`). The
cost is the evaluations of the true model and its Jacobians at their price, as in `bench.reports.identification.trace_table`.

Readers distinguish runs by a first row at cost 1, and need a last one at the cost of the whole run. So a run that had no finite
value there has `NOTHING` at cost 1, and a failed one nothing else, at the cost of its budget. `write_table` writes all courses as one
long table: a row for each improvement and end of a run.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS
from bench.jobs.records import ended_statuses, record_types
from bench.plan.naming import place_columns, place_text
from bench.plan.plan import Plan
from bench.reports.contest.cells import OF_INSTANCE, budget, family, identity, method_name
from bench.reports.identification.trace_table import Traced, jacobian_price, read_traces
from bench.reports.tables import csv_text
from ksmea.arrays import Array
from ksmea.errors import SettingError
from ksmea.records.identification import IdentificationRecord

NOTHING = 3e21  # what counts as infinite in the data of COCO (`cocopp.testbedsettings.inf_like`): readers take no infinite number
COLUMNS = ("cost", "excess", "error", "evaluations", "jacobians", "surrogate_evaluations", "seconds")


@dataclass(frozen=True)
class Place:
    """Algorithm, function and instance of a run: names, and numbers from 1. `unknowns` is the dimension."""

    algorithm: str
    family: str
    function: int
    instance: int
    unknowns: int


@dataclass(frozen=True)
class Course:
    """A run's values (n, column) at its improvements and its end (`COLUMNS`), costs rising from 1."""

    place: Place
    seed: int
    repetition: int
    jacobian_price: int
    values: Array

    @property
    def costs(self) -> Array:
        return self.values[:, COLUMNS.index("cost")]

    @property
    def excess(self) -> Array:
        return self.values[:, COLUMNS.index("excess")]


@dataclass(frozen=True)
class Courses:
    """All courses in the order of the plan.

    `instances` says what the numbers are; `n_left_out` runs have none: they have not been done, have no trace, or
    nobody knows the maximum that their excess is above.
    """

    experiment: str
    commit: str
    courses: tuple[Course, ...]
    instances: pd.DataFrame
    n_left_out: int


def grouped(courses: Iterable[Course], *names: str) -> list[tuple[tuple[Any, ...], list[Course]]]:
    """Courses by what their places have of these names, in the order of the first of each."""
    found: dict[tuple[Any, ...], list[Course]] = {}
    for course in courses:
        found.setdefault(tuple(getattr(course.place, name) for name in names), []).append(course)
    return [*found.items()]


def read_courses(plan: Plan, output: Path) -> Courses:
    """The courses of the runs of a plan; `SettingError` if it is of another study, or has none."""
    if {*record_types(plan).values()} - {IdentificationRecord}:
        raise SettingError(
            f"{output}: expected identifications, got records of another study; export has no traces of those"
        )
    found = courses(plan, read_traces(plan, output), ended_statuses(output, plan))
    if not found.courses:
        raise SettingError(
            f"{output}: expected runs with traces above a known maximum, got none; give the experiment's command again"
        )
    return found


def courses(plan: Plan, traces: Mapping[str, Traced], statuses: Mapping[str, str]) -> Courses:
    """The courses of runs by their traces and statuses, both by key."""
    places, instances = _places(plan)
    budgets = _budgets(plan, traces)
    found: list[Course] = []
    for run in plan.runs:
        cell, price = plan.cells[run.cell], jacobian_price(plan.cells[run.cell])
        values = _values(traces.get(run.key), price)
        if values is None and run.key in statuses and statuses[run.key] not in RESULTS:
            values = _failed(budgets[run.cell])
        if values is not None:
            found.append(Course(places[run.cell], cell.seed, run.repetition, price, values))
    return Courses(plan.name, plan.commit, tuple(found), instances, len(plan.runs) - len(found))


def _values(traced: Traced | None, price: int) -> Array | None:
    """The values of a run; None without a trace or without an excess."""
    if traced is None or np.isnan(traced.excess).any():
        return None
    trace = traced.trace
    counts = np.array([trace.evaluations, trace.jacobians, trace.surrogate_evaluations], dtype=float)
    costs = np.maximum(traced.costs(price), 1.0)
    values = np.column_stack([costs, traced.excess, traced.error, *counts, trace.seconds])
    values = values[np.append(np.diff(costs) > 0, True)[: len(costs)]]  # of several at one cost the last
    if len(values) == 0 or values[0, 0] > 1:
        values = np.vstack([_nothing(1.0)[None], values])
    total = traced.cost(price)
    if total > values[-1, 0]:
        end = [total, *values[-1, 1:3], traced.evaluations, traced.jacobians, np.nan, np.nan]  # which no trace tells
        values = np.vstack([values, end])
    return np.asarray(values)


def _nothing(cost: float) -> Array:
    return np.array([cost, NOTHING, np.nan, cost, 0.0, 0.0, 0.0])


def _failed(budget: float) -> Array:
    return np.array([_nothing(cost) for cost in ((1.0, budget) if budget > 1 else (1.0,))])


def _budgets(plan: Plan, traces: Mapping[str, Traced]) -> list[float]:
    """Cost charged to a failed run of each cell: its budget, or the highest cost on the instance."""
    instances, most = [identity(cell) for cell in plan.cells], dict[str, float]()
    for run in plan.runs:
        if (traced := traces.get(run.key)) is not None:
            instance, cost = instances[run.cell], traced.cost(jacobian_price(plan.cells[run.cell]))
            most[instance] = max(most.get(instance, 1.0), cost)
    budgets = [budget(cell) for cell in plan.cells]
    return [most.get(instance, 1.0) if own is None else float(own) for own, instance in zip(budgets, instances)]


def _places(plan: Plan) -> tuple[list[Place], pd.DataFrame]:
    """The place of each cell, and what its numbers mean."""
    functions: dict[str, int] = {}
    instances: dict[str, dict[str, int]] = {}
    places, rows = [], []
    names = _algorithms(plan)
    for cell, name in zip(plan.cells, names):
        family_name, settings = family(cell), identity(cell)
        function = functions.setdefault(family_name, len(functions) + 1)
        numbers = instances.setdefault(family_name, {})
        known = len(numbers)
        instance = numbers.setdefault(settings, known + 1)
        places.append(Place(name, family_name, function, instance, len(cell.parameters)))
        if len(numbers) > known:
            rows.append((function, family_name, instance, len(cell.parameters), settings))
    return places, pd.DataFrame(rows, columns=["function", "family", "instance", "unknowns", "settings"])


def _algorithms(plan: Plan) -> list[str]:
    """Name of each cell's method, with the axes that distinguish it from its namesakes on the same data."""
    named = [method_name(cell) for cell in plan.cells]
    axes = [axis for axis in plan.axes if axis != "label" and axis.split(".")[0] not in OF_INSTANCE]
    met: dict[tuple[str, str], list[dict[str, str]]] = {}
    own = []
    for name, cell in zip(named, plan.cells):
        place = {axis: place_text(value) for axis, value in place_columns(plan, cell).items() if axis in axes}
        met.setdefault((name, identity(cell)), []).append(place)
        own.append(place)
    distinguishing = {
        (name, axis)
        for (name, _), alike in met.items()
        for axis in axes
        if axis != "seed" and len({place[axis] for place in alike}) > 1
    }
    return [
        ", ".join([name, *(f"{axis} {place[axis]}" for axis in axes if (name, axis) in distinguishing)])
        for name, place in zip(named, own)
    ]


def file_name(text: str) -> str:
    """The letters and digits of a text.

    >>> file_name("Kriging + DE"), file_name("../CMA-ES")
    ('Kriging_DE', 'CMA-ES')
    """
    return re.sub(r"[^A-Za-z0-9-]+", "_", text).strip("_") or "unnamed"


def file_names(texts: Iterable[str]) -> dict[str, str]:
    """File names of several, numbered if two would be alike.

    >>> file_names(["Kriging + DE", "Kriging, DE"])
    {'Kriging + DE': 'Kriging_DE', 'Kriging, DE': 'Kriging_DE_2'}
    """
    found: dict[str, str] = {}
    for text in texts:
        name, number = file_name(text), 1
        while name in found.values():
            number += 1
            name = f"{file_name(text)}_{number}"
        found[text] = name
    return found


OF_PLACE = ("algorithm", "family", "unknowns", "instance")
OF_RUN = ("seed", "repetition", "jacobian_price")


def write_table(found: Courses, output: Path) -> None:
    """Write `courses.csv`."""
    lengths = [len(course.values) for course in found.courses]
    columns = {name: [getattr(course.place, name) for course in found.courses] for name in OF_PLACE}
    columns |= {name: [getattr(course, name) for course in found.courses] for name in OF_RUN}
    frame = pd.DataFrame({name: np.repeat(np.array(values), lengths) for name, values in columns.items()})
    frame[[*COLUMNS]] = np.concatenate([course.values for course in found.courses])
    (output / "courses.csv").write_text(csv_text(frame), encoding="utf-8")
