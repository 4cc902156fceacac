"""Downhill simplex: the count, convergence, and minima that one start misses."""

import numpy as np
import pytest

from ksmea.numerics.objective import Objective
from landscapes import noted, rastrigin, rosenbrock, sphere
from optimizers.nelder_mead import NelderMead


@pytest.mark.parametrize("evaluations", [1, 6, 500, 3000])
def test_the_evaluations_are_used_exactly_one_at_a_time(evaluations):
    residuals_at, seen = noted(sphere)
    NelderMead(evaluations=evaluations).minimize(Objective(5, residuals_at), np.random.default_rng(0))
    assert [len(points) for points in seen] == [1] * evaluations


@pytest.mark.parametrize("adaptive", [False, True])
def test_it_finds_the_lowest_point_of_a_sphere(adaptive):
    found = NelderMead(adaptive=adaptive).minimize(Objective(5, sphere), np.random.default_rng(0))
    assert found.value < 1e-12  # the simplex shrinks to 1e-8 of the width


def test_it_follows_the_bent_valley_of_rosenbrock():
    found = NelderMead().minimize(Objective(3, rosenbrock), np.random.default_rng(0))
    assert np.allclose(found.u, 0.75, rtol=0, atol=1e-5)


def test_a_minimum_on_the_bounds_is_reached():
    target = np.array([-0.2, 1.3, 0.5])
    found = NelderMead().minimize(Objective(3, lambda u: u - target), np.random.default_rng(0))
    assert np.allclose(found.u, np.clip(target, 0, 1), rtol=0, atol=1e-6)


@pytest.mark.slow
def test_restarts_find_the_lowest_of_many_minima():
    """Of 8² minima in two dimensions one start finds the lowest rarely; 5000 evaluations are some fifty starts."""
    found = [
        [
            NelderMead(evaluations=n).minimize(Objective(2, rastrigin), np.random.default_rng(seed)).value < 0.5
            for seed in range(5)
        ]
        for n in (100, 5000)
    ]
    assert sum(found[0]) < 3 and sum(found[1]) == 5
