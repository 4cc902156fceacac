"""The lack-of-fit test: right as often as it says, and it finds and locates what is wrong."""

import numpy as np
import pytest
from scipy import stats

from ksmea.fits.fitting import Fit
from ksmea.fits.lack_of_fit import fit_quality, residual_statistics, whirl_parts
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.problem.counted import Model
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem

SPEED = np.linspace(100.0, 200.0, 48)
CHANNELS = (Channel(0.1, "x"), Channel(0.1, "y"))


class Lines(Problem):
    """A straight line over speed per channel: four unknowns."""

    speed, channels = SPEED, CHANNELS
    parameters = Parameters(tuple(Parameter(f"p{index}", "", 1.0, -100.0, 100.0) for index in range(4)))

    def response(self, x):
        slope = (SPEED - 150) / 50
        return np.stack([x[:, :1] + x[:, 1:2] * slope, x[:, 2:3] + x[:, 3:] * slope], axis=-1).astype(complex)


TRUTH = np.array([10.0, 3.0, -8.0, 2.0])


def fitted(values, noise):
    likelihood = Likelihood(Model(Lines()), Measurement(SPEED, CHANNELS, values, noise, "test"))
    start = likelihood.start(Lines.parameters.to_cube(TRUTH))
    return Fit(likelihood, maximise(likelihood, start))


UNIT = Noise(0.0, 1.0)


def clean(seed, noise=UNIT):
    return observe(Lines().response(TRUTH[None])[0], "complex", noise, np.random.default_rng(seed))


@pytest.mark.parametrize("told", [True, False])
def test_a_right_model_is_rejected_as_often_as_the_test_says(told):
    noise = Noise(0.0, 1.0)
    p = [
        fit_quality(fitted(clean(seed), noise if told else None), np.random.default_rng([seed, 1]), n_simulated=400).p
        for seed in range(150)
    ]
    # uniform: the Kolmogorov distance of 150 draws exceeds 0.13 with a chance of 1 %
    assert stats.kstest(p, "uniform").statistic < 0.13


def quality(values, told=True):
    return fit_quality(fitted(values, Noise(0.0, 1.0) if told else None), np.random.default_rng(0))


def test_a_smooth_misfit_of_the_size_of_the_noise_is_found():
    wave = 1.4 * np.sin(2 * np.pi * 2 * (SPEED - 100) / 100)
    found = quality(clean(1) + np.stack([wave, 0 * wave], axis=1), told=False)
    assert found.p < 0.005 and found.worst_statistic == "autocorrelation over speed"


def test_one_wild_value_is_found_and_located():
    values = clean(2)
    values[20, 1] += 8.0
    found = quality(values)
    assert found.p < 0.005 and found.p_by_statistic["largest residual"] < 0.005
    assert found.worst_channel == 1 and found.worst_band[0] <= SPEED[20] <= found.worst_band[1]


def test_too_large_a_chi2_is_found_only_where_the_noise_is_known():
    values = clean(3, Noise(0.0, 1.5))
    assert quality(values).p < 0.005 and quality(values).reduced_chi2 == pytest.approx(2.25, rel=0.2)
    assert quality(values, told=False).p > 0.01


def test_cross_channel_correlation_is_found():
    shared = np.random.default_rng(4).standard_normal((48, 2)) @ [1, 1j]
    found = quality(clean(5) + 0.7 * shared[:, None], told=False)
    assert found.p < 0.005 and found.p_by_statistic["cross-channel correlation"] < 0.005


def test_forward_and_backward_whirl():
    """A forward circle is (1, −i), a backward one (1, i), under Re(q e^{iΩt}) with the shaft turning from x to y."""
    both = np.outer([2.0, 0.5j], [1, -1j]) + np.outer([0.25, 1.0], [1, 1j])
    parts = whirl_parts(both, CHANNELS)
    assert parts[0.1] == pytest.approx(np.array([[2.0, 0.5j], [0.25, 1.0]]))
    assert whirl_parts(both, (Channel(0.1, "x"), Channel(0.2, "y"))) == {}


@pytest.mark.parametrize("is_complex", [True, False])
def test_statistics_are_what_they_say(is_complex):
    """Against sums over speeds, channels and pairs, one by one."""
    rng = np.random.default_rng(3)
    residuals = rng.standard_normal((2, 14, 3)) + 1j * is_complex * rng.standard_normal((2, 14, 3))
    residuals = residuals if is_complex else residuals.real
    rows = [slice(0, 8), slice(8, 14)]
    for one, found in zip(residuals, residual_statistics(residuals, rows, scale_free=False), strict=True):
        unit = one / np.sqrt(np.mean(np.abs(one) ** 2))
        autocorrelation = sum(
            (unit[k + lag, c] * np.conj(unit[k, c])).real
            for run in rows
            for lag in (1, 2, 3)
            for k in range(run.start, run.stop - lag)
            for c in range(3)
        )
        cross = sum(abs(np.vdot(unit[:, a], unit[:, b])) ** 2 / 14 for a, b in ((0, 1), (0, 2), (1, 2)))
        bands = [part for run in rows for part in np.array_split(np.abs(unit[run]) ** 2, 3)]
        largest = max(np.mean(band, axis=0).max() for band in bands)
        total = np.sum(np.abs(one) ** 2)
        # 1e-12: rounding of some hundred terms
        np.testing.assert_allclose(found, [autocorrelation, cross, np.abs(unit).max(), largest, total], rtol=1e-12)
