"""SMC and SDF, eqs. (23) and (24), by hand."""

import numpy as np
import pytest

from ksmea.identification.updating import simple_difference, squared_multiple_correlation

MEASURED = np.array([[1.0, 2.0], [3.0, 4.0]])
MODELLED = MEASURED + np.array([[1.0, 0.0], [0.0, -2.0]])  # squared residuals 1 + 4
PREDICTED = MODELLED + np.array([[0.1, 0.0], [-0.2, 0.0]])  # squared differences 0.01 + 0.04, absolute ones 0.1 + 0.2


def test_smc_compares_the_surrogates_error_with_the_residual():
    assert squared_multiple_correlation(PREDICTED, MODELLED, MEASURED) == pytest.approx(1 - 0.05 / 5, rel=1e-14)


def test_sdf_is_the_sum_of_differences():
    assert simple_difference(PREDICTED, MODELLED) == pytest.approx(0.3, rel=1e-14)


def test_complex_data_are_compared_by_magnitude_whatever_their_phase():
    turn = np.exp(1j * np.array([[0.3, 2.0], [-1.0, 3.0]]))
    found = squared_multiple_correlation(PREDICTED * turn, MODELLED * turn, MEASURED * turn)
    assert found == pytest.approx(0.99, rel=1e-13)
    assert simple_difference(PREDICTED * turn, MODELLED * turn) == pytest.approx(0.3, rel=1e-13)
    assert simple_difference(np.array([3.0 + 4.0j]), np.array([0.0j])) == 5.0


def test_a_perfect_surrogate_of_a_wrong_model_stops_by_smc():
    assert squared_multiple_correlation(MODELLED, MODELLED, MEASURED) == 1.0
    assert simple_difference(MODELLED, MODELLED) == 0.0


@pytest.mark.parametrize("predicted", [PREDICTED, MEASURED])
def test_at_a_perfect_model_smc_says_nothing(predicted):
    """Also where the surrogate is perfect too: 0/0 must not stop a run that SDF is there to stop."""
    with np.errstate(all="raise"):
        assert squared_multiple_correlation(predicted, MEASURED, MEASURED) == -np.inf


def test_smc_is_no_measure_of_fit():
    """A wrong model with an accurate surrogate scores higher than a good model with a fair one."""
    far, near = MEASURED + 1.0, MEASURED + 0.01
    assert squared_multiple_correlation(far + 0.01, far, MEASURED) > 0.999
    assert squared_multiple_correlation(near + 0.005, near, MEASURED) == pytest.approx(0.75)
