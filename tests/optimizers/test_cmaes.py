"""CMA-ES: its generations, its restarts, what they find, and what is said where its library is missing."""

import importlib.util
import sys

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.numerics.objective import Objective
from ksmea.plugins.registry import create
from landscapes import LOWEST, noted, rastrigin, rosenbrock, sphere
from optimizers.cmaes import CMAES


def sizes(cmaes, residuals_at, seed=0):
    """Of all generations; the mean of the population, evaluated alone at the end of a start, is left out."""
    residuals_at, seen = noted(residuals_at)
    cmaes.minimize(Objective(5, residuals_at), np.random.default_rng(seed))
    return [len(points) for points in seen if len(points) > 1]


def test_a_generation_is_one_batch_of_the_default_size():
    assert set(sizes(CMAES(restarts="none"), sphere)) == {8}  # 4 + int(3 ln 5)
    assert set(sizes(CMAES(restarts="none", population=20), sphere)) == {20}


def test_no_generation_begins_after_the_evaluations():
    for evaluations in (1, 100, 5000):
        found = CMAES(evaluations=evaluations, restarts="ipop").minimize(Objective(5, sphere), np.random.default_rng(0))
        assert evaluations <= found.evaluations
    assert sum(sizes(CMAES(evaluations=100), sphere)) <= 100 + 8


def test_ipop_doubles_the_population_at_each_restart():
    found = sizes(CMAES(restarts="ipop", max_restarts=2, evaluations=100_000), sphere)
    assert list(dict.fromkeys(found)) == [8, 17, 35]  # of 4 + 3 ln 5 = 8.8
    assert found == sorted(found)


def test_bipop_takes_small_populations_between_large_ones():
    found = list(dict.fromkeys(sizes(CMAES(evaluations=10_000), rastrigin)))
    assert max(found) >= 4 * 8 and found != sorted(found)


def test_without_restarts_it_ends_where_it_has_converged():
    """Linear convergence on a sphere: 1e-11 in the misfit takes about 100 generations of 8 in five dimensions."""
    found = CMAES(restarts="none").minimize(Objective(5, sphere), np.random.default_rng(1))
    assert found.value < 1e-9 and 400 < found.evaluations < 3000
    assert np.allclose(found.u, LOWEST, rtol=0, atol=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_it_follows_the_bent_valley_of_rosenbrock(seed):
    """The valley has a second minimum, at x₁ near −1, that a first start may end in: a restart leaves it."""
    found = CMAES().minimize(Objective(5, rosenbrock), np.random.default_rng(seed))
    assert np.allclose(found.u, 0.75, rtol=0, atol=1e-4)


@pytest.mark.slow
def test_restarts_find_the_lowest_of_many_minima_more_often():
    def found(restarts):
        runs = [
            CMAES(restarts=restarts).minimize(Objective(5, rastrigin), np.random.default_rng(seed)) for seed in range(4)
        ]
        return sum(run.value < 0.5 for run in runs)  # the next best minima have nearly 1

    assert found("ipop") > found("none")


def test_a_missing_library_is_said_in_one_line(monkeypatch):
    monkeypatch.delitem(sys.modules, "optimizers.cmaes")
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *rest: None if name == "cma" else find(name, *rest))
    with pytest.raises(SettingError) as caught:
        create("optimizer", "cmaes", {})
    assert str(caught.value).startswith("optimizer=cmaes: ") and "\n" not in str(caught.value)
    assert "pip install 'ksmea-bench[methods]'" in str(caught.value)
