"""Particle swarm: Table 5, the count, and the swarm's equation of motion."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.numerics.objective import Objective
from optimizers.pso import PSO, initial_velocity

LOWEST = np.array([0.31, 0.62, 0.17, 0.74, 0.45])


def swarms(pso, residuals_at=lambda u: u - LOWEST, seed=0):
    seen = []

    def noted(u):
        seen.append(u.copy())
        return residuals_at(u)

    pso.minimize(Objective(5, noted), np.random.default_rng(seed))
    return seen


def test_defaults_are_table_5():
    pso = PSO()
    assert (pso.inertia, pso.social, pso.cognitive, pso.population) == (0.5, 2.0, 0.5, 100)


@pytest.mark.parametrize("population, generations", [(100, 100), (1, 1), (7, 12)])
def test_a_move_is_one_batch_and_the_count_is_exact(population, generations):
    seen = swarms(PSO(population=population, generations=generations))
    assert [len(points) for points in seen] == [population] * (generations + 1)


def test_it_starts_from_a_latin_hypercube():
    first = swarms(PSO(population=20, generations=1))[0]
    assert np.array_equal(np.sort(np.floor(first * 20), axis=0), np.tile(np.arange(20.0)[:, None], 5))


def test_first_velocities_lead_into_the_cube_and_to_no_side():
    position = np.random.default_rng(0).random((20_000, 5))
    velocity = initial_velocity(position, np.random.default_rng(1))
    assert np.all((position + velocity >= 0) & (position + velocity <= 1))
    assert np.abs(velocity.mean(axis=0)).max() < 5 * np.sqrt(1 / 6 / 20_000)  # variance 1/12 + 1/12, five deviations


def test_without_attraction_particles_move_by_inertia_alone():
    """c₁ = c₂ = 0: x₂ − x₁ = w (x₁ − x₀), where no bound is met."""
    x0, x1, x2 = swarms(PSO(population=50, generations=2, inertia=0.5, cognitive=0.0, social=0.0))
    # the first move is already w v₀ and ends half-way to a point of the cube
    assert np.allclose(np.clip(x1 + 0.5 * (x1 - x0), 0, 1), x2, atol=1e-12)


def test_the_global_best_attracts_by_at_most_the_social_coefficient():
    """w = c₁ = 0: x₁ = x₀ + c₂ r (best − x₀) with r in [0, 1], in each coordinate."""
    x0, x1 = swarms(PSO(population=50, generations=1, inertia=0.0, cognitive=0.0, social=0.5))
    best = x0[np.argmin(np.sum((x0 - LOWEST) ** 2, axis=1))]
    others = np.any(x0 != best, axis=1)
    share = (x1 - x0)[others] / (best - x0)[others]
    assert share.min() >= 0 and share.max() <= 0.5 and share.std() > 0.1


def test_a_particle_that_leaves_stops_at_the_nearest_bound():
    points = np.concatenate(swarms(PSO(), lambda u: u - np.array([-1.0, 2.0, 0.5, 0.5, 0.5])))
    assert np.all((points >= 0) & (points <= 1))
    assert np.mean(points[:, 0] == 0) > 0.2 and np.mean(points[:, 1] == 1) > 0.2


def test_it_finds_the_lowest_point_of_a_sphere():
    minimum = PSO().minimize(Objective(5, lambda u: u - LOWEST), np.random.default_rng(1))
    assert minimum.value < 1e-12


def test_settings_out_of_range_are_refused():
    with pytest.raises(SettingError, match="inertia"):
        PSO(inertia=-0.1)
    with pytest.raises(SettingError, match="generations"):
        PSO(generations=0)
