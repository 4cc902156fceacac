"""Genetic algorithm: Table 5, decoding by hand, the count of changed individuals."""

import random

import numpy as np
import pytest
from deap import algorithms

from ksmea.errors import SettingError
from ksmea.numerics.isolation import global_generators
from ksmea.numerics.objective import Objective
from optimizers.ga import GA, Chromosome, decode

LOWEST = np.array([0.31, 0.62, 0.17, 0.74, 0.45])


def batches(ga, seed=0):
    seen = []

    def noted(u):
        seen.append(u.copy())
        return u - LOWEST

    ga.minimize(Objective(5, noted), np.random.default_rng(seed))
    return seen


def test_defaults_are_table_5():
    ga = GA()
    assert (ga.crossover_rate, ga.mutation_rate, ga.chromosome_length, ga.population) == (0.5, 0.1, 52, 100)
    assert ga._shared(5) == [11, 11, 10, 10, 10]


def test_binary_code_by_hand():
    chromosomes = np.array([[0, 0, 0, 0, 0], [1, 1, 1, 1, 1], [0, 1, 1, 0, 0], [1, 0, 0, 1, 1]])
    expected = [[0, 0], [1, 1], [1 / 3, 4 / 7], [2 / 3, 3 / 7]]
    assert np.allclose(decode(chromosomes, [2, 3]), expected, rtol=0, atol=1e-15)


def test_gray_code_by_hand():
    """000, 001, 011, 010, 110, 111, 101, 100 count from 0 to 7."""
    counting = [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1], [1, 0, 0]]
    assert np.allclose(decode(np.array(counting), [3], gray=True).ravel() * 7, np.arange(8), rtol=0, atol=1e-14)


def test_gray_code_starts_anew_with_each_parameter():
    assert np.array_equal(decode(np.array([[1, 0, 0, 1]]), [2, 2], gray=True), [[1.0, 1 / 3]])


def test_a_long_gene_reaches_the_upper_bound_exactly():
    assert decode(np.ones((1, 52), dtype=int), [52]) == 1.0


def test_points_lie_on_the_grid_of_the_bits():
    points = np.concatenate(batches(GA(generations=5)))
    steps = points * (2.0 ** np.array([11, 11, 10, 10, 10]) - 1)
    assert np.allclose(steps, np.round(steps), rtol=0, atol=1e-9)


def test_copies_are_independent_and_keep_their_misfit():
    toolbox, parent = GA()._toolbox(), Chromosome([0, 1] * 26)
    parent.fitness.values = (2.0,)
    child = toolbox.clone(parent)
    child[0] = 1
    del child.fitness.values
    assert parent[0] == 0 and parent.fitness.values == (2.0,) and not child.fitness.valid


@pytest.mark.parametrize(
    "crossover_rate, mutation_rate, per_generation",
    [(0.0, 0.0, 0), (1.0, 0.0, 20), (0.0, 1.0, 20)],
)
def test_only_changed_individuals_are_evaluated(crossover_rate, mutation_rate, per_generation):
    ga = GA(population=20, generations=3, crossover_rate=crossover_rate, mutation_rate=mutation_rate)
    expected = [20] + [per_generation] * 3 if per_generation else [20]
    assert [len(points) for points in batches(ga)] == expected


def test_the_mean_count_is_that_of_the_rates():
    counts = [len(points) for points in batches(GA(generations=200))[1:]]
    # 1 − 0.5 · 0.9 = 55 % of 100; pairs cross together, so one generation spreads by 6.5, the mean of 200 by 0.5
    assert np.mean(counts) == pytest.approx(55, abs=2.5)


def test_one_rate_per_bit_is_a_choice_of_settings():
    """Table 5's 0.1 read as a rate per bit: without selection and crossover a tenth of all bits flips."""
    ga = GA(mutation_rate=1.0, bit_flip_rate=0.1, crossover_rate=0.0)
    toolbox = ga._toolbox()
    with global_generators(np.random.default_rng(0)):
        mutants = algorithms.varAnd([Chromosome([0] * 52) for _ in range(400)], toolbox, 0.0, ga.mutation_rate)
    assert np.mean(mutants) == pytest.approx(0.1, abs=5 * np.sqrt(0.09 / 400 / 52))


def test_without_elites_it_is_eaSimple_of_deap():
    ga, rng, points = GA(population=10, generations=6), np.random.default_rng(2), []
    toolbox = ga._toolbox()

    def evaluate(individual):
        points.append(decode(np.array([individual]), ga._shared(5))[0])
        return (float(np.sum((points[-1] - LOWEST) ** 2)),)

    toolbox.register("evaluate", evaluate)
    population = [Chromosome(bits) for bits in rng.integers(2, size=(10, 52)).tolist()]
    with global_generators(rng):
        algorithms.eaSimple(population, toolbox, ga.crossover_rate, ga.mutation_rate, 6, verbose=False)
    assert np.array_equal(np.concatenate(batches(ga, seed=2)), points)


def test_elites_survive_a_search_that_forgets():
    """With every bit redrawn each generation only elites can carry the best point on, and elites are not re-evaluated."""
    ga = GA(population=10, generations=5, elites=3, mutation_rate=1.0, bit_flip_rate=0.5)
    assert [len(points) for points in batches(ga)] == [10] + [7] * 5


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_it_finds_the_lowest_point_of_a_sphere_to_the_resolution_of_its_grid(seed):
    ga = GA(gray=True, elites=2, mutation_rate=0.5, generations=200)
    minimum = ga.minimize(Objective(5, lambda u: u - LOWEST), np.random.default_rng(seed))
    step = 1 / (2.0 ** np.array(ga._shared(5)) - 1)
    assert np.all(np.abs(minimum.u - LOWEST) <= step)  # at most the second nearest grid point


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_table_5_settings_come_near_a_sphere_without_reaching_the_resolution(seed):
    # plain binary code stalls before Hamming cliffs; 0.02 is twice the worst of eight seeds
    minimum = GA().minimize(Objective(5, lambda u: u - LOWEST), np.random.default_rng(seed))
    assert minimum.value < 0.02


def test_bits_that_do_not_add_up_are_refused():
    with pytest.raises(SettingError, match=r"chromosome_length = 52.* which is 50; .*chromosome_length=50"):
        GA(bits=[10, 10, 10, 10, 10])


def test_another_number_of_parameters_says_what_to_write():
    with pytest.raises(
        SettingError, match=r"bits: expected one entry for each of 3 parameters, got 2 entries; leave it null"
    ):
        GA(bits=[26, 26]).minimize(Objective(3, lambda u: u), np.random.default_rng(0))
    minimum = GA(bits=[18, 17, 17]).minimize(Objective(3, lambda u: u - 0.3), np.random.default_rng(0))
    assert minimum.value < 0.02


def test_as_many_elites_as_individuals_are_refused():
    with pytest.raises(SettingError, match="elites"):
        GA(population=10, elites=10)


def test_bits_are_shared_evenly_by_any_number_of_unknowns():
    for dim in (1, 3, 7):
        bits = GA()._shared(dim)
        assert len(bits) == dim and sum(bits) == 52 and max(bits) - min(bits) <= 1
        GA().check_dimension(dim)
    with pytest.raises(SettingError, match="chromosome_length: expected a bit at least for each of 53"):
        GA().check_dimension(53)


def test_deap_draws_from_the_isolated_generator_only():
    state = random.getstate()
    batches(GA(generations=2))
    assert random.getstate() == state
