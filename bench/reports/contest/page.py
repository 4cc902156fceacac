"""Sections on a contest: winner and its confidence, boards of families, curves, methods, instances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np
import pandas as pd

from bench.plan.page import Drawn, Folded, Page, Prose, Section, Table
from bench.plan.plan import Plan
from bench.reports.contest.charts import (
    anytime_chart,
    ecdf_chart,
    price_chart,
    profiles_chart,
    ranks_chart,
    solved_chart,
)
from bench.reports.contest.entrants import entrants_frame
from bench.reports.contest.runs import Contest
from bench.reports.contest.words import headline, shown, what_is_compared


def contest_page(plan: Plan, contest: Contest, tables: Mapping[str, pd.DataFrame], findings: Sequence[str]) -> Page:
    """Page of a contest, with the leaderboard.

    `tables` are the contest's, by the ends of their files' names; `findings` are sentences on the result.
    """
    board = tables[""]
    methods = board["method"].unique().tolist()
    every, *families = (
        Table(shown(board, contest, group), f"Leaderboard, {group}", f"{plan.name}.csv") for group in contest.groups()
    )
    times = tuple(
        Table(
            _times(tables["_ert"], measure.name, methods),
            f"Expected running time, {measure.name}",
            f"{plan.name}_ert.csv",
        )
        for measure in contest.measures
    )
    first = contest.measures[0]
    title = headline(contest, board) or (findings[0] if findings else what_is_compared(contest))
    solved = Drawn(partial(solved_chart, board, tables["_pairs"], first, title), f"{plan.name}_solved.png")
    curve, *others = _charts(plan, contest, tables, methods)
    instances = Table(contest.instances.fillna("not said").astype(str), file=f"{plan.name}_instances.csv")
    found = "\n".join(["Tests and certainty:", *(f"- {each}" for each in findings)])
    sections = [
        Section("Result", (solved, Prose(found), Folded("Leaderboard", (every,)))),
        Section("Over the cost", (curve, Folded("Mean ranks and further curves", tuple(others)))),
        Section(
            "Numbers",
            (
                Folded("Running times", times),
                *((Folded("Families", tuple(families)),) if families else ()),
                Folded("Methods", (Table(entrants_frame(plan)),)),
                Folded("Instances", (instances,)),
                Prose(_seeds(plan)),
            ),
        ),
    ]
    return Page(title, tuple(sections), what_is_compared(contest))


def _seeds(plan: Plan) -> str:
    """For example 'experiment contest, commit c0de, seed 0, repetitions 0 to 14'."""
    seeds = sorted({cell.seed for cell in plan.cells})
    seed_text = f"{len(seeds)} seeds" if len(seeds) > 1 else f"seed {seeds[0]}"
    last = max((run.repetition for run in plan.runs), default=0)
    return f"experiment {plan.name}, commit {plan.commit}, {seed_text}, repetitions 0 to {last}"


def _times(times: pd.DataFrame, measure: str, methods: Sequence[str]) -> pd.DataFrame:
    """Expected running times over all instances, a row for each method and a column for each target."""
    rows = times[(times["family"] == "all") & (times["measure"] == measure)]
    table = rows.pivot(index="method", columns="target", values="ert").loc[list(methods)]
    texts = table[sorted(table.columns, reverse=True)].map(
        lambda value: f"{value:.0f}" if np.isfinite(value) else "never"
    )
    return texts.rename(columns="≤ {:g}".format).reset_index()


def _charts(
    plan: Plan, contest: Contest, tables: Mapping[str, pd.DataFrame], methods: Sequence[str]
) -> Iterator[Drawn]:
    """Curves over the cost, the one of the first measure first, then ranks and profiles."""
    board, first = tables[""], contest.measures[0]
    curves = [
        Drawn(partial(ecdf_chart, tables["_ecdf"], measure, methods), f"{plan.name}_ecdf_{measure.name}.png")
        for measure in contest.measures
    ]
    yield curves[0]
    yield Drawn(partial(ranks_chart, board, tables["_pairs"]), f"{plan.name}_ranks.png")
    yield from curves[1:]
    yield Drawn(partial(anytime_chart, tables["_anytime"], first, methods), f"{plan.name}_anytime.png")
    yield Drawn(partial(profiles_chart, tables["_profiles"], first, methods), f"{plan.name}_profiles.png")
    if np.isfinite(board[f"{first.name}_ert"]).any():  # else no method has a line
        yield Drawn(partial(price_chart, board, first, methods), f"{plan.name}_price.png")
