"""Kriging against the paper's equations solved directly, scikit-learn, and its own definitions."""

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF

from ksmea.errors import SettingError
from smooth_samples import fit, latin_hypercube, smooth
from surrogates.correlation import CORRELATIONS, SamplePairs
from surrogates.generalised_least_squares import n_terms
from surrogates.kriging import Kriging


def two_masses(u):
    """Points (n, 5) → ln amplitude of a damped two-mass chain at 53 speeds, channel by channel: (n, 106)."""
    k1, k2, c1, c2, force = (np.array([1, 1, 0.2, 0.2, 0.5]) + u * np.array([1, 1, 0.3, 0.3, 1])).T[:, :, None]
    speed = np.linspace(0.2, 2.6, 53)
    ground, link = k1 + 1j * speed * c1, k2 + 1j * speed * c2
    determinant = (ground + link - speed**2) * (link - speed**2) - link**2
    response = np.stack([force * link / determinant, force * (ground + link - speed**2) / determinant], axis=2)
    return np.log(np.abs(response)).reshape(len(u), -1)


@pytest.fixture(scope="module")
def samples():
    u = latin_hypercube(25, 2, seed=3)
    return u, smooth(u)


@pytest.fixture(scope="module")
def oscillator():
    u = latin_hypercube(60, 5, seed=4)
    return u, two_masses(u)


EVERY_SETTINGS = [
    {"correlation": correlation, "theta_sharing": sharing, "trend": trend}
    for correlation in CORRELATIONS
    for sharing in ("shared", "groups", "per_output")
    for trend in ("constant", "quadratic")
]


def full_polynomial(trend, u):
    """F (n, p) written out for two coordinates."""
    a, b = u.T
    one = np.ones_like(a)
    return np.column_stack(
        {"constant": [one], "linear": [one, a, b], "quadratic": [one, a, b, a * a, a * b, b * b]}[trend]
    )


def solved_directly(predictor, trend, u_new):
    """c of eq. (20) for each new point from the full bordered system, and so ŷ, eq. (12), and s²/σ², eq. (16)."""
    u, y = predictor.samples, predictor.outputs
    n = len(u)
    predicted, variance = [], []
    terms, new_terms = full_polynomial(trend, u), full_polynomial(trend, u_new)
    p = terms.shape[1]
    for group in predictor.groups:
        pairs = SamplePairs.of(np.vstack([u, u_new]))
        upper = pairs.upper(predictor.correlation.among(group.theta, pairs.squared))
        among, r = upper[:n, :n], upper[:n, n:]
        correlation = among + among.T + (1 + group.estimate.nugget) * np.eye(n)
        bordered = np.block([[correlation, terms], [terms.T, np.zeros((p, p))]])
        c = np.linalg.solve(bordered, np.vstack([r, new_terms.T]))[:n]
        solved = np.linalg.solve(correlation, np.hstack([terms, y[:, group.outputs]]))
        beta = np.linalg.solve(terms.T @ solved[:, :p], terms.T @ solved[:, p:])
        departures = y[:, group.outputs] - terms @ beta
        sigma2 = np.einsum("il,il->l", departures, np.linalg.solve(correlation, departures)) / n
        predicted.append(c.T @ y[:, group.outputs])
        factor = 1 + np.einsum("ik,ij,jk->k", c, correlation, c) - 2 * np.einsum("ik,ik->k", c, r)
        variance.append(np.outer(factor, sigma2))
    order = np.argsort(np.concatenate([np.arange(y.shape[1])[group.outputs] for group in predictor.groups]))
    return np.hstack(predicted)[:, order], np.hstack(variance)[:, order]


