"""Medians over the repetitions next to the paper's values, and the page.

Their spread, and the figures that an experiment requests.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import ClassVar

import pandas as pd

from bench.jobs.lines import RESULTS, RunLine
from bench.jobs.records import read_records
from bench.plan.drawn_cell import drawn_cell
from bench.plan.page import Block, Drawn, Folded, Page, Prose, Section, Table
from bench.plan.plan import Plan
from bench.plan.report import Made, Report
from bench.reports.by_cell import hidden_paragraph
from bench.reports.identification.agreement_charts import Agreement, Kind, agreement, agreement_chart
from bench.reports.identification.cost import cost_chart, cost_frame
from bench.reports.identification.course_charts import MAX_LINES, anytime_chart, figure_number, updates_chart
from bench.reports.identification.error_chart import error_chart, error_finding, has_bounds
from bench.reports.identification.error_table import LIMIT, error_table
from bench.reports.identification.factor_charts import cells_chart, factors_chart
from bench.reports.identification.factors import Sweep, sweep_of, without_twins
from bench.reports.identification.factors import headline as sweep_headline
from bench.reports.identification.spread_chart import spread_chart, spread_finding
from bench.reports.identification.trace_table import read_traces, stages_frame, trace_frame
from bench.reports.runs import runs_frame
from bench.reports.tables import OF_LIKELIHOOD, as_text, csv_text, search_lines, slips, slips_text, summary_frame
from ksmea.measurement.notation import Notation
from ksmea.records.curves import ResponseCurves
from ksmea.records.identification import IdentificationRecord, UpdateRecord
from ksmea.show.readings import PLAIN
from ksmea.show.text import capital


@dataclass(frozen=True)
class SummaryReport(Report):
    study: ClassVar[str] = "identify"

    def make(self, plan: Plan, output: Path) -> Made:
        runs = runs_frame(plan, output)
        summary = summary_frame(plan, runs)
        sweep = None if plan.report.paper else sweep_of(plan, runs)
        finding = "" if sweep is None else "\n".join(f"{said}." for said in (sweep_headline(sweep), *sweep.merged))
        notes = [slips_text(slips(plan.report.paper)), hidden_paragraph(plan, runs, "identification")]
        told = without_twins(plan, summary)
        text = "\n\n".join(filter(None, [finding, as_text(plan, told), *notes]))
        beside = "\n\n".join(filter(None, ["\n".join(search_lines(plan, told)), *notes]))
        courses = cache(lambda: read_courses(plan, runs, output))
        return Made(
            text,
            {f"{plan.name}.csv": csv_text(summary).encode(), "runs.csv": csv_text(runs).encode()},
            runs,
            lambda: {f"{plan.name}{name}.csv": csv_text(frame).encode() for name, frame in courses().tables().items()},
            page=lambda: summary_page(plan, runs, summary, beside, courses(), sweep),
        )


@dataclass(frozen=True)
class Courses:
    """Course of runs, as far as the experiment requests figures of it.

    `reached` at which cost, by stage, and `cost` of methods.
    """

    histories: Mapping[str, tuple[UpdateRecord, ...]]
    curves: Mapping[int, tuple[ResponseCurves, ...]]  # by cell
    notation: Mapping[int, Notation]  # of each cell's measurement
    reached: pd.DataFrame | None
    stages: pd.DataFrame | None
    cost: pd.DataFrame | None

    def tables(self) -> dict[str, pd.DataFrame]:
        """The tables behind the figures, by the end of their file's name."""
        every = {"_cost": self.cost, "_trace": self.reached, "_stages": self.stages}
        return {name: frame for name, frame in every.items() if frame is not None}


def read_courses(plan: Plan, runs: pd.DataFrame, output: Path) -> Courses:
    """Data of the figures that an experiment requests; empty or None if no record has them yet."""
    asked = set(plan.report.figures)
    kept = _kept(plan, output) if {"updates", "response"} & asked else {}
    traces = read_traces(plan, output) if "trace" in asked else {}
    return Courses(
        {key: part.history for key, part in kept.items()} if "updates" in asked else {},
        curves_by_cell(plan, kept) if "response" in asked else {},
        {run.cell: kept[run.key].notation for run in plan.runs if run.key in kept and kept[run.key].curves},
        trace_frame(plan, traces) if traces else None,
        stages_frame(plan, traces) if traces else None,
        cost_frame(plan, runs) if "cost" in asked and runs["status"].isin(RESULTS).any() else None,
    )


def summary_page(
    plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame, notes: str, courses: Courses, sweep: Sweep | None = None
) -> Page:
    """The page of a table, with all figures of the experiment; of a sweep first what each factor does.

    `notes` say what concerns whole cells or the paper's print.
    """
    known = summary.dropna(axis="columns", how="all")
    of_likelihood = [name for name in OF_LIKELIHOOD if name in known]
    said = f"Of the likelihood, not of the method: {', '.join(of_likelihood)}." if of_likelihood else ""
    marked = (Prose(said),) if said else ()
    columns = Folded("All columns", (*marked, Table(known, file=f"{plan.name}.csv")))
    medians = error_table(plan, summary)
    dagger = AT_LIMIT if any(LIMIT in str(cell) for cell in medians.to_numpy().ravel()) else ""
    errors = Table(medians, f"Median absolute errors{STAR}{dagger}", file=f"{plan.name}.csv")
    table: tuple[Block, ...] = (errors, *([Prose(_capitals(notes))] if notes else []), columns)
    figure, values = _of_runs(plan, runs, summary)
    curves = tuple(_curves(plan, courses))
    of_curves = [Section("Curves", curves)] if curves else []
    if sweep is None:
        sections = [Section("Runs and the paper" if plan.report.paper else "Runs", (figure, *values))]
        return Page(headline(plan, runs, summary), (*sections, Section("Table", table), *of_curves), _counted(runs))
    sections = list(_of_sweep(sweep, plan.name, table, figure, values))
    return Page(sweep_headline(sweep), (*sections, *of_curves), _counted(runs))


