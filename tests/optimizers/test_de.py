"""Differential evolution: Table 5, the count, and convergence of rand/1/bin."""

from collections import Counter
from itertools import permutations

import numpy as np
import pytest
from scipy.stats import chi2

from ksmea.errors import SettingError
from ksmea.numerics.objective import Objective
from optimizers.de import DE, STRATEGIES, others

LOWEST = np.array([0.31, 0.62, 0.17, 0.74, 0.45])


def test_defaults_are_table_5():
    de = DE()
    assert (de.mutation_factor, de.crossover_rate, de.population, de.strategy) == (0.8, 0.95, 100, "rand1bin")


def batches(de, residuals_at, dim=5, seed=0):
    seen = []

    def noted(u):
        seen.append(u.copy())
        return residuals_at(u)

    de.minimize(Objective(dim, noted), np.random.default_rng(seed))
    return seen


@pytest.mark.parametrize("population, generations", [(100, 100), (5, 1), (7, 12)])
def test_a_generation_is_one_batch_and_the_count_is_exact(population, generations):
    seen = batches(DE(population=population, generations=generations), lambda u: u - LOWEST)
    assert [len(points) for points in seen] == [population] * (generations + 1)


@pytest.mark.parametrize("residual", [0.0, 1.0, np.nan])
def test_the_count_does_not_depend_on_a_spread_of_the_misfit(residual):
    seen = batches(DE(population=10, generations=4), lambda u: np.full_like(u, residual))
    assert sum(map(len, seen)) == 50


def test_it_starts_from_a_latin_hypercube():
    first = batches(DE(population=20, generations=1), lambda u: u - LOWEST)[0]
    assert np.array_equal(np.sort(np.floor(first * 20), axis=0), np.tile(np.arange(20.0)[:, None], 5))


def test_trials_are_rand_1_mutants_where_crossover_always_takes_the_mutant():
    """C = 1, eq. (26): every trial inside the bounds is z_r1 + F (z_r2 − z_r3) with three different other members."""
    parents, trials = batches(DE(population=6, generations=1, crossover_rate=1.0, mutation_factor=0.1), lambda u: u)
    indices = [(a, b, c) for a in range(6) for b in range(6) for c in range(6) if len({a, b, c}) == 3]
    mutants = np.array([parents[a] + 0.1 * (parents[b] - parents[c]) for a, b, c in indices])
    inside = np.all((mutants > 0) & (mutants < 1), axis=1)
    matched = [np.abs(mutants[inside] - trial).max(axis=1).min() < 1e-12 for trial in trials]
    assert np.mean(matched) >= 0.5  # the others left the bounds and had coordinates drawn anew


def test_without_crossover_one_coordinate_comes_from_the_mutant():
    """C = 0: of each trial only coordinate j_rand differs from its parent, eq. (27)."""
    parents, trials = batches(DE(population=8, generations=1, crossover_rate=0.0), lambda u: u - LOWEST)
    assert np.all(np.sum(trials != parents, axis=1) == 1)


def test_the_others_of_a_member_are_different_and_all_alike_likely():
    """5 members, 3 others each: 24 ordered choices. χ² of 20 000 draws for each of five members, below its 1 − 1e-6 quantile."""
    rng, n_draw = np.random.default_rng(2), 20_000
    drawn = np.array([others(5, 3, rng) for _ in range(n_draw)])
    for member in range(5):
        counts = Counter(map(tuple, drawn[:, :, member].tolist()))
        assert set(counts) == set(permutations([each for each in range(5) if each != member], 3))
        found = np.array(list(counts.values()))
        expected = n_draw / len(counts)
        assert np.sum((found - expected) ** 2 / expected) < chi2.ppf(1 - 1e-6, len(counts) - 1)


def test_it_converges_as_scipys_loop_does():
    """Medians of ten seeds after 60 generations, of log10 of the misfit; each route spreads by 0.3 decades."""

    def ended(evolve, seed):
        objective = Objective(5, lambda u: u - LOWEST)
        rng = np.random.default_rng(seed)
        evolve(DE(population=40), objective, rng.random((40, 5)), rng)
        return np.log10(objective.result().value)

    own, scipys = ([ended(route, seed) for seed in range(10)] for route in (DE._evolve, DE._evolve_by_scipy))
    assert np.median(own) == pytest.approx(np.median(scipys), abs=0.4)


def test_it_finds_the_lowest_point_of_a_sphere():
    # 100 members contract slowly: after 100 generations the misfit is near 1e-6, a distance of 0.1 % of the width
    minimum = DE().minimize(Objective(5, lambda u: u - LOWEST), np.random.default_rng(1))
    assert minimum.value < 5e-5
    longer = DE(generations=400).minimize(Objective(5, lambda u: u - LOWEST), np.random.default_rng(1))
    assert longer.value < 1e-18


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_every_strategy_runs(strategy):
    seen = batches(DE(strategy=strategy, population=10, generations=20), lambda u: u - LOWEST)
    misfit = [np.sum((points - LOWEST) ** 2, axis=1).min() for points in seen]
    assert min(misfit) < misfit[0] and len(seen) == 21


def test_settings_out_of_range_are_refused():
    with pytest.raises(SettingError, match="mutation_factor"):
        DE(mutation_factor=2.0)
    with pytest.raises(SettingError, match="population"):
        DE(population=4)
    with pytest.raises(SettingError, match="did you mean 'rand1bin'"):
        DE(strategy="rand1bim")
