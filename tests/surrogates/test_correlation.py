"""Correlation functions against their formulas, and the fast matrix between points against the one among samples."""

import numpy as np
import pytest

from surrogates.correlation import CORRELATIONS, SamplePairs

THETA = np.array([0.3, 40.0])


def among(name, theta, u):
    """The whole matrix of samples."""
    pairs = SamplePairs.of(u)
    upper = pairs.upper(CORRELATIONS[name].among(theta, pairs.squared))
    return upper + upper.T + np.eye(len(u))


def one_pair(name, h):
    if name == "gaussian":
        return np.exp(-np.sum(THETA * h**2))
    a = np.sqrt(5 * THETA) * np.abs(h)
    return np.prod((1 + a + a**2 / 3) * np.exp(-a))


@pytest.mark.parametrize("name", CORRELATIONS)
def test_matrix_among_samples_is_the_formula(name):
    u = np.random.default_rng(1).random((6, 2))
    expected = [[one_pair(name, a - b) for b in u] for a in u]
    np.testing.assert_allclose(among(name, THETA, u), expected, rtol=1e-13)


@pytest.mark.parametrize("name", CORRELATIONS)
def test_rows_between_points_and_samples_are_those_of_the_matrix(name):
    u = np.random.default_rng(1).random((9, 2))
    whole = among(name, THETA, u)
    # differences by a matrix product lose eps·θ
    np.testing.assert_allclose(CORRELATIONS[name].between(THETA, u[:3], u[3:]), whole[:3, 3:], rtol=0, atol=40 * 4e-16)
    np.testing.assert_array_equal(
        CORRELATIONS[name].rows(THETA, u[3:])(u[:3]), CORRELATIONS[name].between(THETA, u[:3], u[3:])
    )


@pytest.mark.parametrize("name", CORRELATIONS)
def test_is_one_at_distance_zero_and_positive_definite(name):
    u, theta = np.random.default_rng(1).random((20, 2)), np.array([20.0, 20.0])
    np.testing.assert_array_equal(CORRELATIONS[name].among(theta, np.zeros((2, 1))), 1.0)
    assert np.linalg.eigvalsh(among(name, theta, u)).min() > 0


def test_values_of_pairs_are_read_where_they_were_put():
    pairs = SamplePairs.of(np.random.default_rng(1).random((7, 2)))
    values = np.arange(1.0, 22.0)
    upper = pairs.upper(values)
    np.testing.assert_array_equal(upper, np.triu(upper, k=1))
    np.testing.assert_array_equal(upper[0], [0, 1, 2, 3, 4, 5, 6])
    np.testing.assert_array_equal(pairs.values(upper), values)
