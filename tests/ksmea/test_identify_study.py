"""The study of identification: what it adds to what a method found, and that true values have no part in it."""

import dataclasses

import numpy as np
import pytest

from counted_runs import Counted, streams
from ksmea.errors import SettingError
from ksmea.identification.direct import Direct
from ksmea.identification.ksmea import KSMEA
from ksmea.inference.cramer_rao import identifiability
from ksmea.inference.maximisation import nearest_maximum
from ksmea.likelihood.likelihood import Likelihood
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.plugins.identification import Identification, Streams, Update
from ksmea.problem.case import Case
from ksmea.problem.counted import Model
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.problem.problem import Problem
from ksmea.records.curves import as_array
from ksmea.records.identification import IdentificationRecord, Seconds
from ksmea.studies import identify
from ksmea.studies.diagnose import diagnosis
from ksmea.studies.identification_details import detailed_identification
from ksmea.studies.identify import IdentificationOptions, identification
from optimizers.de import DE
from optimizers.lm import LM
from problems.three_disk import ThreeDisk
from surrogates.none import NoSurrogate

DETAILS = IdentificationOptions(details=True)
TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
STREAMS = Streams(*(np.random.default_rng(part) for part in range(3)))


@dataclasses.dataclass
class Finds:
    """A method that finds a given point, and notes what it was handed."""

    x: np.ndarray
    stop: str = "optimizer"
    seen: tuple = ()

    def identify(self, problem, measurement, streams):
        self.seen = (problem, measurement, streams)
        seconds = {"model": 0.1, "surrogate": 0.2, "search": 0.3, "total": 0.6}
        history = (Update(self.x, 2.0, 3.0, 0.5, np.inf, 1.0),)
        return Identification(self.x, (False,) * len(self.x), 1.0, self.stop, 1, 7, 2, 11, seconds, history)


@pytest.fixture(scope="module")
def rotor():
    return ThreeDisk().build()


def measured(problem, noise=Noise(0.05, 0.0), kind="complex"):  # noqa: B008 – frozen
    values = observe(problem.response(TRUTH[None])[0], kind, noise or Noise(0.05, 0.0), np.random.default_rng(1))
    return Measurement(problem.speed, problem.channels, values, noise, "test")


def test_what_the_method_found_and_took_is_told(rotor):
    measurement = measured(rotor)
    method = Finds(1.01 * TRUTH, stop="updates")
    record = identification(
        Case(rotor, measurement), method, STREAMS, IdentificationOptions(intervals="none", crlb=False)
    )
    assert method.seen[1:] == (measurement, STREAMS)
    assert record.x == pytest.approx(1.01 * TRUTH)
    assert [part.name for part in record.parameters] == list(rotor.parameters.names)
    assert (record.status, record.stop) == ("budget", "updates")
    assert record.updates == 1
    assert record.surrogate_evaluations == 11
    assert record.seconds == Seconds(0.1, 0.2, 0.3, 0.6)
    assert record.history[0].x == pytest.approx(1.01 * TRUTH) and record.history[0].sdf is None  # it was infinite
    misfit = Misfit(measurement, "likelihood")
    assert record.misfit == pytest.approx(misfit.value(misfit.observed(rotor.response(1.01 * TRUTH[None])))[0])
    assert record.intervals is record.correlation is record.data is record.fit is record.curves is None
    assert all(part.kind is part.crlb is part.true is None for part in record.parameters)


class Asks(Finds):
    """A method that asks the true model by every way that there is, and says that it took 7 evaluations and 2 Jacobians."""

    def identify(self, problem, measurement, streams):
        x = np.array([self.x, self.x, self.x])
        for seen in (
            problem,
            problem.at(problem.speed[:5], problem.channels[:1]),
            problem.with_unbalance(0.2, 1e-5, 0.0),
            problem.at(problem.speed[:5], problem.channels).with_unbalance(0.2, 1e-5, 0.0),
        ):
            seen.response(x)
        turned = problem.with_phase_origin()
        turned.response(np.append(self.x, 0.1)[None])
        problem.dense_response(x[:2])
        problem.sensitivity(self.x)
        problem.linearised(self.x)
        Model(problem).linearise(problem.parameters.to_cube(self.x))
        Model(problem).response(problem.parameters.to_cube(x))
        return super().identify(problem, measurement, streams)


def test_what_a_method_takes_of_the_true_model_is_counted_whatever_it_says(rotor):
    record = identification(Case(rotor, measured(rotor)), Asks(TRUTH), STREAMS)
    # 3 points from each of four views, 1 with the phase open, 2 by the dense route and 3 through a model
    assert record.model_evaluations == 4 * 3 + 1 + 2 + 3
    assert record.model_jacobians == 3


