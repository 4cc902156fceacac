"""KSMEA, step by step: a mass on a spring with parts whose behaviour is known."""

import dataclasses
import pickle
import time

import numpy as np
import pytest

from counted_runs import Counted, measured, streams
from ksmea.identification.ksmea import KSMEA
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.channel import Channel
from ksmea.measurement.noise import Noise
from ksmea.numerics.screening import latin_hypercube
from ksmea.plugins.optimizer import Optimizer
from ksmea.plugins.surrogate import Predictor, Surrogate
from ksmea.plugins.transforms import make_transform
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem
from surrogates.none import NoSurrogate


def same(first, second):
    """Whether two histories agree to the last digit, whatever they hold."""
    return pickle.dumps([*map(dataclasses.asdict, first)]) == pickle.dumps([*map(dataclasses.asdict, second)])


class Spring(Problem):
    """The receptance 1 / (k − ω² + iωc) of 1 kg, k in [1, 4] N/m, c in [0.5, 1.5] N s/m: smooth everywhere."""

    parameters = Parameters((Parameter("k", "N/m", 1.0, 1.0, 4.0), Parameter("c", "N s/m", 1.0, 0.5, 1.5)))
    speed = np.array([0.5, 1.0, 1.5, 2.0])
    channels = (Channel(0.0, "x"),)

    def response(self, x):
        k, c = x[:, :1], x[:, 1:]
        return (1 / (k - self.speed**2 + 1j * self.speed * c))[:, :, None]


SPRING_TRUTH = [2.0, 0.8]


@dataclasses.dataclass(frozen=True)
class ExactSurrogate(Surrogate):
    """Predicts with a model of its own that nobody counts, and notes what it was fitted to and asked."""

    error: float = 0.0
    fitted: list = dataclasses.field(default_factory=list)
    refitted: list = dataclasses.field(default_factory=list)
    appended: list = dataclasses.field(default_factory=list)
    asked: list = dataclasses.field(default_factory=list)  # how many points each time

    def least_samples(self, d):
        return 1

    def fit(self, u, y, rng):
        self.fitted.append(u.copy())
        return self.predictor(y)

    def predictor(self, y):
        return ExactPredictor(self, self.error)

    @property
    def rows(self):
        return sum(self.asked)


class ExactPredictor(Predictor):
    transform = make_transform("auto", "complex", n_speed=4, n_channel=1)

    def __init__(self, surrogate, error):
        self.surrogate, self.error = surrogate, error

    def predict(self, u):
        self.surrogate.asked.append(len(u))
        return self.transform.encode(Spring().response(Spring.parameters.to_si(u))) + self.error


class AppendingSurrogate(ExactSurrogate):
    def predictor(self, y):
        return AppendingPredictor(self, self.error)


class AppendingPredictor(ExactPredictor):
    def append(self, u, y):
        self.surrogate.appended.append((u.copy(), y.copy()))
        return AppendingPredictor(self.surrogate, self.error)


class RefittingSurrogate(AppendingSurrogate):
    def refit(self, previous, u, y, rng):
        assert isinstance(previous, AppendingPredictor)
        self.refitted.append(u.copy())
        return self.predictor(y)


@dataclasses.dataclass(frozen=True)
class Guess(Optimizer):
    """An optimiser that evaluates `n` random points, or one that it is given."""

    n: int = 1
    always: tuple[float, ...] | None = None

    def minimize(self, objective, rng):
        objective(rng.random((self.n, objective.dim)) if self.always is None else np.array([self.always]))
        return objective.result()


def run_spring(surrogate, optimizer=Guess(), samples=6, noise=Noise(0.05, 0.0), seed=0, **settings):  # noqa: B008
    problem = Counted(Spring())
    method = KSMEA(surrogate, optimizer, samples, **settings)
    found = method.identify(problem, measured(Spring(), SPRING_TRUTH, noise=noise), streams(seed))
    assert problem.points == found.model_evaluations
    return found


def test_it_stops_where_the_surrogate_is_accurate_beside_the_residual():
    found = run_spring(ExactSurrogate(error=1e-6))
    assert (found.stop, found.updates) == ("smc", 1)
    assert 0.999 < found.history[0].smc < 1 and not found.was_cut_short


def test_it_goes_on_where_the_surrogate_is_less_accurate_than_asked():
    found = run_spring(ExactSurrogate(error=1.0), max_updates=3)
    assert (found.stop, found.updates) == ("updates", 3) and found.was_cut_short
    assert all(update.smc < 0.999 for update in found.history)


def test_it_stops_where_surrogate_and_model_agree():
    found = run_spring(ExactSurrogate(), smc=1.0)  # 1 is never exceeded
    assert (found.stop, found.updates) == ("sdf", 1)
    assert found.history[0].sdf < 1e-11


