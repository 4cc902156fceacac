"""Sections on a contest: who is first and how surely, the board of each family, curves over the cost, methods, instances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from bench.plan.page import Block, Control, Page, Picture, Plot, Prose, Section, Table
from bench.plan.plan import Plan
from bench.reports.contest.entrants import entrants_frame
from bench.reports.contest.runs import Contest
from bench.reports.contest.scores import WORDS
from bench.reports.contest.targets import Measure
from bench.reports.contest.words import shown, what_is_compared
from bench.reports.plots.traces import COLOURS, axis, band, layout, level, line, styles

COST = "evaluations / unknowns"
LEAST = 1e-3  # of a measure: drawn as this, the data see no smaller one
PROFILES = {
    "performance": "expected running time / that of the fastest",
    "data": "expected running time in simplex gradients",
}
ROW = 30  # px for each method


def contest_page(plan: Plan, contest: Contest, tables: Mapping[str, pd.DataFrame], findings: Sequence[str]) -> Page:
    """The leaderboard; `tables` are the contest's, by the ends of their files' names; `findings` are sentences on the result."""
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
    about = what_is_compared(contest)
    found = "\n".join([about, _seeds(plan), *(f"- {each}" for each in findings)])
    sections = [
        Section("Result", (Prose(found), every)),
        Section("Ranks and curves", tuple(_plots(plan, contest, tables, methods))),
        Section("Running times", times),
        *([Section("Families", tuple(families))] if families else []),
        Section("Methods", (Table(entrants_frame(plan)),)),
        Section(
            "Instances", (Table(contest.instances.fillna("not said").astype(str), file=f"{plan.name}_instances.csv"),)
        ),
    ]
    return Page(findings[0] if findings else about, tuple(sections))


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


def _plots(plan: Plan, contest: Contest, tables: Mapping[str, pd.DataFrame], methods: Sequence[str]) -> Iterator[Block]:
    yield _ranks_plot(tables[""], f"{plan.name}_ranks.png")
    for measure in contest.measures:
        yield _ecdf_plot(tables["_ecdf"], measure, methods, f"{plan.name}_ecdf_{measure.name}.png")
    yield _anytime_plot(tables["_anytime"], contest.measures[0], methods, f"{plan.name}_anytime.png")
    for profile in PROFILES:
        still = f"{plan.name}_profiles.png" if profile == "performance" else ""
        yield _profile_plot(tables["_profiles"], profile, contest.measures[0], methods, still)
    said = "Expected time to the main target against the price of one evaluation."
    yield Picture(f"{plan.name}_price.png", said, "Time")


def _ranks_plot(board: pd.DataFrame, still: str) -> Plot:
    rows = board[board["family"] == "all"]
    names = [name for name in WORDS if f"{name}_rank" in board]
    traces = []
    for number, name in enumerate(names):
        mean, low, high = (rows[f"{name}_rank{end}"].to_numpy() for end in ("", "_low", "_high"))
        offset = 0.5 * ((number + 0.5) / len(names) - 0.5)
        traces.append(
            {
                "type": "scatter", "mode": "markers", "name": WORDS[name], "x": mean, "y": np.arange(len(rows)) + offset,
                "marker": {"color": COLOURS[number], "size": 8},
                "error_x": {"type": "data", "symmetric": False, "array": high - mean, "arrayminus": mean - low, "thickness": 1.5},
                "text": rows["method"], "hovertemplate": "%{text}: %{x:.2f}",
            }
        )  # fmt: skip
    made = layout("mean rank (1: best)")
    made["yaxis"] = axis(
        tickvals=list(range(len(rows))), ticktext=[f"{each} " for each in rows["method"]], range=[len(rows) - 0.5, -0.5]
    )
    said = "Mean rank of each method over all instances with its 95 % interval; the PNG joins methods that no test tells apart."
    return Plot("Mean ranks", said, {"data": traces, "layout": made}, still, height=150 + ROW * len(rows))


def _ecdf_plot(frame: pd.DataFrame, measure: Measure, methods: Sequence[str], still: str) -> Plot:
    mine = frame[frame["measure"] == measure.name]
    traces = []
    families = list(dict.fromkeys(mine["family"]))
    for method, (colour, dash) in styles(methods).items():
        for family in families:
            rows = mine[(mine["family"] == family) & (mine["method"] == method)]
            more = {"meta": {"family": family, "method": method}}
            cost, low, high = (rows[name].to_numpy() for name in ("cost_per_unknown", "low", "high"))
            traces += band(cost, 100 * low, 100 * high, method, colour, showlegend=False, **more)
            style = {"color": colour, "dash": dash, "width": 1.9, "shape": "hv"}
            traces.append(
                line(cost, 100 * rows["share"].to_numpy(), method, colour, line=style, legendgroup=method, **more)
            )
    made = layout(COST, "targets and runs reached (%)", x_log=True)
    said = f"Share of targets ({measure.name} {measure.targets[0]:g} … {measure.targets[-1]:g}) and runs reached against the cost, with 95 % bands."
    return Plot(
        f"Targets reached, {measure.name}",
        said,
        {"data": traces, "layout": made},
        still,
        _controls(families, methods),
        460,
    )


def _anytime_plot(frame: pd.DataFrame, measure: Measure, methods: Sequence[str], still: str) -> Plot:
    traces = []
    families = list(dict.fromkeys(frame["family"]))
    for method, (colour, dash) in styles(methods).items():
        for family in families:
            rows = frame[(frame["family"] == family) & (frame["method"] == method)]
            middle = rows[f"{measure.name}_median"].clip(lower=LEAST).replace(np.inf, np.nan).to_numpy()
            style = {"color": colour, "dash": dash, "width": 1.9, "shape": "hv"}
            traces.append(
                line(
                    rows["cost_per_unknown"].to_numpy(),
                    middle,
                    method,
                    colour,
                    line=style,
                    meta={"family": family, "method": method},
                )
            )
    made = layout(COST, measure.name, x_log=True, y_log=True, shapes=[level(measure.main)])
    said = f"Median {measure.name} of the best point so far against the cost; dotted: the main target."
    return Plot("At any time", said, {"data": traces, "layout": made}, still, _controls(families, methods), 460)


def _profile_plot(frame: pd.DataFrame, profile: str, measure: Measure, methods: Sequence[str], still: str) -> Plot:
    traces = []
    for method, (colour, dash) in styles(methods).items():
        rows = frame[(frame["family"] == "all") & (frame["method"] == method) & (frame["profile"] == profile)]
        style = {"color": colour, "dash": dash, "width": 1.9, "shape": "hv"}
        traces.append(
            line(
                rows["at"].to_numpy(),
                100 * rows["share"].to_numpy(),
                method,
                colour,
                line=style,
                meta={"method": method},
            )
        )
    made = layout(PROFILES[profile], "instances (%)", x_log=True)
    said = f"Share of instances with {measure.name} ≤ {measure.main:g} within this cost: the {profile} profile."
    return Plot(
        f"{profile.capitalize()} profile", said, {"data": traces, "layout": made}, still, _controls([], methods)
    )


def _controls(families: Sequence[str], methods: Sequence[str]) -> tuple[Control, ...]:
    of_family = (
        (Control("family", "instances", tuple(families), with_all=False, chosen=families[0]),) if families else ()
    )
    return (*of_family, Control("method", "method", tuple(methods))) if len(methods) > 1 else of_family
