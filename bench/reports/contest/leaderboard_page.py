"""The leaderboard of a contest as a page in one file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np
import pandas as pd

from bench.plan.plan import Plan
from bench.reports.contest.entrants import entrants_frame
from bench.reports.contest.runs import Contest
from bench.reports.contest.words import shown, what_is_compared
from bench.reports.page import figure_block, page, table_block

PAGE = "index.html"
SHOWN = {  # figures, the most telling first: title, and in words what they show
    "_ranks": (
        "Mean ranks",
        "Mean rank of each method with its 95 % interval; bars join methods that no test tells apart.",
    ),
    "_ecdf_excess": ("Targets reached, excess", "Share of targets and runs reached against evaluations per unknown."),
    "_ecdf_error": ("Targets reached, error", "The same for the error of the unknowns in units of the CRLB."),
    "_anytime": ("Excess at any time", "Median excess of the best point so far against evaluations per unknown."),
    "_profiles": ("Profiles", "Share of instances solved within a multiple of the fastest, and within a cost."),
    "_price": ("Time", "Expected time to the main target against the price of one evaluation."),
}


def leaderboard_page(
    plan: Plan,
    contest: Contest,
    board: pd.DataFrame,
    times: pd.DataFrame,
    told: Sequence[str],
    drawings: Mapping[str, bytes],
) -> str:
    """The page: what was found, the board of all instances and of each family, running times, figures, methods, instances."""
    sentences = "".join(f"<li>{escape(each)}</li>" for each in told)
    methods = board["method"].unique().tolist()
    every, *families = (
        table_block(f"Leaderboard, {group}", shown(board, contest, group)) for group in contest.groups()
    )
    blocks = [
        f"<p>{escape(_seeds(plan))}</p><ul>{sentences}</ul>",
        every,
        *(figure_block(*SHOWN[name], drawings[name]) for name in SHOWN if name in drawings),
        *(
            table_block(f"Expected running time, {measure.name}", _times(times, measure.name, methods))
            for measure in contest.measures
        ),
        *families,
        table_block("Methods", entrants_frame(plan)),
        table_block("Instances", contest.instances.fillna("not said").astype(str)),
    ]
    return page(plan, what_is_compared(contest), blocks)


def _seeds(plan: Plan) -> str:
    """For example 'experiment contest, commit c0de, seed 0, repetitions 0 to 14'."""
    seeds = sorted({cell.seed for cell in plan.cells})
    told = f"{len(seeds)} seeds" if len(seeds) > 1 else f"seed {seeds[0]}"
    last = max((run.repetition for run in plan.runs), default=0)
    return f"experiment {plan.name}, commit {plan.commit}, {told}, repetitions 0 to {last}"


def _times(times: pd.DataFrame, measure: str, methods: Sequence[str]) -> pd.DataFrame:
    """Expected running times over all instances, a row for each method and a column for each target."""
    rows = times[(times["family"] == "all") & (times["measure"] == measure)]
    table = rows.pivot(index="method", columns="target", values="ert").loc[list(methods)]
    texts = table[sorted(table.columns, reverse=True)].map(
        lambda value: f"{value:.0f}" if np.isfinite(value) else "never"
    )
    return texts.rename(columns="≤ {:g}".format).reset_index()
