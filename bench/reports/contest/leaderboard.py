"""Leaderboard of methods on groups of instances.

It has mean ranks, running times, shares, effort and failures.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from bench.reports.contest.ranks import interval, interval_of_shares, ranking
from bench.reports.contest.running_time import break_even, expected_running_time, resampled_running_time, spent
from bench.reports.contest.runs import Contest
from bench.reports.contest.scores import all_scores, speed
from bench.reports.contest.targets import Measure
from ksmea.arrays import Array


def leaderboard(contest: Contest, weights: Array) -> pd.DataFrame:
    """Leaderboard: a row per group of instances and method, best mean rank first.

    The rank is by the first criterion, over all instances.

    `first` is the share of samples of instances in which the method's mean rank is the lowest, `reached` the share of
    its runs that reach the main target, `speed` the area under its ECDF, `overhead_s` the expected seconds of its own
    until the main target, and `break_even_s` the price of an evaluation from which on it takes less time than the fastest
    method without a surrogate.
    """
    main = contest.measures[0]
    scored = all_scores(contest)
    by_method = contest.runs.groupby("method")
    has_surrogate = by_method["surrogate"].any().to_numpy()
    rows = []
    for group, mask in contest.groups().items():
        drawn = weights[:, mask]
        columns: dict[str, Any] = {}
        for name, scores in scored.items():
            found = ranking(scores[mask], drawn)
            ends = {f"{name}_rank_low": found.ends[0], f"{name}_rank_high": found.ends[1]}
            columns |= {f"{name}_rank": found.mean, **ends, f"{name}_first": found.first}
        columns |= _speed(contest, mask, drawn)
        for measure in contest.measures:
            columns |= _main_target(contest, measure, mask, drawn)
        ert, overhead = columns[f"{main.name}_ert"], _overheads(contest, main, mask)
        direct = [(ert[at], overhead[at]) for at in np.flatnonzero(~has_surrogate)]
        columns |= {
            "overhead_s": overhead,
            "break_even_s": [
                break_even(ert[at], overhead[at], direct) if has and direct else np.nan
                for at, has in enumerate(has_surrogate)
            ],
            **_counts(contest, mask),
        }
        rows.append(pd.DataFrame({"family": group, "method": contest.methods, **columns}))
    order = np.argsort(rows[0][f"{next(iter(scored))}_rank"], kind="stable")
    return pd.concat([each.iloc[order] for each in rows], ignore_index=True)


def _speed(contest: Contest, mask: np.ndarray, drawn: Array) -> dict[str, Array]:
    """Area under the ECDF of each method, which is the mean of its runs' own."""
    total, runs = (contest.summed(values)[:, mask].T for values in (speed(contest), np.ones(len(contest.runs))))
    low, high = interval((drawn @ total) / (drawn @ runs))
    return {"speed": total.sum(axis=0) / runs.sum(axis=0), "speed_low": low, "speed_high": high}


def _main_target(contest: Contest, measure: Measure, mask: np.ndarray, drawn: Array) -> dict[str, Array]:
    """ERT of the main target of a measure, and the share of the runs that reach it."""
    table = _running_times(contest, measure, mask, drawn)
    at = measure.main_index
    return {f"{measure.name}_{name}": values[:, at] for name, values in table.items() if name != "runs"}


def _running_times(contest: Contest, measure: Measure, mask: np.ndarray, drawn: Array) -> dict[str, Array]:
    """By method and target: ERT with its interval, and share of the runs that reach it with its own."""
    hits = contest.hits[measure.name]
    costs = contest.summed(spent(hits, contest.runs["cost"].to_numpy()))[:, mask].swapaxes(0, 1)
    reach = contest.summed(np.isfinite(hits))[:, mask].swapaxes(0, 1)  # (n_instance, n_method, n_target)
    runs = contest.summed(np.ones_like(hits))[:, mask].swapaxes(0, 1)
    ert_low, ert_high = interval(resampled_running_time(costs, reach, drawn))
    share = reach.sum(axis=0) / runs.sum(axis=0)
    draws = np.tensordot(drawn, reach, 1) / np.tensordot(drawn, runs, 1)
    low, high = interval_of_shares(share, draws, int(mask.sum()))
    return {
        "ert": expected_running_time(costs.sum(axis=0), reach.sum(axis=0)),
        "ert_low": ert_low,
        "ert_high": ert_high,
        "reached": share,
        "reached_low": low,
        "reached_high": high,
        "runs": runs.sum(axis=0),
    }


def _overheads(contest: Contest, measure: Measure, mask: np.ndarray) -> Array:
    """Expected seconds of each method's own until the main target, (n_method,)."""
    at = measure.main_index
    total = contest.summed(contest.overheads[measure.name][:, at])[:, mask].sum(axis=1)
    reach = contest.summed(np.isfinite(contest.hits[measure.name][:, at]))[:, mask].sum(axis=1)
    return expected_running_time(total, reach)


def _counts(contest: Contest, mask: np.ndarray) -> dict[str, Array]:
    """Medians of what runs took, how many have failed, and how many there are."""
    by_method = contest.runs[mask[contest.runs["instance"]]].groupby("method")
    return {
        "evaluations": by_method["cost"].median().to_numpy(),
        "seconds": by_method["seconds"].median().to_numpy(),
        "failed": by_method["failed"].sum().to_numpy(),
        "runs": by_method.size().to_numpy(),
    }


def running_time_frame(contest: Contest, weights: Array) -> pd.DataFrame:
    """A row per group of instances, method, measure and target.

    ERT in evaluations, and the share of the runs that reach it.
    """
    rows = []
    for group, mask in contest.groups().items():
        for measure in contest.measures:
            table = _running_times(contest, measure, mask, weights[:, mask])
            for number, method in enumerate(contest.methods):
                place = {"family": group, "method": method, "measure": measure.name, "target": measure.targets}
                rows.append(pd.DataFrame({**place, **{name: values[number] for name, values in table.items()}}))
    return pd.concat(rows, ignore_index=True)
