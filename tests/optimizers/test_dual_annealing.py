"""Dual annealing: the count, the local search, and the lowest of many minima."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.numerics.objective import Objective
from landscapes import noted, rastrigin, sphere
from optimizers.dual_annealing import DualAnnealing
from tiers import mostly_slow


def test_without_local_searches_the_evaluations_are_used_exactly():
    residuals_at, seen = noted(sphere)
    DualAnnealing(evaluations=500, local_search=False).minimize(Objective(5, residuals_at), np.random.default_rng(0))
    assert [len(points) for points in seen] == [1] * 500


def test_local_searches_sharpen_what_annealing_finds():
    values = {
        local: DualAnnealing(evaluations=2000, local_search=local)
        .minimize(Objective(5, sphere), np.random.default_rng(0))
        .value
        for local in (False, True)
    }
    assert values[True] < 1e-12 < values[False]  # difference quotients find the lowest point to 1e-8


@pytest.mark.parametrize("seed", mostly_slow(range(3), but=[0]))
def test_it_finds_the_lowest_of_many_minima(seed):
    found = DualAnnealing().minimize(Objective(5, rastrigin), np.random.default_rng(seed))
    assert found.value < 0.5  # the next best of 8⁵ have nearly 1


def test_settings_that_scipy_would_refuse_later_are_refused():
    for setting in ({"visit": 1.0}, {"restart_temp_ratio": 1.0}):
        with pytest.raises(SettingError, match=next(iter(setting))):
            DualAnnealing(**setting)
