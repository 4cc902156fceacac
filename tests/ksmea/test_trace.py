"""The trace: what is an improvement and what it took, by counts of the tests' own; stages; what is left out of records."""

import dataclasses

import numpy as np
import pytest

from counted_runs import measured, streams
from ksmea.errors import SettingError
from ksmea.identification.direct import Direct
from ksmea.identification.ksmea import KSMEA
from ksmea.identification.trace import (
    STEPS_PER_DECADE,
    Improvement,
    TracedProblem,
    comparable_misfit,
    thinned,
)
from ksmea.likelihood.likelihood import Likelihood
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.channel import Channel
from ksmea.measurement.noise import Noise
from ksmea.plugins.identification import Identification, Method, Stage
from ksmea.problem.case import Case
from ksmea.problem.counted import Model
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem
from ksmea.records.trace import StageRecord, TraceRecord, stage_number
from ksmea.studies.identify import IdentificationOptions, identification
from optimizers.de import DE
from optimizers.lm import LM
from optimizers.pso import PSO
from problems.three_disk import ThreeDisk
from surrogates.kriging import Kriging

TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
SECONDS = {"model": 0.0, "surrogate": 0.0, "search": 0.0, "total": 0.0}


def stage_names(trace):
    """The stage of each improvement, '' if the method has none."""
    counts = zip(trace.evaluations, trace.jacobians)
    return [trace.stages[stage_number(trace.stages, *count)].name if trace.stages else "" for count in counts]


@pytest.fixture(scope="module")
def rotor():
    return ThreeDisk().build()


class Spring(Problem):
    """Responses k at one speed; k = 3 has none that is finite."""

    parameters = Parameters((Parameter("k", "N/m", 1.0, 1.0, 9.0),))
    speed = np.array([1.0])
    channels = (Channel(0.0, "x"),)

    def response(self, x):
        return np.where(x == 3.0, np.nan, x + 0j)[:, :, None]


def traced_spring():
    measurement = measured(Spring(), [5.0], noise=Noise(0.0, 1.0))
    measurement = dataclasses.replace(measurement, values=np.array([[5.0 + 0j]]))
    return TracedProblem(Spring(), measurement)


def k_of(traced):
    return [float(each.x[0]) for each in traced.improvements]


def test_points_of_a_batch_improve_one_after_the_other_at_their_own_counts():
    traced = traced_spring()
    traced.response(np.array([[9.0], [9.0], [7.0]]))  # misfits 2 · 16, 16, 4: the second is no better
    traced.response(np.array([[8.0]]))
    traced.response(np.array([[3.0], [6.0], [5.5], [6.0]]))  # the first is not finite
    assert k_of(traced) == [9.0, 7.0, 6.0, 5.5]
    assert [each.evaluations for each in traced.improvements] == [1, 3, 6, 7]
    # two real residuals of a complex datum with half the variance each; the level of the noise is that of the reference
    assert [each.misfit for each in traced.improvements] == pytest.approx([32.0, 8.0, 2.0, 0.5])
    seconds = [each.seconds for each in traced.improvements]
    assert seconds == sorted(seconds) and seconds[0] > 0


def test_the_response_at_a_jacobian_counts_and_the_jacobian_with_it(rotor):
    measurement = measured(rotor, TRUTH, "amplitude", Noise(0.1, 0.0))
    traced = TracedProblem(rotor, measurement)
    traced.response(1.2 * TRUTH[None])
    traced.linearised(1.1 * TRUTH)
    traced.sensitivity(TRUTH)  # shows no response
    assert [(each.evaluations, each.jacobians) for each in traced.improvements] == [(1, 0), (1, 1)]
    assert traced.improvements[-1].x == pytest.approx(1.1 * TRUTH)


@pytest.mark.parametrize("kind", ["amplitude", "complex"])
@pytest.mark.parametrize("noise", [Noise(0.1, 0.0), Noise(0.0, 2e-6), Noise(0.05, 1e-6)])
def test_the_misfit_of_noisy_data_is_the_deviance_of_the_likelihood(rotor, kind, noise):
    measurement = measured(rotor, TRUTH, kind, noise)
    u = np.random.default_rng(1).random((4, 5))
    likelihood = Likelihood(Model(rotor), measurement)
    found = comparable_misfit(measurement)(rotor.response(rotor.parameters.to_si(u)))
    assert found == pytest.approx([likelihood.deviance(point) for point in u], rel=1e-9)  # another order of sums


