"""`table: contest`: methods ranked over instances.

It has all tables and figures, and a leaderboard page.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from bench.plan.page import Page
from bench.plan.plan import Plan
from bench.plan.report import Made, Report
from bench.reports.contest.comparisons import all_pairs_frame, friedman_frame, instances_frame
from bench.reports.contest.ecdf_curves import anytime_frame, ecdf_frame, profiles_frame
from bench.reports.contest.leaderboard import leaderboard, running_time_frame
from bench.reports.contest.page import contest_page
from bench.reports.contest.ranks import resamples
from bench.reports.contest.runs import cells_frame, contest
from bench.reports.contest.words import sentences, text
from bench.reports.identification.trace_table import read_traces
from bench.reports.pages.experiment import PAGE
from bench.reports.runs import runs_frame
from bench.reports.tables import csv_text

SEED = 20130507  # of the bootstrap: the same records make the same tables
NOTHING = "nothing to rank: no run that all methods have ended has a trace that is judged by the truth"


@dataclass(frozen=True)
class ContestReport(Report):
    """Methods, one a label, compared on instances, one for each choice of problem and measurement."""

    study: ClassVar[str] = "identify"

    def check_plan(self, plan: Plan) -> None:
        cells_frame(plan)

    def make(self, plan: Plan, output: Path) -> Made:
        runs = runs_frame(plan, output)
        found = contest(plan, runs, read_traces(plan, output))
        of_runs = {"runs.csv": csv_text(runs).encode()}
        if not found.measures:
            return Made("\n".join([NOTHING, *found.notes]), of_runs, runs)
        weights = resamples(found.families.tolist(), np.random.default_rng(SEED))
        board, pairs, tests = leaderboard(found, weights), all_pairs_frame(found), friedman_frame(found, weights)
        times, ecdf = running_time_frame(found, weights), ecdf_frame(found, weights)
        anytime, profiles = anytime_frame(found), profiles_frame(found)
        findings = sentences(found, board, pairs, tests)
        tables = {
            "": board,
            "_ert": times,
            "_pairs": pairs,
            "_tests": tests,
            "_ecdf": ecdf,
            "_anytime": anytime,
            "_profiles": profiles,
            "_instances": instances_frame(found),
        }

        def page() -> Page:
            return contest_page(plan, found, tables, [*findings, *plan.notes])

        files = {f"{plan.name}{name}.csv": csv_text(frame).encode() for name, frame in tables.items()}
        return Made(f"{text(found, board, findings)}\n\nleaderboard: {PAGE}", {**files, **of_runs}, runs, page=page)
