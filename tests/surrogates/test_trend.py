"""Polynomial terms: their number, their span and when samples determine them."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from surrogates.generalised_least_squares import n_terms, trend_over


def test_quadratic_terms_in_order():
    trend = trend_over("quadratic", np.array([[-1, -1], [1, -1], [-1, 1], [1, 1], [0, 0], [0.5, 0]]))
    np.testing.assert_allclose(trend.terms(np.array([[0.5, -2.0]])), [[1, 0.5, -2.0, 0.25, -1.0, 4.0]])


@pytest.mark.parametrize("name, degree", [("constant", 0), ("linear", 1), ("quadratic", 2)])
def test_terms_span_the_full_polynomials(name, degree):
    u = 0.3 + 0.01 * np.random.default_rng(1).random((60, 4))  # a small part of the cube
    trend = trend_over(name, u)
    monomials = np.column_stack([np.ones(60)] + ([u] if degree else []) + [u[:, [0]] * u[:, [3]]] * (degree == 2))
    fitted = trend.terms(u) @ np.linalg.lstsq(trend.terms(u), monomials)[0]
    assert trend.terms(u).shape == (60, n_terms(name, 4))
    np.testing.assert_allclose(fitted, monomials, rtol=1e-12)
    assert np.linalg.cond(trend.terms(u)) < 30  # raw monomials there: 1e7


def test_samples_in_a_plane_do_not_determine_a_linear_trend():
    u = np.random.default_rng(1).random((20, 3))
    u[:, 2] = u[:, 0] - u[:, 1]
    with pytest.raises(SettingError, match="linear trend has 4 terms and the 20 samples determine 3"):
        trend_over("linear", u)
