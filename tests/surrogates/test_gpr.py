"""Gaussian-process regression: our own Kriging and it predict alike where they are the same model."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from smooth_samples import fit, latin_hypercube, smooth
from surrogates.gpr import GPR
from surrogates.kriging import Kriging

THETA, NUGGET = [12.0, 20.0], 1e-8


@pytest.fixture(scope="module")
def samples():
    u = latin_hypercube(25, 2, seed=3)
    return u, smooth(u)


@pytest.fixture(scope="module")
def unseen():
    return latin_hypercube(40, 2, seed=9)


def correlations(u, v):
    return np.exp(-np.sum(THETA * (u[:, None] - v[None]) ** 2, axis=2))


def test_it_predicts_what_kriging_does_but_for_the_mean(samples, unseen):
    """At equal θ and nugget ŷ = μ + rᵀR⁻¹(y − μ), with μ the generalised mean β in Kriging and the samples' mean here: they
    differ by (β − μ)(1 − rᵀR⁻¹1). What rounding leaves is of the order of the condition number, below 1/nugget = 1e8,
    times 2e-16."""
    u, y = samples
    ours = fit(Kriging(trend="constant", theta=THETA, nugget=NUGGET), u, y)
    theirs = fit(GPR(theta=THETA, nugget=NUGGET), u, y)
    among = correlations(u, u) + NUGGET * np.eye(len(u))
    inverse_one = np.linalg.solve(among, np.ones(len(u)))
    beta = inverse_one @ y / np.sum(inverse_one)
    rest = 1 - correlations(unseen, u) @ inverse_one
    difference = np.outer(rest, beta - y.mean(axis=0))
    assert np.max(np.abs(difference) / y.std(axis=0)) > 1e-3  # there is something to account for
    np.testing.assert_allclose(
        (ours.predict(unseen) - theirs.predict(unseen)) / y.std(axis=0), difference / y.std(axis=0), rtol=0, atol=1e-7
    )


def test_its_variance_is_that_of_kriging_but_for_the_mean(samples, unseen):
    """s²/σ² = 1 − rᵀR⁻¹r, to which Kriging adds (1 − rᵀR⁻¹1)²/1ᵀR⁻¹1 for a mean that is estimated, eq. (16); both differ
    in σ² alone otherwise. 1 − rᵀR⁻¹r is lost to rounding below 1e-7, as above."""
    u, y = samples
    ours = fit(Kriging(trend="constant", theta=THETA, nugget=NUGGET), u, y)
    theirs = fit(GPR(theta=THETA, nugget=NUGGET), u, y)
    among = correlations(u, u) + NUGGET * np.eye(len(u))
    inverse_one = np.linalg.solve(among, np.ones(len(u)))
    of_the_mean = (1 - correlations(unseen, u) @ inverse_one) ** 2 / np.sum(inverse_one)
    np.testing.assert_allclose(
        ours.variance(unseen) / ours.process_variance - of_the_mean[:, None],
        theirs.variance(unseen) / y.std(axis=0) ** 2,
        rtol=0,
        atol=1e-7,
    )


@pytest.mark.parametrize("kernel", ["gaussian", "matern52"])
def test_it_interpolates_and_its_variance_vanishes_at_samples(samples, kernel):
    u, y = samples
    predictor = fit(GPR(kernel=kernel), u, y)
    np.testing.assert_allclose(predictor.predict(u), y, rtol=0, atol=1e-4 * y.std(axis=0).max())
    assert np.all(predictor.variance(u) < 1e-5 * y.var(axis=0))
    assert np.all(predictor.variance(np.array([[-2.0, 3.0]])) > 0.1 * y.var(axis=0))


def test_its_variance_tells_its_error(samples, unseen):
    """Errors of a smooth function in units of their predicted standard deviation: some 1, never 10."""
    predictor = fit(GPR(), *samples)
    z = (predictor.predict(unseen) - smooth(unseen)) / np.sqrt(predictor.variance(unseen))
    assert np.max(np.abs(z)) < 10 and np.sqrt(np.mean(z**2)) > 0.05


def test_leave_one_out_equals_leaving_out():
    """Kernel and mean fixed: of outputs whose mean and spread stay as they are without any one of them, nearly so in a sample of
    40; the nugget's share of the kernel changes with the spread by as little."""
    u = latin_hypercube(40, 2, seed=5)
    y = smooth(u)
    settings = GPR(theta=THETA)
    keep = ~np.eye(len(u), dtype=bool)
    errors = [y[i] - fit(settings, u[keep[i]], y[keep[i]]).predict(u[i : i + 1])[0] for i in range(len(u))]
    expected = np.sqrt(np.mean(np.square(errors), axis=0))
    np.testing.assert_allclose(fit(settings, u, y).leave_one_out(), expected, rtol=0.05)


def test_the_order_of_samples_and_the_seed_change_no_prediction(samples, unseen):
    u, y = samples
    turned = np.arange(len(u))[::-1]
    first = fit(GPR(theta=THETA), u, y).predict(unseen)
    np.testing.assert_allclose(fit(GPR(theta=THETA), u[turned], y[turned]).predict(unseen), first, atol=1e-5)
    again = [fit(GPR(), u, y, seed=4).predict(unseen) for _ in range(2)]
    np.testing.assert_array_equal(*again)


def test_a_refit_finds_a_kernel_as_likely(samples):
    u, y = samples
    settings = GPR()
    cold = fit(settings, u, y)
    warm = settings.refit(fit(settings, u[:-1], y[:-1]), u, y, np.random.default_rng(0))
    likelihood = [each.regressor.log_marginal_likelihood_value_ for each in (cold, warm)]
    assert likelihood[1] > likelihood[0] - 0.1


def test_one_output_has_the_shapes_of_many(samples, unseen):
    u, y = samples
    predictor = fit(GPR(theta=THETA), u, y[:, :1])
    assert predictor.predict(unseen).shape == predictor.variance(unseen).shape == (len(unseen), 1)
    assert predictor.leave_one_out().shape == (1,)


def test_what_cannot_be_is_refused(samples):
    with pytest.raises(SettingError, match="theta: expected 1 or 2 values for 2 parameters, got 3"):
        fit(GPR(theta=[1.0, 2.0, 3.0]), *samples)
    with pytest.raises(SettingError, match="expected lower < upper"):
        GPR(theta_lower=2.0, theta_upper=1.0)
    u = np.repeat(samples[0][:3], 2, axis=0)
    with pytest.raises(np.linalg.LinAlgError, match=r"raise surrogate\.nugget"):
        fit(GPR(theta=[1.0], nugget=1e-17), u, smooth(u))
