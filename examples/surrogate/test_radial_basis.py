import numpy as np
import pytest
from radial_basis import RadialBasis

from ksmea.testing import check_surrogate

RNG = np.random.default_rng(0)
U = RNG.random((20, 2))

test_exam = check_surrogate.tests(RadialBasis())


def test_it_goes_through_its_samples():
    y = np.column_stack([np.sin(3 * U[:, 0]), U[:, 1] ** 2])
    assert RadialBasis().fit(U, y, RNG).predict(U) == pytest.approx(y, abs=1e-9)  # rounding of a system of 23 equations


def test_what_is_linear_is_exact_everywhere():
    fitted = RadialBasis().fit(U, U @ [[2.0], [-1.0]] + 3.0, RNG)
    others = RNG.random((5, 2))
    assert fitted.predict(others) == pytest.approx(others @ [[2.0], [-1.0]] + 3.0)
