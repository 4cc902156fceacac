"""Correlation functions against their formulas, and the fast matrix between points against the one among samples."""

import numpy as np
import pytest

from surrogates.correlation import CORRELATIONS, squared_differences

THETA = np.array([0.3, 40.0])


def one_pair(name, h):
    if name == "gaussian":
        return np.exp(-np.sum(THETA * h**2))
    a = np.sqrt(5 * THETA) * np.abs(h)
    return np.prod((1 + a + a**2 / 3) * np.exp(-a))


@pytest.mark.parametrize("name", CORRELATIONS)
def test_matrix_among_samples_is_the_formula(name):
    u = np.random.default_rng(1).random((6, 2))
    expected = [[one_pair(name, a - b) for b in u] for a in u]
    np.testing.assert_allclose(CORRELATIONS[name].among(THETA, squared_differences(u)), expected, rtol=1e-13)


@pytest.mark.parametrize("name", CORRELATIONS)
def test_rows_between_points_and_samples_are_those_of_the_matrix(name):
    u = np.random.default_rng(1).random((9, 2))
    among = CORRELATIONS[name].among(THETA, squared_differences(u))
    # differences by a matrix product lose eps·θ
    np.testing.assert_allclose(CORRELATIONS[name].between(THETA, u[:3], u[3:]), among[:3, 3:], rtol=0, atol=40 * 4e-16)
    np.testing.assert_array_equal(
        CORRELATIONS[name].rows(THETA, u[3:])(u[:3]), CORRELATIONS[name].between(THETA, u[:3], u[3:])
    )


@pytest.mark.parametrize("name", CORRELATIONS)
def test_is_one_at_distance_zero_and_positive_definite(name):
    u = np.random.default_rng(1).random((20, 2))
    matrix = CORRELATIONS[name].among(np.array([20.0, 20.0]), squared_differences(u))
    np.testing.assert_array_equal(np.diagonal(matrix), 1.0)
    assert np.linalg.eigvalsh(matrix).min() > 0