def test_at_the_exact_values_only_the_difference_can_stop_it():
    """Without noise nothing is left to compare the surrogate's error with."""
    truth = tuple(Spring.parameters.to_cube(SPRING_TRUTH))
    found = run_spring(ExactSurrogate(), Guess(always=truth), noise=Noise(0.0, 0.0), polish=False)
    assert (found.stop, found.updates) == ("sdf", 1) and found.history[0].smc == -np.inf
    assert np.allclose(found.x, SPRING_TRUTH, rtol=1e-14)


def test_it_stops_at_a_point_that_is_a_sample_already():
    found = run_spring(ExactSurrogate(error=1.0), Guess(always=(0.2, 0.7)), polish=False)
    assert (found.stop, found.updates) == ("repeated", 2) and not found.was_cut_short


def test_it_stops_at_its_budget():
    found = run_spring(ExactSurrogate(error=1.0), polish=False, budget=10)
    assert (found.stop, found.updates, found.model_evaluations) == ("budget", 4, 10) and found.was_cut_short


@pytest.mark.parametrize("budget", [7, 8, 9, 11, 30])
def test_the_budget_holds_for_updates_and_final_step_together(budget):
    found = run_spring(ExactSurrogate(error=1.0), polish=False, max_updates=2, final_step=True, budget=budget)
    assert found.model_evaluations <= budget
    if (
        budget <= 11
    ):  # derivatives by differences take 5 points at once: what is left of 8 samples and updates is too few
        assert found.model_evaluations == min(budget, 8)


def test_the_budget_holds_where_the_surrogate_is_the_true_model():
    found = run_spring(NoSurrogate(), Guess(n=100), budget=50)
    assert found.model_evaluations <= 50
    assert found.stop == "budget"


def test_a_search_on_the_surrogate_has_its_own_budget():
    surrogate = ExactSurrogate(error=1.0)
    found = run_spring(surrogate, Guess(n=1000), max_updates=3, surrogate_budget=50)
    assert found.surrogate_evaluations == 3 * 50 and found.updates == 3


def test_surrogate_evaluations_are_counted_apart():
    surrogate = ExactSurrogate(error=1.0)
    found = run_spring(surrogate, Guess(n=20), max_updates=4, polish=False)
    assert found.surrogate_evaluations == 4 * 20 == surrogate.rows - 4
    surrogate = ExactSurrogate(error=1.0)
    found = run_spring(surrogate, Guess(n=20), max_updates=4)
    # beside the search each optimum is predicted once more, for the stopping rules
    assert found.surrogate_evaluations == surrogate.rows - found.updates > found.updates * 20
    assert found.model_evaluations == 6 + found.updates


def test_the_optimum_is_added_as_a_sample():
    surrogate = ExactSurrogate(error=1.0)
    found = run_spring(surrogate, max_updates=4)
    initial = latin_hypercube(6, 2, streams().design)
    optima = Spring.parameters.to_cube([update.x for update in found.history])
    assert len(surrogate.fitted) == 4
    for k, u in enumerate(surrogate.fitted):
        assert np.allclose(u, np.vstack([initial, optima[:k]]), rtol=0, atol=1e-14)  # cube to SI and back


def test_time_in_the_true_model_is_the_models_wherever_it_is_spent():
    class Slow(Spring):
        def response(self, x):
            time.sleep(0.02)
            return super().response(x)

    measurement = measured(Spring(), SPRING_TRUTH, noise=Noise(0.05, 0.0))
    method = KSMEA(NoSurrogate(), Guess(n=20), 6, polish=False)
    seconds = method.identify(Slow(), measurement, streams()).seconds
    assert seconds["model"] >= 4 * 0.02  # samples, search, prediction and response at the optimum
    assert seconds["model"] + seconds["surrogate"] + seconds["search"] <= seconds["total"]


def test_the_search_ends_at_the_optimum_of_the_surrogate():
    polished = run_spring(ExactSurrogate(), Guess(n=30), noise=Noise(0.0, 0.0), max_updates=1)
    rough = run_spring(ExactSurrogate(), Guess(n=30), noise=Noise(0.0, 0.0), max_updates=1, polish=False)
    assert np.allclose(polished.x, SPRING_TRUTH, rtol=1e-8)
    assert not np.allclose(rough.x, SPRING_TRUTH, rtol=1e-3)


def test_the_best_of_all_true_evaluations_is_returned():
    """Also a sample of the initial design, where no optimum of a poor surrogate is better."""
    found = run_spring(ExactSurrogate(error=1.0), Guess(always=(1.0, 1.0)), 40, max_updates=3, polish=False)
    misfit = Misfit(measured(Spring(), SPRING_TRUTH, noise=Noise(0.05, 0.0)), "log")
    points = Spring.parameters.to_si(latin_hypercube(40, 2, streams().design))
    values = misfit.value(Spring().response(points))
    assert np.array_equal(found.x, points[values.argmin()])
    assert found.misfit == pytest.approx(values.min(), rel=1e-12) and found.misfit < found.history[0].misfit