@pytest.mark.parametrize("correlation", CORRELATIONS)
@pytest.mark.parametrize("sharing", ["shared", "groups", "per_output"])
@pytest.mark.parametrize("trend", ["constant", "linear", "quadratic"])
def test_prediction_and_variance_are_those_of_the_paper(samples, correlation, sharing, trend):
    # θ of 20 keeps cond(R) near 1e4–1e5, so that the direct solution is itself good to 1e-9.
    settings = Kriging(correlation=correlation, theta_sharing=sharing, trend=trend, theta=[20.0, 35.0], nugget=1e-8)
    predictor = fit(settings, *samples)
    u_new = latin_hypercube(15, 2, seed=8)
    predicted, variance = solved_directly(predictor, trend, u_new)
    scale = samples[1].std(axis=0)
    np.testing.assert_allclose(predictor.predict(u_new) / scale, predicted / scale, atol=1e-9)
    np.testing.assert_allclose(predictor.variance(u_new) / scale**2, variance / scale**2, rtol=1e-6, atol=1e-10)


@pytest.mark.parametrize("chosen", EVERY_SETTINGS)
def test_interpolates_its_samples(samples, chosen):
    u, y = samples
    predictor = fit(Kriging(**chosen), u, y)
    # ŷ(u_i) = y_i − nugget γ_i with γᵀRγ = nσ², so that |γ|² ≤ nσ²/nugget; 1 % for rounding.
    bound = 1.01 * np.sqrt(predictor.notes["nugget"] * len(u) * predictor.process_variance)
    assert np.all(np.abs(predictor.predict(u) - y) <= bound)
    assert np.all(bound < 1e-2 * y.std(axis=0))


@pytest.mark.parametrize("correlation", CORRELATIONS)
def test_without_nugget_variance_vanishes_at_samples_and_only_there(samples, correlation):
    u, y = samples
    predictor = fit(Kriging(correlation=correlation, theta=[10.0], nugget=0.0), u, y)
    assert predictor.notes["nugget"] == 0
    # Rounding of 1 − rᵀR⁻¹r is eps times the condition of R, below 1e7 here.
    np.testing.assert_allclose(predictor.variance(u) / predictor.process_variance, 0, atol=1e-8)
    np.testing.assert_allclose(predictor.predict(u) / y.std(axis=0), y / y.std(axis=0), atol=1e-9)
    between = (u[:-1] + u[1:]) / 2
    assert np.all(predictor.variance(between) / predictor.process_variance > 1e-6)


def test_variance_is_clamped_and_grows_outside_the_samples(oscillator):
    u, _ = oscillator
    inside = 0.4 + 0.2 * u
    predictor = fit(Kriging(), inside, two_masses(inside))
    assert np.all(predictor.variance(inside) >= 0)
    assert np.median(predictor.variance(u)) > 100 * np.median(predictor.variance(inside[:-1] / 2 + inside[1:] / 2))


