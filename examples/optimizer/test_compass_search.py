import numpy as np
import pytest
from compass_search import CompassSearch

from ksmea import Objective
from ksmea.testing import check_optimizer

test_exam = check_optimizer.tests(CompassSearch())


def test_the_minimum_of_a_sphere_within_the_last_step():
    found = CompassSearch().minimize(Objective(4, lambda u: u - 0.3), np.random.default_rng(0))
    assert found.u == pytest.approx(
        np.full(4, 0.3), abs=2e-5
    )  # twice the last step: the lattice may lie to either side


def test_the_same_seed_gives_the_same_search():
    one, other = (
        CompassSearch().minimize(Objective(3, lambda u: u**2 - 0.1), np.random.default_rng(5)) for _ in range(2)
    )
    assert np.array_equal(one.u, other.u) and one.evaluations == other.evaluations
