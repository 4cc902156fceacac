"""`verify TABLE`: recompute the reference results from recorded settings and seeds, and compare them.

With identical libraries on the same kind of processor, every identified value of every run must agree within
`tolerance` (relative, 1e-6 by default). Elsewhere rounding differs, and a search that compares misfits may turn another
way at a near tie: there the median of every parameter in every cell must lie within the reference's interquartile range
of the reference's median, or within `tolerance` if the runs agree more closely than that (Table 2, without noise). The
criterion that was applied is printed.

Tables of other studies than identification (`audit`, `diagnosis_nulls`) are computed again with their records. Every
number and word in them is compared, except times.
"""

from __future__ import annotations

import dataclasses
import io
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd

from bench.commands.reference import read_reference
from bench.jobs.execute import execute
from bench.jobs.lines import RESULTS
from bench.jobs.pool import Given, Limits, Task, run_tasks
from bench.jobs.progress import progress_bar
from bench.jobs.records import RecordWriter
from bench.jobs.work import own_modules
from bench.plan.plan import Plan, all_runs, component_seeds
from bench.plan.provenance import library_versions, platform_name
from bench.plan.report import report_named
from bench.storage.own_files import REFERENCE
from ksmea.errors import SettingError, unknown
from ksmea.numerics.parallel import available_cores
from ksmea.plugins import registry
from ksmea.records.identification import IdentificationRecord

# Tolerance of CRLBs that other libraries or processors compute near directions that the data do not determine.
ELSEWHERE = 0.01
ROUNDING = 1e-12  # of the largest number of a column: a deviance that is lowered by 0 is lowered by the rounding of two deviances
DEFAULTS = {"repetitions": None, "workers": None, "tolerance": 1e-6}


@dataclass(frozen=True)
class Difference:
    """One value of the reference and what it is now.

    `allowed` is the largest difference that is not a failure.
    """

    what: str
    reference: float
    now: float
    allowed: float

    @property
    def is_failure(self) -> bool:
        return not abs(self.now - self.reference) <= self.allowed

    def __str__(self) -> str:
        return f"{self.what}: {self.now:.8g}, reference {self.reference:.8g}, allowed ± {self.allowed:.2g}"


def verify(words: list[str]) -> int:
    """`verify TABLE [repetitions=N] [workers=N] [tolerance=T]`: recompute values of a reference table.

    The exit code is 0 if all values agree, 1 if one does not.
    """
    if not words:
        raise SettingError("verify: expected the name of a table, for example table3, got nothing")
    table, options = words[0], _options(words[1:])
    plan, reference = read_reference(table)
    if plan.report.table == "settings":
        return _report(table, "settings by default", _settings_differences(plan), len(reference))
    if report_named(plan.report.table).study != "identify":
        same = plan.versions == library_versions() and plan.platform == platform_name()
        allowed = options["tolerance"] if same else max(options["tolerance"], ELSEWHERE)
        differences = _study_differences(plan, options, allowed)
        return _report(table, f"every number within {allowed:g}", differences, len(differences))
    if options["repetitions"] is not None:
        reference = reference[reference["repetition"] < options["repetitions"]]
    now = _recomputed(plan, reference, options["workers"])
    if plan.versions == library_versions() and plan.platform == platform_name():
        differences = _run_differences(plan, reference, now, options["tolerance"])
        return _report(table, f"every value of {len(reference)} runs", differences, len(differences))
    _, everything = read_reference(table)
    differences = _median_differences(plan, reference, everything, now, options["tolerance"])
    here = f"other libraries or processor than the reference ({plan.platform}): medians of {len(reference)} runs"
    return _report(table, here, differences, len(differences))


def _study_differences(plan: Plan, options: dict[str, Any], tolerance: float) -> list[Difference]:
    """Differences of numbers and words of a study's tables, but for times.

    They are the tables of its runs, and also the experiment's table if all runs are computed again.
    """
    name = plan.name
    were = {file: pd.read_csv(REFERENCE / file, comment="#") for file in (f"{name}.csv", f"{name}.runs.csv")}
    repetitions = int(were[f"{name}.runs.csv"]["repetition"].max()) + 1
    asked = min(options["repetitions"] or repetitions, repetitions)
    plan = dataclasses.replace(plan, runs=all_runs(plan.cells, asked, plan.versions))
    tasks = [Given(run, (plan.cells[run.cell].settings, plan.seeds(run))) for run in plan.runs]
    with TemporaryDirectory() as folder, RecordWriter(Path(folder), 0, plan) as writer:
        for run, record in _executed(plan, tasks, options["workers"]):
            writer.result(run, record)
        made = report_named(plan.report.table).make(plan, Path(folder)).files
    runs = were[f"{name}.runs.csv"]
    compared = [(runs[runs["repetition"] < asked], pd.read_csv(io.BytesIO(made["runs.csv"])))]
    if asked == repetitions:
        compared.append((were[f"{name}.csv"], pd.read_csv(io.BytesIO(made[f"{name}.csv"]))))
    return [difference for was, now in compared for difference in frame_differences(was, now, tolerance)]


