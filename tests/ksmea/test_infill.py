"""Expected improvement of a sum of squares: against its closed form, against drawn residuals, and as an infill."""

import numpy as np
import pytest
from scipy.special import gammainc

from counted_runs import Counted, measured, streams
from ksmea.errors import SettingError
from ksmea.identification.ksmea import KSMEA
from ksmea.identification.updating import improvement_residual, log_expected_improvement
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.channel import Channel
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.plugins.transforms import make_transform
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem
from optimizers.de import DE
from surrogates.kriging import Kriging
from surrogates.none import NoSurrogate
from surrogates.rsm import ResponseSurface


def improvement(mean, variance, lowest):
    return np.exp(log_expected_improvement(np.atleast_2d(mean), np.atleast_2d(variance), lowest))[0]


@pytest.mark.parametrize("n, tolerance", [(3, 0.3), (20, 0.15), (106, 0.07)])
@pytest.mark.parametrize("part", [1e-4, 0.1, 0.5, 0.9, 0.999, 1.001, 1.2, 3.0])
def test_it_is_that_of_chi_squared_also_far_out_in_the_tail(n, tolerance, part):
    """m = 0 and v = 1: E max(T − Q, 0) = T F_n(T) − n F_{n+2}(T), from 1e-194 on. The relative error of a saddlepoint is bounded in
    the tail and falls with the number of terms: this one is 25 % at most for 3, 13 % for 20 and 5 % for 106."""
    lowest = part * n
    exact = lowest * gammainc(n / 2, lowest / 2) - n * gammainc(n / 2 + 1, lowest / 2)
    assert improvement(np.zeros(n), np.ones(n), lowest) == pytest.approx(exact, rel=tolerance)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("quantile", [0.02, 0.4, 0.9])
def test_it_is_the_mean_of_drawn_improvements_where_variances_differ(seed, quantile):
    """30 terms with variances over decades: 15 % for the approximation, and four standard errors of 20 000 draws."""
    rng = np.random.default_rng(seed)
    mean, variance = rng.normal(size=30), rng.lognormal(size=30)
    drawn = np.sum((mean + np.sqrt(variance) * rng.normal(size=(20_000, 30))) ** 2, axis=1)
    lowest = np.quantile(drawn, quantile)
    gain = np.maximum(lowest - drawn, 0)
    found = improvement(mean, variance, lowest)
    assert abs(found - gain.mean()) < 0.15 * gain.mean() + 4 * gain.std() / np.sqrt(len(gain))


def test_it_grows_with_the_misfit_to_be_improved():
    """By the distribution function at the most, whose error is largest at the mean, 24.9 here, where two formulas meet."""
    mean, variance = np.full((1, 10), 0.7), np.full((1, 10), 2.0)
    lowest = np.linspace(0.5, 60, 400)
    found = np.exp([log_expected_improvement(mean, variance, each)[0] for each in lowest])
    slope = np.diff(found) / np.diff(lowest)
    assert np.all(slope > 0) and np.all(slope < 1.01)


def test_what_is_predicted_exactly_improves_by_the_difference_or_not_at_all():
    mean, exact = np.array([3.0, 4.0]), np.zeros(2)
    assert improvement(mean, exact, 30.0) == pytest.approx(5.0, rel=1e-5)
    assert improvement(mean, exact, 20.0) == 0


def test_the_residual_is_least_where_most_improvement_is_expected():
    mean, variance = (
        np.array([[2.0, 2.0], [1.0, 1.0], [2.0, 2.0], [np.nan, 1.0]]),
        np.array([[1.0], [1.0], [9.0], [1.0]]),
    )
    residual = improvement_residual(mean, np.tile(variance, 2), 3.0)[:, 0]
    assert np.argsort(residual[:3]).tolist() == [1, 2, 0] and np.all(residual[:3] >= 0)
    assert np.isnan(residual[3])
    assert np.all(np.isfinite(improvement_residual(mean[:3], np.tile(variance[:3], 2), 0.0)))  # nothing to improve


