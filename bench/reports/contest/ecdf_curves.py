"""Curves over the cost: progress of methods by targets, quartiles of their runs, and instances."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench.reports.contest.ranks import interval
from bench.reports.contest.running_time import (
    ecdf,
    expected_running_time,
    performance_ratios,
    profile,
    simplex_gradients,
    spent,
)
from bench.reports.contest.runs import Contest
from bench.reports.contest.targets import Measure
from bench.reports.identification.trace_table import QUARTILES, STEPS_PER_DECADE
from ksmea.arrays import Array

REACH = 10.0  # by which costs of data profiles go beyond the largest of a run: expected running times may
FACTORS = np.geomspace(1, 1000, 61)  # of performance profiles


def ecdf_frame(contest: Contest, weights: Array) -> pd.DataFrame:
    """A row per group of instances, method, measure and cost per unknown.

    The share of targets and runs reached by then, the share with its interval.
    """
    grid = cost_grid(contest)
    rows = []
    for measure in contest.measures:
        hits = contest.hits[measure.name] / contest.unknowns[:, None]
        shares = contest.summed(np.array([ecdf(each, grid) for each in hits])).swapaxes(0, 1)
        runs = contest.summed(np.ones(len(hits))).T[..., None]
        for group, mask in contest.groups().items():
            drawn = weights[:, mask]
            found = shares[mask].sum(axis=0) / runs[mask].sum(axis=0)
            for number, method in enumerate(contest.methods):
                draws = (drawn @ shares[mask, number]) / (drawn @ runs[mask, number])
                low, high = interval(draws)
                place = {"family": group, "method": method, "measure": measure.name, "cost_per_unknown": grid}
                rows.append(pd.DataFrame({**place, "share": found[number], "low": low, "high": high}))
    return pd.concat(rows, ignore_index=True)


def cost_grid(contest: Contest) -> Array:
    """Costs per unknown from 1 to the largest, evenly spaced in their logarithms."""
    decades = np.log10(max(contest.most, 1.0))
    return np.asarray(np.geomspace(1.0, max(contest.most, 1.0), max(int(np.ceil(decades * STEPS_PER_DECADE)) + 1, 2)))


def anytime_frame(contest: Contest) -> pd.DataFrame:
    """A row per group of instances, method and cost per unknown.

    Quartiles over the runs of what they had by then, infinite where they had nothing; after its end a run keeps what it
    has.
    """
    grid = cost_grid(contest)
    values = {measure.name: _by_cost(contest, measure, grid) for measure in contest.measures}
    rows = []
    for group, mask in contest.groups().items():
        for number, method in enumerate(contest.methods):
            mine = (mask[contest.runs["instance"]] & (contest.runs["method"] == number)).to_numpy()
            quartiles = {
                f"{name}_{quartile}": found
                for name, had in values.items()
                for quartile, found in zip(
                    ("q1", "median", "q3"), np.quantile(had[mine], QUARTILES, axis=0, method="inverted_cdf")
                )
            }
            rows.append(pd.DataFrame({"family": group, "method": method, "cost_per_unknown": grid, **quartiles}))
    return pd.concat(rows, ignore_index=True)


def _by_cost(contest: Contest, measure: Measure, grid: Array) -> Array:
    """Best value of each run at each cost per unknown, (n_run, n_grid)."""
    had, unknowns = np.full((len(contest.runs), len(grid)), np.inf), contest.unknowns
    for number, (key, price, failed) in enumerate(contest.runs[["key", "price", "failed"]].itertuples(index=False)):
        if failed or key not in contest.traces:
            continue
        traced = contest.traces[key]
        costs = traced.costs(price)
        at = np.searchsorted(costs, grid * unknowns[number], side="right") - 1
        values = np.nan_to_num(getattr(traced, measure.name), nan=np.inf)
        had[number] = np.where(at >= 0, values[at], np.inf)
    return had


def profiles_frame(contest: Contest) -> pd.DataFrame:
    """A row per group of instances, method, profile and point of it.

    The share of instances whose expected running time to the first measure's main target is within it.
    """
    measure = contest.measures[0]
    hits = contest.hits[measure.name][:, [measure.main_index]]
    costs = contest.summed(spent(hits, contest.runs["cost"].to_numpy()))[..., 0].T
    times = expected_running_time(costs, contest.summed(np.isfinite(hits))[..., 0].T)
    gradients = simplex_gradients(times, contest.instances["unknowns"].to_numpy())
    profiles = {
        "performance": (performance_ratios(times), FACTORS),
        "data": (gradients, np.geomspace(1, REACH * contest.most, len(FACTORS))),
    }
    rows = []
    for group, mask in contest.groups().items():
        for name, (values, grid) in profiles.items():
            found = profile(values[mask], grid)
            rows += [
                pd.DataFrame(
                    {"family": group, "method": method, "profile": name, "at": grid, "share": found[:, number]}
                )
                for number, method in enumerate(contest.methods)
            ]
    return pd.concat(rows, ignore_index=True)