@pytest.mark.parametrize(
    "method", [Direct(LM(screening=50, starts=2)), KSMEA(NoSurrogate(), DE(generations=2), 10, max_updates=2)]
)
def test_the_count_is_what_our_methods_say_and_what_the_problem_was_asked(rotor, method):
    problem, measurement = Counted(rotor), measured(rotor)
    said = method.identify(problem, measurement, streams())
    assert problem.agrees_with(said) and said.model_evaluations > 0
    record = identification(
        Case(rotor, measurement), method, streams(), IdentificationOptions(intervals="none", crlb=False)
    )
    assert (record.model_evaluations, record.model_jacobians) == (said.model_evaluations, said.model_jacobians)
    assert np.array_equal(record.x, said.x)


def test_intervals_and_crlb_belong_to_the_data(rotor):
    measurement = measured(rotor)
    record = identification(Case(rotor, measurement), Finds(1.01 * TRUTH), STREAMS)
    assert record.intervals.level == 0.95 and not record.intervals.noise.estimated
    assert record.intervals.model_jacobians > 0 and np.isfinite(record.deviance)
    told = identifiability(rotor, record.values, Noise(0.05, 0.0), "complex")
    for part, crlb, true in zip(record.parameters, told.crlb, TRUTH):
        assert part.crlb == pytest.approx(crlb)
        assert part.low < part.most_likely < part.high
        assert abs(part.most_likely - true) < 4 * crlb  # the nearest maximum, not where the method ended
        assert (part.high - part.low) / 2 == pytest.approx(1.96 * crlb, rel=0.2)
    assert as_array(record.correlation) == pytest.approx(told.correlation)


def test_details_describe_the_data_and_test_the_fit(rotor):
    measurement = measured(rotor, None)
    rng = np.random.default_rng(3)
    record = detailed_identification(Case(rotor, measurement), Finds(TRUTH), STREAMS, rng, DETAILS, remarks=("a note",))
    assert record.data.n_speed == len(rotor.speed) and record.data.remarks == ("a note",)
    assert record.intervals.noise.estimated and record.intervals.noise.relative == pytest.approx(0.05, rel=0.2)
    assert 0 < record.lack_of_fit.p <= 1 and not record.lack_of_fit.rejected
    response = rotor.response(record.values[None])[0]
    assert as_array(record.fit.fitted.amplitude) == pytest.approx(np.abs(response), rel=1e-7)
    assert as_array(record.fit.measured.phase) == pytest.approx(np.angle(measurement.values), rel=1e-7)
    assert set(np.round(rotor.speed, 4)) <= set(np.round(as_array(record.fit.fine.speed), 4))
    assert np.shape(record.fit.sd) == response.shape
    assert IdentificationRecord.from_data(record.to_data()) == record


@pytest.mark.parametrize("end", [1.02 * TRUTH, np.array([25e6, 90e6, 900.0, 100.0, 4e-4])])
def test_value_interval_and_noise_belong_to_one_maximum_wherever_the_method_ended(rotor, end):
    measurement = measured(rotor, None)
    record = detailed_identification(Case(rotor, measurement), Finds(end), STREAMS, np.random.default_rng(3), DETAILS)
    likelihood = Likelihood(Model(rotor), measurement)
    best = nearest_maximum(likelihood, rotor.parameters.to_cube(TRUTH))  # the data are good: it is the truth's
    # Searches end where the deviance falls by less than 1e-7: to 3e-4 of a standard deviation.
    assert record.values == pytest.approx(rotor.parameters.to_si(best.theta[:5]), rel=1e-5)
    assert record.deviance == pytest.approx(best.deviance, abs=1e-6)
    assert record.x == pytest.approx(end) and record.ended_short and record.search_excess > 10
    for part in record.parameters:
        assert part.low < part.value < part.high and not part.at_limit
    # The likelihood's noise, corrected for the degrees of freedom that the fit took.
    left = (likelihood.n_residual - 5) / likelihood.n_residual
    assert record.intervals.noise.relative * np.sqrt(left) == pytest.approx(likelihood.noise(best.theta).relative, 1e-4)


