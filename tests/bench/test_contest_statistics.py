"""Statistics of contests against published examples, closed forms and sums by hand."""

import numpy as np
import pandas as pd
import pytest
import scipy

from bench.reports.contest.paired_tests import cliques, friedman, holm, pairs_frame
from bench.reports.contest.ranks import agreement, interval, interval_of_shares, ranking, ranks, resamples
from bench.reports.contest.running_time import (
    area,
    break_even,
    ecdf,
    expected_running_time,
    performance_ratios,
    profile,
    resampled_running_time,
    simplex_gradients,
    spent,
)
from bench.reports.contest.targets import ERROR, EXCESS, reached, resolved

# Demšar, J. Mach. Learn. Res. 7 (2006) 1–30, Table 6: AUC of C4.5, C4.5+m, C4.5+cf and C4.5+m+cf on 14 data sets.
AUC = np.array(
    [
        [0.763, 0.768, 0.771, 0.798],
        [0.599, 0.591, 0.590, 0.569],
        [0.954, 0.971, 0.968, 0.967],
        [0.628, 0.661, 0.654, 0.657],
        [0.882, 0.888, 0.886, 0.898],
        [0.936, 0.931, 0.916, 0.931],
        [0.661, 0.668, 0.609, 0.685],
        [0.583, 0.583, 0.563, 0.625],
        [0.775, 0.838, 0.866, 0.875],
        [1.000, 1.000, 1.000, 1.000],
        [0.940, 0.962, 0.965, 0.962],
        [0.619, 0.666, 0.614, 0.669],
        [0.972, 0.981, 0.975, 0.975],
        [0.957, 0.978, 0.946, 0.970],
    ]
)
CLASSIFIERS = ("C4.5", "C4.5+m", "C4.5+cf", "C4.5+m+cf")
VOTING = 12  # its last two are printed alike, and ranked by digits that are not printed: 2 and 3


@pytest.fixture
def scores():
    """Lower for better, in thousandths so that printed ties are ties, with the digit that the table leaves out."""
    made = -np.round(1000 * AUC)
    made[VOTING, 3] += 1e-3
    return made


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def test_mean_ranks_are_those_of_demsars_example(scores):
    assert ranks(scores).mean(axis=0) == pytest.approx([3.143, 2.000, 2.893, 1.964], abs=5e-4)  # as printed


def test_friedmans_statistic_is_that_of_demsars_example(scores):
    """He prints 9.28 without a correction for ties; four data sets have 2, 2, 4 and 2 values alike: Σ(t³ − t) = 78 of
    N k (k² − 1) = 840."""
    found = friedman(scores)
    assert found.chi2 * (1 - 78 / 840) == pytest.approx(9.28, abs=5e-3)
    assert found.p == pytest.approx(scipy.stats.chi2.sf(found.chi2, 3))


def test_two_methods_are_not_compared_by_friedman_and_equal_ones_do_not_differ(scores):
    assert np.isnan(friedman(scores[:, :2]).p)
    assert friedman(np.ones((6, 3))).p == 1.0


def test_pairs_are_counted_and_corrected_together(scores):
    frame = pairs_frame(scores, CLASSIFIERS)
    first = frame.iloc[0]  # C4.5 against C4.5+m
    assert (first["better"], first["worse"], first["alike"]) == (2, 10, 2)
    # sect. 3.1.3: T = min(R+, R-) = 12 of 14 data sets, zeros shared by both sides; z = (T − n (n + 1) / 4) / √(n (n + 1) (2n + 1) / 24)
    z = (12 - 14 * 15 / 4) / np.sqrt(14 * 15 * 29 / 24)
    assert first["p"] == pytest.approx(2 * scipy.stats.norm.cdf(z), rel=0.02)  # ties make the variance a little smaller
    assert (frame["p_holm"] >= frame["p"]).all()


def test_a_method_that_has_nothing_is_worse_and_two_that_have_nothing_are_alike():
    scores = np.array([[0.0, np.inf, np.inf]] * 8)
    frame = pairs_frame(scores, "abc").set_index(["method", "other"])
    assert frame.loc[("a", "b"), ["better", "worse", "alike"]].tolist() == [8, 0, 0]
    assert frame.loc[("a", "b"), "p"] == pytest.approx(2**-7)  # all of eight agree
    assert frame.loc[("b", "c"), ["alike", "p"]].tolist() == [8, 1.0]


def test_holm_by_hand():
    # 4 · 0.005, 3 · 0.01, then 2 · 0.03 and, below it, 1 · 0.04
    assert holm(np.array([0.01, 0.04, 0.03, 0.005])) == pytest.approx([0.03, 0.06, 0.06, 0.02])


def test_cliques_are_the_longest_stretches_that_no_test_tells_apart():
    pairs = pd.DataFrame([("a", "c"), ("a", "d"), ("b", "d")], columns=["method", "other"]).assign(told_apart=True)
    assert cliques("abcd", pairs) == [("a", "b"), ("b", "c"), ("c", "d")]
    assert cliques("abcd", pairs[:2]) == [("a", "b"), ("b", "c", "d")]
    assert cliques("abcd", pairs[:0]) == [("a", "b", "c", "d")]


def test_expected_running_time_by_hand():
    """Reached after 10, after 30, and not within 100: 140 / 2. What nothing reaches takes for ever."""
    hits = np.array([[10.0, np.inf], [30.0, np.inf], [np.inf, np.inf]])
    costs = spent(hits, np.array([80.0, 90.0, 100.0]))
    assert costs.tolist() == [[10.0, 80.0], [30.0, 90.0], [100.0, 100.0]]
    assert expected_running_time(costs.sum(axis=0), np.isfinite(hits).sum(axis=0)).tolist() == [70.0, np.inf]


