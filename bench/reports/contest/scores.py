"""By what methods are ranked, as scores of instances: medians over the draws, lower for better."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bench.reports.contest.ranks import Agreement, agreement
from bench.reports.contest.running_time import area
from bench.reports.contest.runs import Contest
from bench.reports.contest.targets import resolved
from ksmea.arrays import Array

WORDS = {
    "excess": "excess at the end",
    "error": "error at the end",
    "speed": "how early targets of the excess are reached",
}


@dataclass(frozen=True)
class Criterion:
    """Score of each run (n_run,), lower is better; `resolves`: medians are compared by `resolved`."""

    name: str
    values: Array
    resolves: bool

    def scores(self, contest: Contest, draws: np.ndarray | None = None) -> Array:
        """Medians over the draws, or some of them (n_run,), as (n_instance, n_method)."""
        medians = contest.medians(self.values, draws)
        return np.where(np.isnan(medians), np.nan, resolved(medians)) if self.resolves else medians


def criteria(contest: Contest) -> dict[str, Criterion]:
    """Excess at the end, error at the end, and speed, by name; the first one orders all tables.

    A measure without a finite value is omitted. Speed is how early the targets of the first measure are reached.
    """
    found = {
        each.name: Criterion(each.name, contest.runs[each.name].to_numpy(float), True) for each in contest.measures
    }
    if contest.measures:
        found["speed"] = Criterion("speed", -speed(contest), False)
    return found


def speed(contest: Contest) -> Array:
    """Area under each run's ECDF of the first measure (n_run,), 0 to 1."""
    per_unknown = contest.hits[contest.measures[0].name] / contest.unknowns[:, None]
    return area(per_unknown, contest.most)


def halves(contest: Contest, criterion: Criterion, mask: np.ndarray, weights: Array) -> Agreement:
    """Whether even and odd repetitions rank the methods alike, on the instances of a mask that have both.

    `weights` are of all instances.
    """
    is_even = (contest.runs["repetition"] % 2 == 0).to_numpy()
    even, odd = (criterion.scores(contest, draws) for draws in (is_even, ~is_even))
    both = mask & ~np.isnan(even).any(axis=1) & ~np.isnan(odd).any(axis=1)
    drawn = weights[:, both]
    return agreement(even[both], odd[both], drawn[drawn.sum(axis=1) > 0])


def all_scores(contest: Contest) -> Mapping[str, Array]:
    """Scores (n_instance, n_method) by criterion."""
    return {name: criterion.scores(contest) for name, criterion in criteria(contest).items()}
