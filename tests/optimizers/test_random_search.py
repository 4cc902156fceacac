"""Random search: uniform points, as many as asked for, the same for any batch."""

import numpy as np
from scipy import stats

from ksmea.numerics.objective import Objective
from landscapes import noted, sphere
from optimizers.random_search import RandomSearch


def points(**settings):
    residuals_at, seen = noted(sphere)
    RandomSearch(**settings).minimize(Objective(5, residuals_at), np.random.default_rng(0))
    return seen


def test_the_points_are_the_same_for_any_batch():
    by_batch = [points(evaluations=2500, batch=batch) for batch in (1000, 300, 5000)]
    assert [len(batch) for batch in by_batch[0]] == [1000, 1000, 500]
    first, *others = (np.concatenate(batches) for batches in by_batch)
    assert all(np.array_equal(first, other) for other in others)


def test_they_are_uniform_and_independent():
    """Kolmogorov and Smirnov's test of each coordinate, and correlations of some 1/√n."""
    drawn = np.concatenate(points(evaluations=4000))
    assert min(stats.kstest(column, "uniform").pvalue for column in drawn.T) > 0.001
    assert np.max(np.abs(np.corrcoef(drawn.T) - np.eye(5))) < 5 / np.sqrt(4000)