def test_only_the_nearest_samples_to_the_best_one_are_fitted():
    surrogate = ExactSurrogate(error=1.0)
    found = run_spring(surrogate, samples=9, max_updates=6, polish=False, nearest=5)
    points = np.vstack(
        [latin_hypercube(9, 2, streams().design), Spring.parameters.to_cube([update.x for update in found.history])]
    )
    misfit = Misfit(measured(Spring(), SPRING_TRUTH, noise=Noise(0.05, 0.0)), "log")
    values = misfit.value(Spring().response(Spring.parameters.to_si(points)))
    for k, u in enumerate(surrogate.fitted):
        known = points[: 9 + k]
        distance = np.linalg.norm(known - known[values[: 9 + k].argmin()], axis=1)
        assert len(u) == 5
        expected = known[distance <= np.sort(distance)[4]]
        assert np.allclose(u, expected, rtol=0, atol=1e-14)


def test_between_refits_the_sample_is_only_appended():
    surrogate = AppendingSurrogate(error=1.0)
    found = run_spring(surrogate, max_updates=7, polish=False, refit_every=3)
    assert found.updates == 7
    assert [len(u) for u in surrogate.fitted] == [6, 9, 12]  # before updates 1, 4 and 7
    optima = Spring.parameters.to_cube([update.x for update in found.history])
    assert np.allclose([u for u, _ in surrogate.appended], optima[[0, 1, 3, 4]], rtol=0, atol=1e-14)
    responses = Spring().response(np.array([update.x for update in found.history]))[[0, 1, 3, 4], :, 0]
    assert np.allclose([y[:4] for _, y in surrogate.appended], np.log(np.abs(responses)), rtol=0, atol=1e-12)


def test_a_surrogate_that_cannot_append_is_fitted_every_time():
    surrogate = ExactSurrogate(error=1.0)
    run_spring(surrogate, max_updates=4, polish=False, refit_every=3)
    assert [len(u) for u in surrogate.fitted] == [6, 7, 8, 9]


def test_a_surrogate_that_can_is_refitted_from_where_it_was():
    surrogate = RefittingSurrogate(error=1.0)
    run_spring(surrogate, max_updates=4, polish=False)
    assert [len(u) for u in surrogate.fitted] == [6]
    assert [len(u) for u in surrogate.refitted] == [7, 8, 9] and not surrogate.appended


@dataclasses.dataclass(frozen=True)
class BiasedAtOneSpeed(ExactSurrogate):
    """Wrong by 1 in ln|y| at the first speed, and aware of it."""

    aware: bool = True

    def predictor(self, y):
        error = np.zeros(y.shape[1])
        error[0] = 1.0
        return (AwarePredictor if self.aware else ExactPredictor)(self, error)


class AwarePredictor(ExactPredictor):
    def leave_one_out(self):
        return self.error


def test_the_error_that_a_surrogate_tells_of_takes_weight_from_its_outputs():
    distance = {}
    for surrogate_error in (True, False):
        found = run_spring(
            BiasedAtOneSpeed(), Guess(n=30), noise=Noise(0.01, 0.0), max_updates=1, surrogate_error=surrogate_error
        )
        distance[surrogate_error] = np.linalg.norm(found.history[0].x / SPRING_TRUTH - 1)
    # noise of 1 % against an error of 1 in a logarithm
    assert distance[True] < 0.03 and distance[False] > 0.1


def test_a_surrogate_that_does_not_tell_its_error_is_taken_at_its_word():
    first = run_spring(BiasedAtOneSpeed(aware=False), Guess(n=30), max_updates=1)
    second = run_spring(BiasedAtOneSpeed(), Guess(n=30), max_updates=1, surrogate_error=False)
    assert same(first.history, second.history)


def test_the_history_holds_what_was_predicted_and_what_came():
    found = run_spring(ExactSurrogate(error=0.1), max_updates=1, polish=False, smc=-1e9)
    update = found.history[0]
    measurement = measured(Spring(), SPRING_TRUTH, noise=Noise(0.05, 0.0))
    response = Spring().response(update.x[None])[0]
    misfit = Misfit(measurement, "log")
    # ln|y|, cos and sin each 0.1 too large
    phase = np.angle(response)
    predicted = np.abs(response) * np.exp(0.1 + 1j * np.arctan2(np.sin(phase) + 0.1, np.cos(phase) + 0.1))
    assert update.misfit == pytest.approx(misfit.value(response[None])[0], rel=1e-9)
    assert update.predicted_misfit == pytest.approx(misfit.value(predicted[None])[0], rel=1e-9)
    assert update.sdf == pytest.approx(np.sum(np.abs(predicted - response)), rel=1e-9)
    residual = np.sum(np.abs(response - measurement.values) ** 2)
    assert update.smc == pytest.approx(1 - np.sum(np.abs(predicted - response) ** 2) / residual, rel=1e-9)


class SilentSurrogate(ExactSurrogate):
    """Predicts no number anywhere."""

    def predictor(self, y):
        return ExactPredictor(self, np.nan)


def test_a_surrogate_without_any_prediction_is_an_error_that_says_so():
    with pytest.raises(ArithmeticError, match="none of the 20 points of the optimiser has a finite misfit"):
        run_spring(SilentSurrogate(), Guess(n=20), polish=False)
