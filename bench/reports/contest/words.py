"""Findings of a contest in sentences: ranking and certainty, agreement of the seeds, omitted runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from bench.reports.contest.paired_tests import LEVEL
from bench.reports.contest.ranks import LEAST_INSTANCES
from bench.reports.contest.runs import Contest
from bench.reports.contest.scores import WORDS
from ksmea.show.text import aligned, chance, number

MOST_NAMES, LEADERS = 5, 2  # of methods in one sentence, and of the best ones
MOST_SOLVERS = 3  # of methods that a headline names
LEAST_P = 1e-3  # smaller ones are not counted


def shown(board: pd.DataFrame, contest: Contest, group: str = "all") -> pd.DataFrame:
    """The leaderboard of a group of instances as text, for terminal and page."""
    rows = board[board["family"] == group]
    first, *_ = contest.measures
    columns: dict[str, list[str]] = {"method": rows["method"].tolist()}
    for name in _criteria(board):
        columns[f"{name} rank"] = [
            f"{mean:.2f} ({low:.2f}–{high:.2f})"
            for mean, low, high in rows[[f"{name}_rank{end}" for end in ("", "_low", "_high")]].to_numpy()
        ]
    columns["first %"] = [f"{100 * share:.0f}" for share in rows[f"{first.name}_first"]]
    for measure in contest.measures:
        columns[f"{measure.name} ≤ {measure.main:g}, %"] = [
            f"{100 * share:.0f} ({100 * low:.0f}–{100 * high:.0f})"
            for share, low, high in rows[[f"{measure.name}_reached{end}" for end in ("", "_low", "_high")]].to_numpy()
        ]
    columns["ERT"] = [_count(value) for value in rows[f"{first.name}_ert"]]
    columns["break-even s"] = [number(value, 2) for value in rows["break_even_s"]]
    columns["s / run"] = [number(value, 2) for value in rows["seconds"]]
    if rows["failed"].any():
        columns["failed"] = [str(failed) for failed in rows["failed"]]
    return pd.DataFrame(columns)


def _count(value: float) -> str:
    return f"{value:.0f}" if np.isfinite(value) else "never"


def _criteria(board: pd.DataFrame) -> list[str]:
    return [name for name in WORDS if f"{name}_rank" in board]


def what_is_compared(contest: Contest) -> str:
    """For example '5 methods on 6 instances of 1 family, 4 draws each: 120 runs, 0 failed'."""
    draws = contest.runs.groupby(["instance", "method"]).size()
    each = f"{draws.min()}" if draws.min() == draws.max() else f"{draws.min()} to {draws.max()}"
    counts = f"{len(contest.runs)} runs, {int(contest.runs['failed'].sum())} failed"
    return (
        f"{_plural(len(contest.methods), 'method')} on {_plural(len(contest.instances), 'instance')} of"
        f" {', '.join(dict.fromkeys(contest.families))}, {_plural(each, 'draw')} each: {counts}"
    )


def _plural(count: int | str, noun: str) -> str:
    return f"{count} {noun}" + ("" if str(count) == "1" else "s")


def sentences(contest: Contest, board: pd.DataFrame, pairs: pd.DataFrame, tests: pd.DataFrame) -> list[str]:
    """Findings over all instances: leaders by each criterion, the fastest method, failures, and notes."""
    n_instance = len(contest.instances)
    findings = [_of_criterion(name, board, pairs, tests, n_instance) for name in _criteria(board)]
    if n_instance < LEAST_INSTANCES:
        findings.append(
            f"intervals of {_plural(n_instance, 'instance')} say too little; take {LEAST_INSTANCES} or more"
        )
    if len(contest.methods) == 1:
        findings = [
            f"one method alone, {contest.methods[0]}: nothing to rank; merge its folder with others (docs/merge_export.md)"
        ]
    return [*findings, *_fastest(contest, board), *_of_set(contest), *_of_failures(contest), *contest.notes]


def headline(contest: Contest, board: pd.DataFrame) -> str:
    """Methods that solve most runs, how many, and the fastest one; '' of one method alone."""
    if len(contest.methods) == 1:
        return ""
    measure = contest.measures[0]
    rows = board[board["family"] == "all"]
    shares = rows[f"{measure.name}_reached"].to_numpy(float)
    target, n_run = f"{measure.name} ≤ {measure.main:g}", int(rows["runs"].max())
    if not shares.max() > 0:
        return f"No method reaches {target} in any run"
    names = rows["method"].to_numpy()[shares == shares.max()].tolist()
    more = f" and {len(names) - MOST_SOLVERS} more" if len(names) > MOST_SOLVERS else ""
    solved = f"{'all' if shares.max() == 1 else f'{shares.max() * n_run:.0f} of'} {n_run} runs"
    verb = "solves" if len(names) == 1 else "solve"
    fastest, *_ = _fastest(contest, board)
    return f"{', '.join(names[:MOST_SOLVERS])}{more} {verb} {solved} ({target}); {fastest.replace(f' to {target}', '')}"


def _of_criterion(name: str, board: pd.DataFrame, pairs: pd.DataFrame, tests: pd.DataFrame, n_instance: int) -> str:
    rows = board[board["family"] == "all"].sort_values(f"{name}_rank", kind="stable")
    mean_ranks = [
        f"{method} {mean:.2f} ({low:.2f}–{high:.2f})"
        for method, mean, low, high in rows[
            ["method", *(f"{name}_rank{end}" for end in ("", "_low", "_high"))]
        ].to_numpy()
    ]
    best, first = rows[["method", f"{name}_first"]].iloc[0]
    mine = pairs[(pairs["family"] == "all") & (pairs["criterion"] == name)]
    leaders = " and ".join(mean_ranks[:LEADERS])
    ranks = f"lowest mean ranks {leaders}; {best} is first in {100 * first:.0f} % of resamples of the instances"
    return f"{WORDS[name]}: {ranks}; {_apart(best, mine)}{_agreement(name, tests, n_instance)}"


def _apart(best: str, pairs: pd.DataFrame) -> str:
    """Methods that the tests do not separate from the first one."""
    mine = pairs[(pairs["method"] == best) | (pairs["other"] == best)]
    if mine.empty:
        return "no other method to compare with"
    instances = int(mine[["better", "worse", "alike"]].iloc[0].sum())
    if least := _too_few(instances, len(pairs)):
        of = "the two" if len(pairs) == 1 else f"any two of {_n_method(len(pairs))}"
        return f"{instances} instances cannot separate {of}, {least} could (Wilcoxon's test with Holm's correction, {100 * LEVEL:g} %)"
    alike = mine[~mine["told_apart"]]
    others = [other if method == best else method for method, other in alike[["method", "other"]].to_numpy()]
    if not others:
        return f"all others are distinguished from it (Wilcoxon's test with Holm's correction, {100 * LEVEL:g} %)"
    return f"not distinguished from it (Wilcoxon, Holm, {100 * LEVEL:g} %): {_listed(others)}"


def _n_method(n_pair: int) -> int:
    """Number of methods with so many pairs."""
    return round((1 + np.sqrt(1 + 8 * n_pair)) / 2)


def _too_few(instances: int, n_pair: int) -> int:
    """Number of instances that could separate a pair of methods if so few never can.

    N that all agree have p = 2^(1 − n). 0 where they can.
    """
    least = int(np.ceil(1 + np.log2(n_pair / LEVEL)))
    return least if instances < least else 0


def _listed(names: Sequence[str]) -> str:
    more = [f"{len(names) - MOST_NAMES} more"] if len(names) > MOST_NAMES else []
    return ", ".join([*names[:MOST_NAMES], *more])


def _agreement(name: str, tests: pd.DataFrame, n_instance: int) -> str:
    row = tests[(tests["family"] == "all") & (tests["criterion"] == name)].iloc[0]
    p = row["friedman_p"]
    friedman = "" if np.isnan(p) else f"; Friedman's test of all: {chance(p, LEAST_P)}"
    if np.isnan(row["tau_of_halves"]):
        return friedman
    agree = "agree" if row["tau_low"] > 0 and n_instance >= LEAST_INSTANCES else "are not shown to agree"
    interval = f"{row['tau_low']:.2f}–{row['tau_high']:.2f}"
    return f"{friedman}; both halves of the seeds {agree}, Kendall's τ {row['tau_of_halves']:.2f} ({interval})"


def _fastest(contest: Contest, board: pd.DataFrame) -> list[str]:
    measure = contest.measures[0]
    rows = board[(board["family"] == "all") & np.isfinite(board[f"{measure.name}_ert"])]
    target = f"{measure.name} ≤ {measure.main:g}"
    if rows.empty:
        return [f"no run reaches {target}"]
    best = rows.loc[rows[f"{measure.name}_ert"].idxmin()]
    low, high = (_count(best[f"{measure.name}_ert_{end}"]) for end in ("low", "high"))
    fastest = f"{best['method']} is the fastest to {target}: expected {_count(best[f'{measure.name}_ert'])} ({low}–{high}) evaluations"
    paying = rows.dropna(subset="break_even_s").sort_values("break_even_s")
    prices = [
        f"{method} {f'above {price:.2g} s' if price else 'at any price'}"
        for method, price in paying[["method", "break_even_s"]].to_numpy()
    ]
    pays = f"at these prices of an evaluation a surrogate is faster than all methods without one: {_listed(prices)}"
    return [fastest, pays] if prices else [fastest]


def _of_set(contest: Contest) -> list[str]:
    """Sentence on the set of the instances, open or held back; empty if no instance states its set."""
    sets = contest.instances["held_back"].map({True: "held back", False: "open"}).dropna()
    counts = sets.value_counts()
    if counts.empty:
        return []
    if counts.get("open", 0):
        both = f"{counts.get('open', 0)} open, {counts.get('held back', 0)} held back"
        return [f"these are instances of the open set ({both}): the final ranking uses the held-back set only"]
    return ["all instances are of the held-back set: this is the final ranking"]


def _of_failures(contest: Contest) -> list[str]:
    failed = contest.runs[contest.runs["failed"]].groupby("method").size()
    if failed.empty:
        return []
    counts = ", ".join(f"{contest.methods[at]} {count}" for at, count in failed.items())
    return [f"failed, counted as never reaching a target: {counts}"]


def text(contest: Contest, board: pd.DataFrame, findings: Sequence[str]) -> str:
    """Text for the terminal."""
    table = shown(board, contest)
    lines = "\n".join(f"- {each}" for each in findings)
    first = contest.measures[0]
    remark = (
        "rank: mean over the instances with its 95 % interval; ERT: expected evaluations to"
        f" {first.name} ≤ {first.main:g}, a Jacobian at its price"
    )
    return "\n\n".join(
        [what_is_compared(contest), aligned(list(table.columns), table.to_numpy().tolist()), remark, lines]
    )
