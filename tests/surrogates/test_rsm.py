"""The response surface reproduces polynomials of its degree, and its leave-one-out errors are those of leaving out."""

from math import comb

import numpy as np
import pytest

from ksmea.errors import SettingError
from surrogates.rsm import ResponseSurface


def points(n, d=3, seed=0):
    return np.random.default_rng(seed).random((n, d))


def fit(settings, u, y):
    return settings.fit(u, y, np.random.default_rng(0))


def polynomial(degree, u):
    a, b, c = u.T
    terms = [1 + a - 2 * c, a * b - 3 * c**2, a * b * c + b**3]
    return np.column_stack([sum(terms[:degree]), 1e3 * sum(terms[:degree]) - 5])


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_reproduces_polynomials_of_its_degree(degree):
    u, u_new = points(40), points(30, seed=1)
    predictor = fit(ResponseSurface(degree=degree), u, polynomial(degree, u))
    np.testing.assert_allclose(predictor.predict(u_new), polynomial(degree, u_new), rtol=1e-9)
    np.testing.assert_allclose(predictor.leave_one_out(), 0, atol=1e-8)


def test_a_lower_degree_does_not():
    u = points(40)
    predictor = fit(ResponseSurface(degree=2), u, polynomial(3, u))
    assert np.all(predictor.leave_one_out() > 1e-3)


@pytest.mark.parametrize("degree", [1, 2])
def test_leave_one_out_equals_leaving_out(degree):
    u = points(25)
    y = np.sin(5 * u) @ [[1.0, 0.0], [0.5, 2.0], [0.0, 1.0]]
    settings = ResponseSurface(degree=degree)
    keep = ~np.eye(len(u), dtype=bool)
    errors = [y[i] - fit(settings, u[keep[i]], y[keep[i]]).predict(u[i : i + 1])[0] for i in range(len(u))]
    np.testing.assert_allclose(
        fit(settings, u, y).leave_one_out(), np.sqrt(np.mean(np.square(errors), axis=0)), rtol=1e-9
    )


def test_append_equals_a_new_fit():
    u = points(25)
    y = np.sin(5 * u)
    appended = fit(ResponseSurface(), u[:-1], y[:-1]).append(u[-1], y[-1])
    np.testing.assert_array_equal(appended.predict(u), fit(ResponseSurface(), u, y).predict(u))


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_least_samples_are_enough_and_one_fewer_is_not(degree):
    settings = ResponseSurface(degree=degree)
    n = settings.least_samples(3)
    assert n == comb(3 + degree, 3) + 1
    u = points(n)
    assert np.isfinite(fit(settings, u, u).leave_one_out()).all()
    with pytest.raises(
        SettingError, match=rf"degree {degree} in 3 parameters .* needs {n} samples, got {n - 1}: .*try"
    ):
        fit(settings, u[1:], u[1:])


@pytest.mark.parametrize("degree", [0, 4])
def test_degree_beyond_its_range_is_an_error(degree):
    with pytest.raises(SettingError, match="degree"):
        ResponseSurface(degree=degree)