@pytest.mark.parametrize("trend", ["constant", "linear", "quadratic"])
@pytest.mark.parametrize("correlation", CORRELATIONS)
def test_reproduces_polynomials_of_the_trend(trend, correlation):
    u, u_new = latin_hypercube(40, 3, seed=1), latin_hypercube(50, 3, seed=2)

    def polynomial(u):
        a, b, c = u.T
        terms = {"constant": 0 * a, "linear": a - 2 * c, "quadratic": a * b - 3 * c**2 + 0.5 * b}[trend]
        return np.column_stack([2 + terms, 1e6 * (1 - terms)])

    predictor = fit(Kriging(trend=trend, correlation=correlation), u, polynomial(u))
    # Rounding 1e-16 of the outputs, whitened by at most 1/√nugget = 1e5.
    np.testing.assert_allclose(predictor.predict(u_new), polynomial(u_new), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(predictor.leave_one_out(), 0, atol=1e-3)  # of 1e6


@pytest.mark.parametrize("chosen", EVERY_SETTINGS)
def test_append_equals_rebuilding_at_the_same_theta(samples, chosen):
    u, y = samples
    previous = fit(Kriging(**chosen, theta=[6.0, 9.0]), u[:-1], y[:-1])
    appended = previous.append(u[-1], y[-1])
    rebuilt = fit(Kriging(**chosen, theta=[6.0, 9.0]), u, y)
    u_new, scale = latin_hypercube(20, 2, seed=8), y.std(axis=0)
    np.testing.assert_array_equal(appended.theta, rebuilt.theta)
    # cond(R) of up to 1e8 times eps.
    np.testing.assert_allclose(appended.predict(u_new) / scale, rebuilt.predict(u_new) / scale, atol=1e-7)
    np.testing.assert_allclose(
        appended.variance(u_new) / scale**2, rebuilt.variance(u_new) / scale**2, rtol=1e-4, atol=1e-8
    )
    np.testing.assert_allclose(appended.leave_one_out(), rebuilt.leave_one_out(), rtol=1e-4)
    assert len(previous.samples) == len(u) - 1


def test_appending_a_sample_again_changes_nothing(samples):
    predictor = fit(Kriging(), *samples)
    assert predictor.append(samples[0][4], samples[1][4]) is predictor


def test_appending_next_to_a_sample_without_nugget_grows_one(samples):
    u, y = samples
    predictor = fit(Kriging(theta=[10.0], nugget=0.0), u, y)
    near = u[:1] + 1e-10
    appended = predictor.append(near[0], smooth(near)[0])
    assert 0 < appended.notes["nugget"] <= 1e-6
    np.testing.assert_allclose(appended.predict(u) / y.std(axis=0), y / y.std(axis=0), atol=1e-4)


@pytest.mark.parametrize("chosen", EVERY_SETTINGS)
def test_leave_one_out_equals_leaving_out(samples, chosen):
    u, y = samples
    settings = Kriging(**chosen, theta=[6.0, 9.0], nugget=1e-8)
    keep = ~np.eye(len(u), dtype=bool)
    errors = [y[i] - fit(settings, u[keep[i]], y[keep[i]]).predict(u[i : i + 1])[0] for i in range(len(u))]
    expected = np.sqrt(np.mean(np.square(errors), axis=0))
    np.testing.assert_allclose(fit(settings, u, y).leave_one_out(), expected, rtol=1e-6)


def test_leave_one_out_is_infinite_where_a_term_hangs_on_one_sample():
    u = np.vstack([np.column_stack([np.linspace(0, 1, 6), np.full(6, 0.5)]), [[0.5, 1.0]]])
    predictor = fit(Kriging(trend="linear", theta=[2.0]), u, u[:, :1] ** 2)
    assert np.isinf(predictor.leave_one_out()).all()


def test_samples_closing_in_on_a_point_are_fitted_and_the_nugget_recorded():
    u = latin_hypercube(70, 5, seed=5)
    point = np.array([0.4, 0.6, 0.5, 0.3, 0.7])
    closing = point + np.logspace(-1, -8, 30)[:, None] * np.random.default_rng(6).uniform(-1, 1, (30, 5))
    u = np.vstack([u, closing])
    u_new = latin_hypercube(200, 5, seed=7)
    spread = two_masses(u_new).std(axis=0)
    default = fit(Kriging(), u, two_masses(u))
    assert default.notes["nugget"] == 1e-10
    exact = fit(Kriging(theta=list(default.theta[0]), nugget=0.0), u, two_masses(u))
    assert 0 < exact.notes["nugget"] <= 1e-6
    for predictor in (default, exact):
        assert np.isfinite(predictor.variance(u_new)).all() and np.isfinite(predictor.leave_one_out()).all()
        # what 70 samples over the whole cube leave: a few per cent
        assert np.sqrt(np.mean(((predictor.predict(u_new) - two_masses(u_new)) / spread) ** 2)) < 0.1
        np.testing.assert_allclose(predictor.predict(point[None]), two_masses(point[None]), atol=1e-4)


def test_nugget_beyond_the_ladder_says_what_to_do(samples, monkeypatch):
    monkeypatch.setattr("surrogates.generalised_least_squares.NUGGET_LADDER", ())
    u = np.vstack([samples[0], samples[0] + 1e-12])
    with pytest.raises(np.linalg.LinAlgError, match=r"50 samples is not positive definite.*move or drop samples"):
        fit(Kriging(theta=[1e-3], nugget=0.0), u, smooth(u))


def test_repeated_samples_are_left_out_and_counted(samples):
    u, y = samples
    repeated = fit(Kriging(theta=[8.0]), np.vstack([u, u[:3]]), np.vstack([y, y[:3]]))
    assert repeated.notes["repeated_samples"] == 3
    np.testing.assert_array_equal(repeated.samples, u)
    np.testing.assert_array_equal(repeated.predict(u), fit(Kriging(theta=[8.0]), u, y).predict(u))


def test_repeated_samples_with_other_outputs_are_an_error(samples):
    u, y = samples
    with pytest.raises(ValueError, match="repeated samples have different outputs"):
        fit(Kriging(), np.vstack([u, u[:1]]), np.vstack([y, y[:1] + 0.1]))


def test_agrees_with_scikit_learn_at_equal_theta(samples):
    """scikit-learn has no trend: ours with the mean's coefficient taken out is the same predictor."""
    u, y = samples
    y = y - y.mean(axis=0)
    theta, nugget = np.array([12.0, 20.0]), 1e-8
    regressor = GaussianProcessRegressor(RBF(1 / np.sqrt(2 * theta)), alpha=nugget, optimizer=None)
    predictor = fit(Kriging(trend="constant", theta=list(theta), nugget=nugget), u, y)
    constant = predictor.mean + predictor.spread * predictor.groups[0].estimate.coefficients[0]
    u_new = latin_hypercube(40, 2, seed=9)
    # y − constant has no mean to estimate: simple Kriging of it is what scikit-learn does.
    expected = constant + regressor.fit(u, y - constant).predict(u_new)
    np.testing.assert_allclose(predictor.predict(u_new), expected, atol=1e-6 * np.abs(y).max())


def test_is_no_worse_than_scikit_learn_on_held_out_points(oscillator):
    u, y = oscillator
    u_new = latin_hypercube(300, 5, seed=11)
    regressor = GaussianProcessRegressor(RBF(np.full(5, 0.5), (0.02, 20)), normalize_y=True).fit(u, y)

    def error(predict):
        return np.sqrt(np.mean((predict(u_new) - two_masses(u_new)) ** 2))

    # Like for like: no trend but the mean there, and an objective that weighs outputs by their residuals.
    assert error(fit(Kriging(trend="constant", objective="dace"), u, y).predict) < error(regressor.predict)


def test_refit_from_its_own_theta_finds_the_same_model(oscillator):
    u, y = oscillator
    settings = Kriging()
    before = fit(settings, u[:-1], y[:-1])
    cold = fit(settings, u, y)
    warm = settings.refit(before, u, y, np.random.default_rng(0))
    u_new = latin_hypercube(100, 5, seed=12)
    np.testing.assert_allclose(warm.predict(u_new), cold.predict(u_new), atol=0.01 * y.std())


@pytest.mark.parametrize("sharing, n_group", [("shared", 1), ("groups", 2), ("per_output", 3)])
def test_outputs_share_theta_as_told(samples, sharing, n_group):
    assert fit(Kriging(theta_sharing=sharing), *samples).theta.shape == (n_group, 2)


def test_groups_are_channels(samples):
    """Outputs (n_speed, n_channel) in C order: every second one is one channel, and is fitted as if it were alone."""
    u, y = samples
    y = np.column_stack([y[:, 0], y[:, 2], 2 * y[:, 0], 1 - y[:, 2]])
    predictor = fit(Kriging(theta_sharing="groups"), u, y)
    alone = fit(Kriging(), u, y[:, 1::2])
    np.testing.assert_array_equal(predictor.theta[1], alone.theta[0])
    np.testing.assert_allclose(predictor.predict(u[:4] + 0.01)[:, 1::2], alone.predict(u[:4] + 0.01), rtol=1e-12)
    assert fit(Kriging(theta_sharing="groups", groups=4), u, y).theta.shape == (4, 2)


def test_same_seed_same_model(samples):
    settings = Kriging(restarts=2)
    first, second = (fit(settings, *samples, seed=5) for _ in range(2))
    np.testing.assert_array_equal(first.theta, second.theta)
    np.testing.assert_array_equal(first.predict(samples[0] / 2), second.predict(samples[0] / 2))


def test_predicts_in_chunks_as_it_does_at_once(samples, monkeypatch):
    predictor = fit(Kriging(theta_sharing="groups"), *samples)
    u = latin_hypercube(50, 2, seed=14)
    predicted, variance = predictor.predict(u), predictor.variance(u)
    monkeypatch.setattr("surrogates.kriging_predictor.CHUNK", 7)
    # The order of the sums differs with the shape of the matrix product: rounding, times large weights of both signs.
    # A variance is what 1 − rᵀR⁻¹r leaves of σ²: with a nugget of 1e-10 rounding reaches 1e-16 / 1e-10 of the largest.
    np.testing.assert_allclose(predictor.predict(u), predicted, rtol=1e-9)
    np.testing.assert_allclose(predictor.variance(u), variance, rtol=1e-6, atol=1e-6 * variance.max())


def test_constant_outputs_are_predicted():
    u = latin_hypercube(30, 2, seed=1)
    y = np.column_stack([np.zeros(30), np.full(30, 7.0), smooth(u)])
    predictor = fit(Kriging(theta_sharing="per_output"), u, y)
    np.testing.assert_allclose(predictor.predict(u / 2)[:, :2], np.broadcast_to([0.0, 7.0], (30, 2)), atol=1e-12)


@pytest.mark.parametrize("trend", ["constant", "linear", "quadratic"])
def test_least_samples_are_enough_and_one_fewer_is_not(trend):
    settings = Kriging(trend=trend)
    n = settings.least_samples(3)
    assert n == n_terms(trend, 3) + 1
    u = latin_hypercube(n, 3, seed=1)
    y = np.sin(u.sum(axis=1, keepdims=True))
    assert np.isfinite(fit(settings, u, y).predict(u)).all()
    with pytest.raises(SettingError, match=rf"{trend} trend in 3 parameters has {n - 1} terms .* got {n - 1}: .*try"):
        fit(settings, u[1:], y[1:])


def test_samples_that_cannot_tell_the_trend_are_an_error():
    u = np.column_stack([np.linspace(0, 1, 20), np.full(20, 0.5)])
    with pytest.raises(SettingError, match="quadratic trend has 6 terms and the 20 samples determine 3"):
        fit(Kriging(trend="quadratic"), u, u[:, :1])


@pytest.mark.parametrize(
    "wrong, said",
    [
        ({"trend": "cubic"}, "trend"),
        ({"correlation": "gausian"}, "did you mean 'gaussian'"),
        ({"nugget": -1e-9}, "nugget"),
        ({"theta": [1.0, 0.0]}, "theta"),
        ({"theta_lower": 10.0, "theta_upper": 1.0}, "swap them"),
    ],
)
def test_wrong_settings_are_errors(wrong, said):
    with pytest.raises(SettingError, match=said):
        Kriging(**wrong)


def test_theta_of_wrong_length_is_an_error(samples):
    with pytest.raises(SettingError, match="expected 1 or 2 values for 2 parameters, got 3"):
        fit(Kriging(theta=[1.0, 2.0, 3.0]), *samples)


def test_samples_without_values_are_an_error(samples):
    u, y = samples
    with pytest.raises(ValueError, match="finite"):
        fit(Kriging(), u, np.where(y > y.max() - 1e-9, np.nan, y))