def test_running_times_of_resamples_weigh_instances_as_they_are_drawn():
    costs, successes = np.array([[100.0], [30.0]]), np.array([[1], [3]])
    weights = np.array([[1, 1], [2, 0], [0, 2]])
    assert resampled_running_time(costs, successes, weights)[:, 0].tolist() == [32.5, 100.0, 10.0]


def test_a_target_is_reached_where_the_values_stay_below_it():
    assert reached(np.array([50.0, 8.0, 12.0, 6.0]), (100.0, 10.0, 7.0, 1.0)).tolist() == [0, 3, 3, 4]
    assert reached(np.array([np.nan]), EXCESS.targets).tolist() == [1] * len(EXCESS.targets)
    assert reached(np.array([]), ERROR.targets).tolist() == [0] * len(ERROR.targets)


def test_what_the_data_cannot_tell_apart_ties():
    excess = np.array([-3.0, 1e-9, 0.12, 0.9, np.inf])
    assert ranks(resolved(excess)[None])[0].tolist() == [2.0, 2.0, 2.0, 4.0, 5.0]


def test_the_area_is_that_under_the_ecdf(rng):
    hits = np.where(rng.random((40, 5)) < 0.3, np.inf, 10 ** rng.uniform(-0.5, 2.2, (40, 5)))
    grid = np.geomspace(1, 100, 20001)  # over which the steps of 200 pairs are summed, to 200 / 20000 of one pair
    curve = ecdf(hits, grid)
    assert np.all(np.diff(curve) >= 0)
    assert area(hits, 100.0).mean() == pytest.approx(np.trapezoid(curve, np.log(grid)) / np.log(100), abs=1e-4)


def test_profiles_by_hand():
    times = np.array([[10.0, 20.0], [60.0, 30.0], [np.inf, 5.0], [np.inf, np.inf]])
    ratios = performance_ratios(times)
    assert ratios.tolist() == [[1.0, 2.0], [2.0, 1.0], [np.inf, 1.0], [np.inf, np.inf]]
    assert profile(ratios, [1.0, 2.0]).tolist() == [[0.25, 0.5], [0.5, 0.75]]
    gradients = simplex_gradients(times, [4, 5, 4, 4])
    assert gradients[:2].tolist() == [[2.0, 4.0], [10.0, 5.0]]
    assert profile(gradients, [2.0])[0].tolist() == [0.25, 0.25]


def test_agreement_is_kendalls_tau_of_mean_ranks(rng):
    one, other = rng.random((30, 6)), rng.random((30, 6))
    other += 0.3 * np.arange(6)
    one += 0.3 * np.arange(6)
    weights = resamples(["a"] * 30, rng, n=50)
    found = agreement(one, other, weights)
    means = [ranks(each).mean(axis=0) for each in (one, other)]
    assert found.tau == pytest.approx(scipy.stats.kendalltau(*means).statistic)
    drawn = [[scipy.stats.kendalltau(*(w @ ranks(each) for each in (one, other))).statistic] for w in weights]
    assert [found.low, found.high] == pytest.approx(interval(np.array(drawn))[:, 0])
    assert agreement(one, one, weights).low == 1.0
    assert agreement(one, -one, weights).high == -1.0


def test_families_keep_their_weight_in_resamples(rng):
    weights = resamples(["a", "b", "a", "b", "b"], rng, n=200)
    assert (weights[:, [0, 2]].sum(axis=1) == 2).all() and (weights[:, [1, 3, 4]].sum(axis=1) == 3).all()
    assert len(np.unique(weights, axis=0)) > 10


def test_the_bootstrap_has_the_standard_error_of_a_mean(rng):
    """Of mean ranks of two methods, the first better with a chance of 0.7 on each of 200 instances: √(0.7 · 0.3 / 200)."""
    scores = np.where(rng.random((200, 1)) < 0.7, [[0.0, 1.0]], [[1.0, 0.0]])
    found = ranking(scores, resamples(["a"] * 200, rng))
    low, high = found.ends[:, 0]
    assert (high - low) / (2 * 1.96) == pytest.approx(np.sqrt(0.21 / 200), rel=0.15)  # ends of 1000 samples
    assert found.first[0] == 1.0 and found.mean.sum() == 3.0


def test_methods_that_tie_everywhere_are_first_in_equal_shares(rng):
    assert ranking(np.ones((5, 4)), resamples(["a"] * 5, rng)).first == pytest.approx([0.25] * 4)


def test_shares_without_variation_have_intervals_all_the_same():
    """Six instances of six: Wilson's interval is from n / (n + z²)."""
    shares, draws = np.array([0.0, 0.5, 1.0]), np.tile([0.0, 0.5, 1.0], (10, 1))
    low, high = interval_of_shares(shares, draws, 6)
    assert low == pytest.approx([0.0, 0.5, 6 / (6 + 1.96**2)], abs=1e-4)
    assert high == pytest.approx([1 - 6 / (6 + 1.96**2), 0.5, 1.0], abs=1e-4)


def test_break_even_is_where_totals_are_alike():
    price = break_even(20.0, 4.0, [(1000.0, 0.1), (100.0, 2.0), (np.inf, np.inf)])
    assert price == pytest.approx(2.0 / 80)  # the second is the fastest there
    assert 20 * price + 4 == pytest.approx(min(1000 * price + 0.1, 100 * price + 2))
    assert break_even(20.0, 0.1, [(1000.0, 1.0)]) == 0.0
    assert np.isnan(break_even(20.0, 4.0, [(15.0, 9.0)])) and np.isnan(break_even(np.inf, 4.0, [(15.0, 9.0)]))