@pytest.mark.parametrize("kind", ["amplitude", "complex"])
def test_where_the_level_is_not_known_it_is_the_least_deviance_of_any_relative_level(rotor, kind):
    measurement = dataclasses.replace(measured(rotor, TRUTH, kind, Noise(0.1, 0.0)), noise=None)
    likelihood = Likelihood(Model(rotor), measurement)
    for factor in (1.0, 1.1):
        u = rotor.parameters.to_cube(factor * TRUTH)
        levels = np.log(np.geomspace(0.05, 5.0, 2001))
        deviances = [likelihood.deviance(np.array([*u, level, -800.0])) for level in levels]  # no floor
        [found] = comparable_misfit(measurement)(rotor.response(factor * TRUTH[None]))
        # levels lie 0.23 % apart, and N real numbers make a parabola of 2 N in ln ρ: 2 · 212 · 0.0012² at most
        assert 0 <= min(deviances) - found < 1e-3
        assert 0 < np.argmin(deviances) < 2000


def test_of_exact_data_it_is_the_likelihood_misfit(rotor):
    measurement = measured(rotor, TRUTH)
    response = rotor.response(1.1 * TRUTH[None])
    misfit = Misfit(measurement, "likelihood")
    assert comparable_misfit(measurement)(rotor.response(TRUTH[None])) == pytest.approx([0.0], abs=1e-12)
    assert comparable_misfit(measurement)(response) == pytest.approx(misfit.value(misfit.observed(response)))


# -- whatever the method is --


@dataclasses.dataclass(frozen=True)
class Boasts(Method):
    """Asks three points and a Jacobian, swallows what they say, and returns a point that it has never evaluated."""

    def identify(self, problem, measurement, streams):
        problem.response(np.stack([1.3 * TRUTH, 1.1 * TRUTH, 1.2 * TRUTH]))
        problem.linearised(1.05 * TRUTH)
        return Identification(TRUTH, (False,) * 5, -1e9, "optimizer", 0, 1, 0, 0, SECONDS)


def test_a_method_that_tells_otherwise_has_the_trace_of_what_it_asked(rotor):
    measurement = measured(rotor, TRUTH, "amplitude", Noise(0.1, 0.0))
    record = identification(
        Case(rotor, measurement), Boasts(), streams(), IdentificationOptions(intervals="none", crlb=False)
    )
    trace = record.trace
    assert (trace.evaluations, trace.jacobians) == ((1, 2, 3), (0, 0, 1))
    assert [x[0] for x in trace.x] == pytest.approx([1.3 * TRUTH[0], 1.1 * TRUTH[0], 1.05 * TRUTH[0]])
    assert record.misfit < trace.misfit[-1]  # the true model was never asked at the point that it returned
    assert trace.stages == () and stage_names(trace) == ["", "", ""] and record.stage == ""
    assert trace.least is None and trace.error == ()  # nobody told the truth


@dataclasses.dataclass(frozen=True)
class LosesItsWay(Method):
    """A first stage that ends nowhere."""

    def identify(self, problem, measurement, streams):
        stages = (Stage("search", np.full(5, np.nan), 0, 0), Stage("final step", TRUTH, 0, 0))
        return Identification(TRUTH, (False,) * 5, 1.0, "optimizer", 0, 0, 0, 0, SECONDS, stages=stages)


def test_a_stage_that_ends_nowhere_is_refused(rotor):
    measurement = measured(rotor, TRUTH, "amplitude", Noise(0.1, 0.0))
    with pytest.raises(ArithmeticError, match="not finite"):
        identification(
            Case(rotor, measurement), LosesItsWay(), streams(), IdentificationOptions(intervals="none", crlb=False)
        )


def run(rotor, measurement, method):
    return identification(
        Case(rotor, measurement), method, streams(), IdentificationOptions(intervals="none", crlb=False)
    )