def _counted(runs: pd.DataFrame) -> str:
    done = int(runs["status"].isin(RESULTS).sum())
    return f"{done} of {len(runs)} runs" if done < len(runs) else f"{done} run{'s' * (done != 1)}"


def _capitals(text: str) -> str:
    return "\n".join(map(capital, text.split("\n")))


STAR, AT_LIMIT = "; *: the smallest of a column", f"; {LIMIT}: at a search limit"


def _of_runs(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame) -> tuple[Drawn, tuple[Block, ...]]:
    """The figure of all runs; the values behind it where it has errors in σ."""
    if not has_bounds(plan):
        return Drawn(partial(spread_chart, plan, runs, summary), f"{plan.name}.png"), ()
    values = Drawn(partial(spread_chart, plan, runs, summary), f"{plan.name}_spread.png")
    folded = Folded("Values of each unknown, updates, evaluations and time", (values,))
    return Drawn(partial(error_chart, plan, runs, summary), f"{plan.name}.png"), (folded,)


def _of_sweep(
    sweep: Sweep, name: str, table: tuple[Block, ...], figure: Drawn, values: tuple[Block, ...]
) -> Iterator[Section]:
    """Sections on the effect of each factor and on the numbers; a single factor is shown by all runs."""
    said = [Prose(". ".join(sweep.merged) + ".")] if sweep.merged else []
    if len(sweep.factors) < 2:
        yield Section("Factors", (*said, figure, *values))
        yield Section("Numbers", table)
        return
    factors = Drawn(partial(factors_chart, sweep), f"{name}_factors.png")
    cells = Drawn(partial(cells_chart, sweep), f"{name}_cells.png")
    yield Section("Factors", (*said, factors, cells))
    yield Section("Numbers", (Folded("Table", table), Folded("All runs, unknown by unknown", (figure, *values))))


def _curves(plan: Plan, courses: Courses) -> Iterator[Block]:
    if any(courses.histories.values()):
        yield Drawn(partial(updates_chart, plan, courses.histories), f"{plan.name}_updates.png")
    yield from _responses(plan, courses)
    if courses.reached is not None and courses.stages is not None:
        yield Drawn(partial(anytime_chart, plan, courses.reached, courses.stages), f"{plan.name}_trace.png")
    if courses.cost is not None:
        yield Drawn(partial(cost_chart, courses.cost), f"{plan.name}_cost.png")


FILES: dict[Kind, str] = {"identified": "response", "surrogate": "surrogate"}


def _responses(plan: Plan, courses: Courses) -> Iterator[Block]:
    """Responses of the cell that the paper draws, else of the first one that has any.

    Of a table of the paper only its own figures are drawn.
    """
    cells = [drawn_cell(plan), *courses.curves]
    for kind in [each for each in FILES if figure_number(plan, each)] or FILES:
        found = ((cell, _agreements(courses, cell, kind)) for cell in cells)
        if (first := next((each for each in found if each[1]), None)) is not None:
            yield Drawn(partial(agreement_chart, plan, first[0], kind, first[1]), f"{plan.name}_{FILES[kind]}.png")


def _agreements(courses: Courses, cell: int, kind: Kind) -> list[Agreement]:
    curves, notation = courses.curves.get(cell, ()), courses.notation.get(cell, PLAIN)
    return [found for each in curves if (found := agreement(each, kind, notation)) is not None]


def headline(plan: Plan, runs: pd.DataFrame, summary: pd.DataFrame) -> str:
    """Errors in σ if they have one, else in per cent; without errors the number of results."""
    if has_bounds(plan):
        return error_finding(plan, runs, summary)
    done = int(runs["status"].isin(RESULTS).sum())
    return spread_finding(plan, summary) or f"{done} of {len(runs)} runs have a result"


def _kept(plan: Plan, output: Path) -> dict[str, ForFigures]:
    """Updating steps and curves of the runs that figures show."""
    shown = {run.key for run in plan.runs if run.repetition < MAX_LINES}
    return read_records(output, lambda line: for_figures(line, plan.units) if line.key in shown else ForFigures(), plan)


@dataclass(frozen=True)
class ForFigures:
    """Updating steps of a run, its response curves if it keeps them, and the notation of its data."""

    history: tuple[UpdateRecord, ...] = ()
    curves: ResponseCurves | None = None
    notation: Notation = PLAIN


def for_figures(line: RunLine, units: str = "") -> ForFigures:
    """Updating steps and curves of a run, to be shown in these units; empty without a result."""
    if not line.has_result:
        return ForFigures()
    record = line.record(IdentificationRecord).shown_in(units)
    return ForFigures(record.history, record.curves, record.notation)


def curves_by_cell(plan: Plan, kept: Mapping[str, ForFigures]) -> dict[int, tuple[ResponseCurves, ...]]:
    """Response curves by cell, of the repetitions that keep them."""
    found: dict[int, tuple[ResponseCurves, ...]] = {}
    for run in plan.runs:
        if run.key in kept and (curves := kept[run.key].curves) is not None:
            found[run.cell] = (*found.get(run.cell, ()), curves)
    return found