@pytest.mark.parametrize("form", ["plain", "weighted", "log"])
@pytest.mark.parametrize("kind", ["amplitude", "complex"])
def test_spreads_of_residuals_are_those_of_drawn_responses(form, kind):
    """Outputs with 1 % errors, 4 000 draws: second-order terms of a per cent, and a standard error of 1.1 % each."""
    rng = np.random.default_rng(0)
    response = rng.normal(size=(1, 3, 2)) + 1j * rng.normal(size=(1, 3, 2)) + 3
    speed, channels = np.array([1.0, 2.0, 3.0]), (Channel(0.0, "x"), Channel(0.0, "y"))
    transform = make_transform("none", Observable(kind), n_speed=3, n_channel=2)
    outputs = transform.encode(response)
    sd = 0.01 * (1 + rng.random(outputs.shape))
    if kind == "complex":  # equal in both parts, as the total of a complex datum is all that is kept of them
        sd[:, 6:] = sd[:, :6]

    class Fixed(Problem):
        parameters = Parameters((Parameter("k", "N/m", 1.0, 1.0, 4.0),))

        def response(self, x):
            return response * 1.1

    Fixed.speed, Fixed.channels = speed, channels
    misfit = Misfit(measured(Fixed(), [2.0], kind, Noise(0.1, 0.0)), form)
    drawn = misfit.residuals(transform.decode(outputs + sd * rng.normal(size=(4000, outputs.shape[1]))))
    predicted = transform.decode(outputs)
    expected = misfit.residual_sd(predicted, transform.spread(sd, predicted))[0]
    np.testing.assert_allclose(drawn.std(axis=0), expected, rtol=0.06)


class TwoValleys(Problem):
    """A response whose logarithm is Forrester's function of one unknown over 5: a broad valley at 0.14 beside the lowest point
    at 0.757 (Forrester, Sóbester and Keane, Engineering Design via Surrogate Modelling, 2008, appendix A.1)."""

    parameters = Parameters((Parameter("x", "1", 1.0, 0.0, 1.0),))
    speed = np.array([1.0])
    channels = (Channel(0.0, "x"),)

    def response(self, x):
        return np.exp((6 * x - 2) ** 2 * np.sin(12 * x - 4) / 5)[:, :, None].astype(complex)


LOWEST = 0.7572


def identified(infill, seed, surrogate=Kriging(trend="constant"), samples=4, **settings):  # noqa: B008, frozen values
    problem = Counted(TwoValleys())
    method = KSMEA(surrogate, DE(population=20, generations=10), samples, infill=infill, smc=1.0, sdf=0.0, **settings)
    found = method.identify(problem, measured(TwoValleys(), [LOWEST], "amplitude", Noise(0.05, 0.0), 7), streams(seed))
    assert problem.points == found.model_evaluations
    return found


@pytest.mark.slow
def test_it_leaves_a_valley_that_the_lowest_prediction_stays_in():
    """The textbook case (chapter 3 of the same book): samples that show the broad valley alone."""
    found = {
        infill: [abs(identified(infill, seed, max_updates=10).x[0] - LOWEST) < 0.02 for seed in range(6)]
        for infill in ("optimum", "expected_improvement")
    }
    assert sum(found["expected_improvement"]) == 6 > sum(found["optimum"])


def test_the_same_streams_give_the_same_result():
    first, again = (identified("expected_improvement", 3, max_updates=3) for _ in range(2))
    assert [update.x[0] for update in first.history] == [update.x[0] for update in again.history]


def test_surrogates_without_a_variance_are_taken_for_exact_or_as_uncertain_as_left_out_samples_say():
    """The true model itself is exact: expected improvement is then the improvement, largest at the lowest point. A parabola of
    Forrester's function has large leave-one-out errors, whatever it predicts: points are as uncertain everywhere."""
    exact = identified("expected_improvement", 1, surrogate=NoSurrogate(), max_updates=1)
    assert abs(exact.x[0] - LOWEST) < 0.02
    parabola = identified("expected_improvement", 0, surrogate=ResponseSurface(), samples=6, max_updates=2)
    assert parabola.updates == 2 and np.isfinite(parabola.misfit)


def test_a_misfit_whose_noise_moves_is_refused():
    likelihood = KSMEA(Kriging(), DE(), 4, infill="expected_improvement", misfit="likelihood")
    with pytest.raises(SettingError, match=r"method\.infill: expected a misfit whose noise stays as it is"):
        likelihood.validate(TwoValleys())