@pytest.mark.parametrize("optimizer", [DE(population=20, generations=20), PSO(population=20, generations=20)])
def test_a_final_step_does_not_hide_where_the_optimiser_ended(rotor, optimizer):
    measurement = measured(rotor, TRUTH, "amplitude", Noise(0.1, 0.0))
    alone = run(rotor, measurement, Direct(optimizer))
    ended = run(rotor, measurement, Direct(optimizer, final_step=True))
    assert (alone.stage, ended.stage) == ("search", "final step")
    search, final = ended.trace.stages
    assert search.x == pytest.approx(alone.x, rel=0) and final.x == pytest.approx(ended.x, rel=0)
    assert (search.evaluations, search.jacobians) == (alone.model_evaluations, 0)
    assert (final.evaluations, final.jacobians) == (ended.model_evaluations, ended.model_jacobians)
    of_search = [name == "search" for name in stage_names(ended.trace)]
    assert np.array(ended.trace.misfit)[of_search].tolist() == list(alone.trace.misfit)  # it is not thinned away either
    assert ended.trace.misfit[-1] < alone.trace.misfit[-1] and not of_search[-1]
    assert ended.trace.misfit[-1] == pytest.approx(ended.misfit, rel=1e-9)  # ten digits are kept


def test_a_final_step_is_taken_where_noise_is_estimated_unless_it_is_refused(rotor):
    measurement = dataclasses.replace(measured(rotor, TRUTH, "amplitude", Noise(0.1, 0.0)), noise=None)
    optimizer = LM(screening=200, starts=2)
    assert run(rotor, measurement, Direct(optimizer)).stage == "final step"
    assert run(rotor, measurement, Direct(optimizer, final_step=False)).stage == "search"


def test_a_method_with_a_surrogate_improves_at_samples_and_at_the_points_that_it_adds(rotor):
    measurement = measured(rotor, TRUTH, "amplitude", Noise(0.1, 0.0))
    method = KSMEA(Kriging(), DE(population=10, generations=5), 30, max_updates=4)
    record = run(rotor, measurement, method)
    trace = record.trace
    taking = [stage for stage in trace.stages if not stage.on_surrogate]
    assert [(stage.name, stage.evaluations) for stage in taking] == [
        ("samples", 30),
        ("updating steps", record.model_evaluations),
    ]
    assert set(stage_names(trace)) == {"samples", "updating steps"}
    for evaluations, predicted, name in zip(trace.evaluations, trace.surrogate_evaluations, stage_names(trace)):
        assert (name == "samples") == (evaluations <= 30) == (predicted == 0)
    added = [np.array(update.x) for update in record.history]
    misfits = comparable_misfit(measurement)(rotor.response(np.array(added)))
    assert trace.misfit[-1] == pytest.approx(min(misfits), rel=1e-9)
    # in each step what the objective counts and one prediction at its optimum
    assert trace.surrogate_evaluations[-1] <= record.surrogate_evaluations + record.updates


def test_the_gain_of_a_polish_is_told_beside_the_optimiser_that_came_before(rotor):
    measurement = measured(rotor, TRUTH, "amplitude", Noise(0.1, 0.0))
    rough, least_squares = DE(population=5, generations=1), LM(screening=200, starts=3)

    def gain(optimizer, **settings):
        method = KSMEA(Kriging(), optimizer, 30, max_updates=1, **settings)
        return run(rotor, measurement, method).history[0].polish_gain

    # ten points in five dimensions are far from the optimum: by more than 1 of a misfit in units of the noise
    assert gain(rough) > 1 and gain(rough, polish=False) is None
    assert 0 <= gain(least_squares) < 1e-6  # which the polish repeats


def test_the_search_and_its_polish_are_stages_of_the_record_and_of_the_trace(rotor):
    measurement = measured(rotor, TRUTH, "amplitude", Noise(0.1, 0.0))
    record = run(rotor, measurement, KSMEA(Kriging(), DE(population=5, generations=1), 30, max_updates=3))
    for update in record.history:
        search, polish = update.search
        assert (search.name, polish.name) == ("search", "polish")
        assert polish.x == update.x != search.x and polish.misfit < search.misfit
        assert update.polish_gain == pytest.approx(search.misfit - polish.misfit)
    stages = {stage.name: stage for stage in record.trace.stages}
    assert list(stages) == ["samples", "search", "polish", "updating steps"]
    assert [name for name, stage in stages.items() if stage.on_surrogate] == ["search", "polish"]
    # what the true model has shown is never that of a search on the surrogate
    assert set(stage_names(record.trace)) <= {"samples", "updating steps"}
    raw = run(rotor, measurement, KSMEA(Kriging(), DE(population=5, generations=1), 30, max_updates=1, polish=False))
    assert [stage.name for stage in raw.history[0].search] == ["search"]
    assert raw.history[0].search[0].x == raw.history[0].x
    # the same optimiser on the same surrogate: the polish alone is what differs
    assert raw.history[0].x == record.history[0].search[0].x


