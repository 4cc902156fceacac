"""Kriging against published numbers: the examples of DiceKriging."""

import numpy as np

from surrogates.kriging import Kriging


def fit(settings, u, y):
    return settings.fit(u, y, np.random.default_rng(0))


def branin(u):
    """With 5/(4π²), as DiceKriging writes it, not the usual 5.1/(4π²)."""
    a, b = 15 * u[:, :1] - 5, 15 * u[:, 1:]
    return (b - 5 / (4 * np.pi**2) * a**2 + 5 / np.pi * a - 6) ** 2 + 10 * (1 - 1 / (8 * np.pi)) * np.cos(a) + 10


BRANIN_GRID = np.array([(a, b) for b in np.linspace(0, 1, 4) for a in np.linspace(0, 1, 4)])


def test_dicekriging_branin():
    """DiceKriging tests/testthat/test-km.R, model 1: β = 306.5783, σ² = 145556.6 at lengths 0.8254355 and 2.

    All digits printed hold, with σ² divided by n. R's nugget is zero there.
    """
    settings = Kriging(
        trend="constant", correlation="matern52", theta=[0.8254355**-2, 2.0**-2], nugget=0.0, transform="none"
    )
    predictor = fit(settings, BRANIN_GRID, branin(BRANIN_GRID))
    mean = predictor.mean + predictor.spread * predictor.groups[0].estimate.coefficients[0]
    np.testing.assert_allclose(mean, 306.5783, atol=6e-5)
    np.testing.assert_allclose(predictor.process_variance, 145556.6, atol=0.06)


def test_dicekriging_branin_range_is_found():
    """Estimated lengths of the model, 0.8254355 and 2.

    The latter is DiceKriging's upper bound, 2 × the range of the inputs.
    """
    settings = Kriging(trend="constant", correlation="matern52", theta_lower=0.25, nugget=0.0)
    theta = fit(settings, BRANIN_GRID, branin(BRANIN_GRID)).theta[0]
    # DiceKriging's own test allows 1e-4; our search stops a little earlier on a flat minimum.
    np.testing.assert_allclose(theta**-0.5, [0.8254355, 2.0], rtol=2e-3)


def test_dicekriging_sine_with_nugget():
    """DiceKriging tests/testthat/test-km.R, sin(x) at 0, 2 … 10: Gaussian exp(−h²/(2ℓ²)), ℓ = 2.417813, σ² = 3.35796,
    nugget 1e-3 in absolute units, β = −0.5586176; predictions at x = 10 k/99, their mean and standard deviation.

    Its variance is of an observation, nugget included, and corrected for bias (n/(n − 1)): ours is of the process,
    as in eq. (16). ℓ and σ² are printed to 6–7 digits, which leaves 1e-6 of the predictions.
    """
    x = np.linspace(0, 10, 6)[:, None]
    length, sigma2 = 2.417813, 3.35796
    settings = Kriging(trend="constant", theta=[100 / (2 * length**2)], nugget=1e-3 / sigma2)
    predictor = fit(settings, x / 10, np.sin(x))
    mean = predictor.mean + predictor.spread * predictor.groups[0].estimate.coefficients[0]
    np.testing.assert_allclose(mean, -0.5586176, atol=2e-6)
    at = np.array([1, 2, 3, 50, 98])[:, None] / 99
    expected = [0.103668583556765, 0.204106764415468, 0.301735270357276, -0.941578251818738, -0.439544244726991]
    np.testing.assert_allclose(predictor.predict(at)[:, 0], expected, atol=2e-6)
    process = predictor.variance(at[:3])[:, 0] / predictor.process_variance * sigma2
    deviation = np.sqrt((process + 1e-3) * 6 / 5)
    np.testing.assert_allclose(deviation, [0.055938047354605, 0.0717239075944272, 0.0885333491721034], rtol=1e-5)