@pytest.mark.parametrize(("few", "searched"), [(identify.FEW_DATA, True), (0, False)])
def test_where_data_are_few_all_of_the_box_is_searched(monkeypatch, few, searched):
    """48 real numbers for five unknowns and two levels of noise are fewer than ten for each."""
    monkeypatch.setattr(identify, "FEW_DATA", few)
    rotor = ThreeDisk(n_speed=12).build()
    measurement = measured(rotor, None)
    record = identification(Case(rotor, measurement), Finds(np.array([95e6, 95e6, 20.0, 20.0, 1e-4])), STREAMS)
    best = nearest_maximum(Likelihood(Model(rotor), measurement), rotor.parameters.to_cube(TRUTH))
    assert (record.deviance < best.deviance + 0.01) == searched


def test_identification_and_diagnosis_tell_the_same_of_the_same_data(rotor):
    measurement = measured(rotor, None)
    rng = np.random.default_rng
    found = detailed_identification(Case(rotor, measurement), Finds(1.02 * TRUTH), STREAMS, rng(3), DETAILS)
    effects = {name: registry.create("effect", name, {}) for name in ("runout", "probe_rotation")}
    told = diagnosis(Case(rotor, measurement), effects, rng(4))
    for part, other in zip(found.parameters, told.coefficients):
        before = other.before
        # Both searches end within 3e-4 of a standard deviation, ends of intervals within 0.003 of their half-width.
        assert part.in_unit(part.value) == pytest.approx(before.value, rel=1e-4)
        assert [part.in_unit(part.low), part.in_unit(part.high)] == pytest.approx([before.low, before.high], rel=1e-2)
        assert before.low < before.value < before.high
    noise = found.intervals.noise
    assert (noise.relative, noise.floor) == pytest.approx((told.noise.before.relative, told.noise.before.floor), 1e-3)


def test_curves_hold_no_truth(rotor):
    measurement = measured(rotor, kind="amplitude")
    record = identification(
        Case(rotor, measurement),
        Finds(TRUTH),
        STREAMS,
        IdentificationOptions(intervals="none", crlb=False, curves=True),
    )
    assert as_array(record.curves.measured) == pytest.approx(measurement.values, rel=1e-7)
    assert record.curves.true is record.curves.predicted is record.curves.modelled is None


def test_without_noise_there_are_neither_intervals_nor_crlb(rotor):
    values = np.abs(rotor.response(TRUTH[None])[0])
    exact = Measurement(rotor.speed, rotor.channels, values, Noise(0.0, 0.0), "test")
    record = identification(Case(rotor, exact), Finds(TRUTH), STREAMS)
    assert record.intervals is record.correlation is record.interval_error is None


def test_what_cannot_be_computed_is_said(rotor, monkeypatch):
    def singular(*arguments, **settings):
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr("ksmea.studies.identify.estimate", singular)
    monkeypatch.setattr("ksmea.studies.identify.identifiability", singular)
    record = identification(Case(rotor, measured(rotor)), Finds(TRUTH), STREAMS)
    assert record.interval_error == "Singular matrix" and record.intervals is record.deviance is None
    assert record.x == pytest.approx(TRUTH) and record.correlation is None


class Turned(Problem):
    """One angle that is free to turn; the response leads by it."""

    def __init__(self):
        self.parameters = Parameters((Parameter("phase", "deg", np.pi / 180, -1.5 * np.pi, 1.5 * np.pi),))
        self.speed, self.channels = np.linspace(1.0, 2.0, 5), (Channel(0.0, "x"),)

    def response(self, x):
        return 1e-6 * np.exp(1j * x[:, :, None]) * np.ones((1, 5, 1))


def test_angles_are_told_within_a_turn_and_the_truth_beside_them():
    problem = Turned()
    measurement = Measurement(problem.speed, problem.channels, problem.response(np.array([[3.0]]))[0], None, "test")
    found = identification(
        Case(problem, measurement),
        Finds(np.radians([190.0])),
        STREAMS,
        IdentificationOptions(intervals="none", crlb=False),
    ).with_truth(problem.parameters, {"phase": np.radians(170.0)})
    assert found.parameters[0].in_unit(found.parameters[0].identified) == pytest.approx(-170.0)
    assert found.parameters[0].in_unit(found.parameters[0].true) == pytest.approx(-190.0)


def test_settings_that_cannot_be_are_refused_before_anything_is_computed(rotor):
    method = Finds(TRUTH)
    with pytest.raises(SettingError) as caught:
        identification(Case(rotor, measured(rotor)), method, STREAMS, IdentificationOptions(intervals="bayes"))
    assert "intervals: expected profile | information | none, got 'bayes'" in str(caught.value) and method.seen == ()


def test_values_that_are_not_finite_are_an_error(rotor):
    with pytest.raises(ArithmeticError, match="not finite"):
        identification(Case(rotor, measured(rotor)), Finds(np.full(5, np.nan)), STREAMS)