# -- what a record keeps --


def trace_of(misfits, stages=()):
    """Each of n evaluations with its misfit, improvements as they come."""
    best, found = np.inf, []
    for number, misfit in enumerate(misfits, start=1):
        if misfit < best:
            best = misfit
            found.append(Improvement(number, 0, 0, 0.001 * number, float(misfit), np.array([float(number)])))
    return thinned(found, stages)


def test_thinning_never_dates_an_improvement_too_early_and_loses_less_than_a_step():
    falling = np.geomspace(1e6, 1.0, 20_000)  # every evaluation improves
    trace = trace_of(falling)
    assert len(trace.misfit) <= STEPS_PER_DECADE * np.log10(20_000) + 1
    for evaluations, misfit in zip(trace.evaluations, trace.misfit):
        assert misfit == pytest.approx(falling[evaluations - 1], rel=1e-9)
    assert trace.evaluations[0] == 1 and trace.evaluations[-1] == 20_000
    steps = np.diff(np.log10(trace.evaluations))
    few = np.array(trace.evaluations[1:]) < 20  # of so few evaluations each has a step of its own
    assert np.all(steps[~few] < 2 / STEPS_PER_DECADE)
    assert np.all(np.diff(trace.evaluations)[few] <= 1 + 0.13 * np.array(trace.evaluations[1:])[few])


def test_the_last_improvement_of_each_stage_is_kept():
    ends = [Stage(name, np.zeros(1), number, 0) for name, number in (("search", 1000), ("final step", 1004))]
    trace = trace_of(np.geomspace(1e6, 1.0, 1004), ends)
    assert 1000 in trace.evaluations and 1004 in trace.evaluations
    assert stage_names(trace)[-2:] == ["search", "final step"]


def test_a_trace_is_judged_in_units_of_the_crlb_by_what_the_data_tell():
    angle = Parameter("phase", "deg", np.pi / 180, -np.pi, np.pi)
    parameters = Parameters((Parameter("k", "N/m", 1.0, 1.0, 9.0), angle, Parameter("c", "N s/m", 1.0, 0.1, 9.0)))
    trace = TraceRecord((1, 2), (0, 0), (0, 0), (9.0, 4.0), (0.1, 0.2), x=((5.0, 3.0, 1.0), (3.0, -3.1, 1.0)))
    trace = dataclasses.replace(trace, stages=(StageRecord("search", 2, 0, trace.x[1]),))
    judged = trace.judged(parameters, np.array([4.0, -3.1, 7.0]), [0.5, 0.1, None], 1.5)
    across = 2 * np.pi - 6.1  # from −3.1 to 3 rad by the short way
    expected = [np.sqrt((2.0**2 + (across / 0.1) ** 2) / 2), np.sqrt(2.0**2 / 2)]
    assert judged.error == pytest.approx(expected, rel=1e-4)  # five digits are kept
    assert judged.stages[0].error == pytest.approx(expected[1], rel=1e-4)
    assert judged.excess == pytest.approx([7.5, 2.5]) and judged.x == () and trace.excess is None
    exact = trace.judged(parameters, np.array([4.0, -3.1, 7.0]), [None] * 3, 0.0)
    assert exact.x == trace.x and exact.error == ()  # without a bound there is no unit of errors


@pytest.mark.parametrize("changes", [{"misfit": (1.0,)}, {"x": ((1.0,), (1.0, 2.0))}, {"jacobians": ()}])
def test_a_trace_with_columns_that_do_not_go_together_is_refused(changes):
    whole = TraceRecord((1, 2), (0, 0), (0, 0), (9.0, 4.0), (0.1, 0.2), x=((5.0,), (3.0,)))
    whole.check(1)
    with pytest.raises(SettingError, match="trace: expected"):
        dataclasses.replace(whole, **changes).check(1)