def frame_differences(reference: pd.DataFrame, now: pd.DataFrame, tolerance: float) -> list[Difference]:
    """Differences of a table's words and numbers; numbers may differ by a tolerance and by rounding."""
    differences = [Difference("rows", len(reference), len(now), 0)]
    largest = reference.select_dtypes("number").abs().max()
    for row, (was, found) in enumerate(zip(reference.to_dict("records"), now.to_dict("records"))):
        for column, value in was.items():
            if column == "key" or column.startswith("seconds"):
                continue
            what = f"{column} in row {row + 1}"
            if isinstance(value, (int, float)) and not isinstance(value, bool):
                if not (pd.isna(value) and pd.isna(found.get(column))):
                    allowed = tolerance * abs(value) + ROUNDING * float(largest.get(column, 0.0))
                    differences.append(Difference(what, value, found.get(column, np.nan), allowed))
            else:
                differences.append(Difference(what, 1.0, float(found.get(column) == value), 0.0))
    return differences


def _options(words: list[str]) -> dict[str, Any]:
    options: dict[str, Any] = dict(DEFAULTS)
    for word in words:
        name, _, value = word.partition("=")
        if name not in options:
            raise unknown("option of verify:", name, options)
        try:
            options[name] = float(value) if name == "tolerance" else int(value)
        except ValueError:
            raise SettingError(f"verify: expected a number for {name}, got '{value}'") from None
        if not options[name] > 0:
            raise SettingError(f"verify: expected {name} above 0, got {value}")
    return options


def _recomputed(plan: Plan, reference: pd.DataFrame, workers: int | None) -> dict[str, dict[str, float]]:
    """Identified values of the reference's runs in the units of the table, computed now, by key.

    None if a run failed.
    """
    tasks = [
        Given(row.key, (plan.cells[row.cell].settings, component_seeds(row.seed, row.repetition)))
        for row in reference.itertuples()
    ]
    return {key: _identified(record) for key, record in _executed(plan, tasks, workers)}


def _executed(plan: Plan, tasks: Sequence[Given[Task]], workers: int | None) -> Iterator[tuple[Task, dict[str, Any]]]:
    """Each task with the record of its run, in the order in which they end."""
    n_worker = min(workers or available_cores(), len(tasks))
    with progress_bar(f"verify {plan.name}", len(tasks)) as bar:
        for task, record in run_tasks(execute, tasks, n_worker, Limits(), lambda task: None, own_modules(plan)):
            yield task, record
            bar.update()


def _run_differences(
    plan: Plan, reference: pd.DataFrame, now: dict[str, dict[str, float]], tolerance: float
) -> list[Difference]:
    differences = []
    for row in reference.to_dict("records"):
        values = now[row["key"]]
        for parameter in plan.cells[row["cell"]].parameters:
            was = row[parameter.name]
            what = f"{parameter.name} of run {row['key']}"
            differences.append(Difference(what, was, values.get(parameter.name, np.nan), tolerance * abs(was)))
    return differences


def _median_differences(
    plan: Plan, reference: pd.DataFrame, everything: pd.DataFrame, now: dict[str, dict[str, float]], tolerance: float
) -> list[Difference]:
    differences = []
    for index, cell in enumerate(plan.cells):
        rows = reference[reference["cell"] == index]
        values = pd.DataFrame([now[key] for key in rows["key"]])
        for parameter in cell.parameters:
            all_values = everything.loc[everything["cell"] == index, parameter.name]
            spread = float(np.subtract(*np.percentile(all_values, [75, 25])))
            was = float(rows[parameter.name].median())
            median = float(values[parameter.name].median()) if parameter.name in values else np.nan
            what = f"median {parameter.name} of cell {index} ({', '.join(f'{k}={v}' for k, v in cell.place.items())})"
            differences.append(Difference(what, was, median, max(spread, tolerance * abs(was))))
    return differences


def _identified(record: dict[str, Any]) -> dict[str, float]:
    if record["status"] not in RESULTS:
        return {}
    parameters = IdentificationRecord.from_data(record).parameters
    return {parameter.name: parameter.in_unit(parameter.identified) for parameter in parameters}


def _settings_differences(plan: Plan) -> list[Difference]:
    """Recorded numbers among the optimisers' settings, each compared with its current default."""
    differences = []
    for cell in plan.cells:
        recorded = cell.settings["optimizer"]
        for field in dataclasses.fields(registry.plugin_class("optimizer", recorded["name"])):
            if isinstance(field.default, (int, float)) and field.name in recorded:
                what = f"{field.name} of {recorded['name']}"
                differences.append(Difference(what, float(recorded[field.name]), float(field.default), 0.0))
    return differences


def _report(table: str, asked: str, differences: list[Difference], n_value: int) -> int:
    failures = [difference for difference in differences if difference.is_failure]
    verdict = f"{len(failures)} of {n_value} differ" if failures else f"all {n_value} agree"
    print(f"{table}: {asked}; {verdict}")
    worst = sorted(
        failures, key=lambda difference: -abs(difference.now - difference.reference) / (difference.allowed or 1)
    )
    print(os.linesep.join(f"  {difference}" for difference in worst[:10]), end=os.linesep if failures else "")
    return 1 if failures else 0
