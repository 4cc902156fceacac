"""Slopes of the θ objectives against differences of their values, and the search that uses them."""

import numpy as np
import pytest
from scipy.stats import qmc

from surrogates.correlation import CORRELATIONS, SamplePairs
from surrogates.generalised_least_squares import trend_over
from surrogates.theta_search import OBJECTIVES, VARIANCE_FLOOR, ThetaObjective, isotropic_minima, search_theta


def make_objective(name="likelihood", correlation="gaussian", outputs=slice(None), trend="linear", nugget=1e-6):
    u = qmc.LatinHypercube(3, rng=np.random.default_rng(2)).random(30)
    y = np.column_stack([np.sin(4 * u[:, 0]) * u[:, 1], np.exp(u @ [1, -2, 0.5]), np.cos(6 * u[:, 2]) + u[:, 0]])
    y = (y - y.mean(axis=0)) / y.std(axis=0)
    return ThetaObjective(
        name, CORRELATIONS[correlation], SamplePairs.of(u), trend_over(trend, u).terms(u), y[:, outputs], nugget
    )


def differences(objective, at, step=1e-2):
    """Sixth-order central differences of the value: truncation of order step⁶, rounding of order 1e-13/step."""
    slope = []
    for direction in np.eye(len(at)) * step:
        values = [objective.value(at + k * direction) for k in (1, 2, 3, -1, -2, -3)]
        slope.append(np.dot([45, -9, 1, -45, 9, -1], values) / (60 * step))
    return np.array(slope)


@pytest.mark.parametrize("name", OBJECTIVES)
@pytest.mark.parametrize("correlation", CORRELATIONS)
@pytest.mark.parametrize(
    "outputs", [slice(None), slice(0, None, 2), slice(1, 2)], ids=["shared", "group", "one output"]
)
@pytest.mark.parametrize("theta", [[1.0, 1.0, 1.0], [0.2, 30.0, 4.0]])
def test_slope_is_the_derivative_of_the_value(name, correlation, outputs, theta):
    objective = make_objective(name, correlation, outputs)
    value, slope = objective.value_and_slope(np.log(theta))
    assert value == objective.value(np.log(theta))
    np.testing.assert_allclose(slope, differences(objective, np.log(theta)), rtol=1e-6, atol=1e-8)


def test_objectives_are_as_published():
    """From eq. by eq. with inverses: σ_l² = (Y − Fβ)ᵀR⁻¹(Y − Fβ)/n; DACE's Σσ²|R|^(1/n); the mean of ln σ² with ln|R|/n."""
    theta = np.array([2.0, 9.0, 4.0])
    objective = make_objective()
    n = len(objective.outputs)
    upper = objective.pairs.upper(objective.correlation.among(theta, objective.pairs.squared))
    correlation = upper + upper.T + (1 + objective.nugget) * np.eye(n)
    inverse = np.linalg.inv(correlation)
    f, y = objective.terms, objective.outputs
    residual = y - f @ np.linalg.solve(f.T @ inverse @ f, f.T @ inverse @ y)
    sigma2 = np.einsum("il,ij,jl->l", residual, inverse, residual) / n
    determinant = np.linalg.slogdet(correlation)[1]
    assert objective.value(np.log(theta)) == pytest.approx(np.mean(np.log(sigma2)) + determinant / n, rel=1e-8)
    dace = make_objective("dace").value(np.log(theta))
    assert np.exp(dace) == pytest.approx(np.sum(sigma2) * np.exp(determinant / n), rel=1e-8)


@pytest.mark.parametrize("name", OBJECTIVES)
def test_search_ends_where_the_slope_is_zero_or_against_a_bound(name):
    lower, upper = 1e-3, 1e3
    objective = make_objective(name)
    theta = search_theta(objective, isotropic_minima(objective, lower, upper, 7), lower, upper)
    value, slope = objective.value_and_slope(np.log(theta))
    free = (theta > lower * 1.0001) & (theta < upper / 1.0001)
    assert np.all(np.abs(slope[free]) < 5e-3)
    assert np.all(slope[theta <= lower * 1.0001] >= 0) and np.all(slope[theta >= upper / 1.0001] <= 0)
    ladder = [objective.value(np.full(3, log_theta)) for log_theta in np.linspace(np.log(lower), np.log(upper), 7)]
    assert value <= min(ladder)


def test_ladder_gives_every_local_minimum():
    class Wave:
        pairs = SamplePairs.of(np.zeros((2, 2)))

        def value(self, log_theta):
            return [3.0, 1.0, 2.0, 0.5, 4.0][round(log_theta[0] / np.log(10))]

    np.testing.assert_allclose(isotropic_minima(Wave(), 1.0, 1e4, 5), [[10.0, 10.0], [1000.0, 1000.0]])


def test_output_that_the_trend_reproduces_leaves_theta_to_the_others():
    """Its σ² is rounding, whose logarithm would otherwise swamp the mean."""
    objective = make_objective()
    with_trivial = ThetaObjective(
        "likelihood",
        objective.correlation,
        objective.pairs,
        objective.terms,
        np.column_stack([objective.outputs, objective.terms @ [0.0, 1.0, -1.0, 0.5]]),
        objective.nugget,
    )
    alone, together = objective.estimate(np.ones(3)), with_trivial.estimate(np.ones(3))
    assert together.process_variance[-1] < 1e-20  # rounding of 1e-16, whitened by at most 1/√nugget = 1e3, squared
    constant = np.log(VARIANCE_FLOOR) / 4
    log_determinant = alone.log_determinant / len(objective.outputs)
    expected = 0.75 * (objective.value(np.zeros(3)) - log_determinant) + constant + log_determinant
    assert with_trivial.value(np.zeros(3)) == pytest.approx(expected, abs=1e-3)
