"""Tests of the differences between methods: all, each pair, and both halves of the repetitions."""

from __future__ import annotations

import pandas as pd

from bench.reports.contest.paired_tests import friedman, pairs_frame
from bench.reports.contest.runs import Contest
from bench.reports.contest.scores import criteria, halves
from ksmea.arrays import Array


def friedman_frame(contest: Contest, weights: Array) -> pd.DataFrame:
    """A row per group of instances and criterion.

    Friedman's test, and Kendall's τ between the rankings of even and odd repetitions.
    """
    rows = []
    for group, mask in contest.groups().items():
        for name, criterion in criteria(contest).items():
            test = friedman(criterion.scores(contest)[mask])
            tau = halves(contest, criterion, mask, weights)
            rows.append(
                {
                    "family": group,
                    "criterion": name,
                    "instances": int(mask.sum()),
                    "friedman_chi2": test.chi2,
                    "friedman_p": test.p,
                    "tau_of_halves": tau.tau,
                    "tau_low": tau.low,
                    "tau_high": tau.high,
                }
            )
    return pd.DataFrame(rows)


def all_pairs_frame(contest: Contest) -> pd.DataFrame:
    """A row per group of instances, criterion and pair of methods (`pairs_frame`)."""
    rows = []
    for group, mask in contest.groups().items():
        for name, criterion in criteria(contest).items():
            pairs = pairs_frame(criterion.scores(contest)[mask], contest.methods)
            pairs.insert(0, "criterion", name)
            pairs.insert(0, "family", group)
            rows.append(pairs)
    return pd.concat(rows, ignore_index=True)


def instances_frame(contest: Contest) -> pd.DataFrame:
    """A row per instance with its settings, and the median excess and error that each method ended with."""
    frame = contest.instances.copy()
    for measure in contest.measures:
        medians = contest.medians(contest.runs[measure.name].to_numpy(float))
        for number, method in enumerate(contest.methods):
            frame[f"{measure.name}: {method}"] = medians[:, number]
    return frame
