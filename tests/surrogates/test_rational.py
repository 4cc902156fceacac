"""The rational surrogate is the response itself of linear rotors, from as many samples as it has coefficients, and says so where
it cannot be."""

import dataclasses
import pickle

import numpy as np
import pytest

from counted_runs import measured, streams
from ksmea.errors import SettingError
from ksmea.identification.ksmea import KSMEA, structure_of
from ksmea.identification.true_model import model_objective
from ksmea.inference.cramer_rao import identifiability
from ksmea.likelihood.misfit import Misfit
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.numerics.least_squares import descend
from ksmea.numerics.screening import latin_hypercube
from ksmea.plugins.registry import create
from ksmea.plugins.surrogate import Unsuited
from ksmea.plugins.transforms import Transform
from ksmea.problem.case import Case
from ksmea.problem.counted import CountedProblem, Model
from ksmea.problem.problem import Problem
from ksmea.problem.response_structure import UnknownImpedance
from ksmea.records.identification import IdentificationRecord
from ksmea.show.identification_text import text
from ksmea.studies.identify import IdentificationOptions, identification
from optimizers.lm import LM
from problems.rk4_two_disk import RK4TwoDisk
from problems.rotor.response.unknowns import BearingTarget, Unknown
from problems.three_disk import ThreeDisk
from surrogates.kriging import Kriging
from surrogates.rational import Rational
from tiers import mostly_slow

PLAIN = ThreeDisk().build()
REFERENCE = np.array(list(ThreeDisk().reference().values()))
NO_NOISE = Noise(0.0, 0.0)
ROUNDING = 1e-6  # the largest of hundreds of relative errors was 4e-7 in designs of as many samples as are needed


def with_unequal_bearings(problem):
    """Each bearing with four coefficients of its own."""
    unknowns = []
    for item in problem.unknowns:
        for number, target in enumerate(item.targets, start=1):
            is_bearing = isinstance(target, BearingTarget)
            name = f"{item.parameter.name}{number}" if is_bearing else item.parameter.name
            unknowns.append(Unknown(dataclasses.replace(item.parameter, name=name), (target,)))
    return dataclasses.replace(problem, unknowns=tuple(unknowns))


PROBLEMS = {  # with the samples needed: (terms (loads · channels + 1) − 1) / channels, rounded up
    "two impedances of two ports each: 9 terms": (PLAIN, 13),
    "another mesh": (ThreeDisk(mesh=21).build(), 13),
    "one channel": (ThreeDisk(directions=["x"]).build(), 17),
    "three planes": (ThreeDisk(sensors=[0.1, 0.5, 1.0]).build(), 11),
    "four impedances of one port each: 16 terms": (with_unequal_bearings(PLAIN), 24),
    "unbalance with phases on two disks, one channel": (RK4TwoDisk().build(), 26),
    "a known unbalance besides, which makes two loads": (PLAIN.with_unbalance(1.0, 1e-4, 0.3), 22),
    "an unknown phase origin": (PLAIN.with_phase_origin(), 13),
}


def structured(problem, **settings):
    return Rational(**settings).with_structure(structure_of(problem))


def outputs_of(problem):
    return Transform("complex", Observable.COMPLEX, len(problem.speed), len(problem.channels))


def sampled(problem, n, seed=0):
    u = latin_hypercube(n, len(problem.parameters), np.random.default_rng(seed))
    return u, outputs_of(problem).encode(problem.response(problem.parameters.to_si(u)))


def fitted(problem, n, seed=0, **settings):
    return structured(problem, **settings).fit(*sampled(problem, n, seed), np.random.default_rng(0))


def errors(problem, predictor):
    """Relative, of responses all over the box."""
    u = np.random.default_rng(99).random((300, len(problem.parameters)))
    true = problem.response(problem.parameters.to_si(u))
    return np.abs(outputs_of(problem).decode(predictor.predict(u)) / true - 1)


@pytest.mark.parametrize("name", PROBLEMS)
def test_as_many_samples_as_coefficients_make_it_the_response_itself(name):
    problem, least = PROBLEMS[name]
    assert structured(problem, fallback="stop").least_samples(len(problem.parameters)) == least
    assert np.max(errors(problem, fitted(problem, least))) < ROUNDING


def test_fewer_samples_do_not_determine_it():
    """24 equations for 26 coefficients: said so, where a degree that is stated too low lets 12 samples through they are wrong."""
    with pytest.raises(SettingError, match="expected 13 samples or more, got 12"):
        fitted(PLAIN, 12)


@pytest.mark.parametrize("seed", range(5))
def test_left_out_samples_show_that_it_is_exact(seed):
    """Of 14 samples each is predicted by the other 13."""
    predictor = fitted(PLAIN, 14, seed)
    assert predictor.notes["left_out_error"] < ROUNDING
    # and tell of the error all over the box, within the factor of ten that the place of a sample makes
    typical = np.median(np.abs(outputs_of(PLAIN).decode(sampled(PLAIN, 14, seed)[1])))
    assert np.max(predictor.leave_one_out()) < ROUNDING * 100 * typical


def test_without_samples_to_leave_out_it_claims_no_error():
    predictor = fitted(PLAIN, 13)
    assert predictor.leave_one_out() is None and not predictor.notes


def test_a_surrogate_with_a_structure_and_its_predictor_can_be_sent_to_another_process():
    predictor = fitted(PLAIN, 13)
    again = pickle.loads(pickle.dumps(predictor))
    u = np.random.default_rng(1).random((3, 5))
    assert np.array_equal(again.predict(u), predictor.predict(u))


class Hardened(Problem):
    """A black box that claims to be linear, and whose bearings stiffen with the motion."""

    unknown_impedances = PLAIN.unknown_impedances

    def __init__(self, base, stiffening):
        self._extended, self._stiffening = create("effect", "cubic_stiffness", {}).added_to(base), stiffening
        self.parameters, self.speed, self.channels = base.parameters, base.speed, base.channels
        self.unbalance = base.unbalance

    def response(self, x):
        return self._extended.response(np.column_stack([x, np.full(len(x), self._stiffening)]))


FEW_SPEEDS = PLAIN.at(np.array([300.0, 600.0, 900.0]), PLAIN.channels)


def test_a_hidden_nonlinearity_is_told():
    assert fitted(FEW_SPEEDS, 16).notes["left_out_error"] < ROUNDING
    assert fitted(Hardened(FEW_SPEEDS, 0.0), 16).notes["left_out_error"] < ROUNDING
    with pytest.raises(
        Unsuited, match=r"a rational function of kxx, cxx, kyy, cyy, got .* off by 13 % \(tolerance 0.01 %\)"
    ):
        fitted(Hardened(FEW_SPEEDS, 1e13), 16)


def test_a_degree_that_is_stated_too_low_is_told():
    class Understated(CountedProblem):
        unknown_impedances = tuple(dataclasses.replace(item, n_port=1) for item in PLAIN.unknown_impedances)

    with pytest.raises(Unsuited, match="expected a response that is a rational function"):
        fitted(Understated(PLAIN), 13)


def test_noise_in_the_samples_is_told():
    u, y = sampled(PLAIN, 16)
    noisy = y * (1 + 1e-3 * np.random.default_rng(0).standard_normal(y.shape))
    with pytest.raises(Unsuited, match="expected a response that is a rational function"):
        structured(PLAIN).fit(u, noisy, np.random.default_rng(0))


def identified(problem, measurement, samples, seed=0, **settings):
    surrogate = Rational(**settings.pop("surrogate", {}))
    method = KSMEA(surrogate, LM(screening=4000), samples, misfit="likelihood", **settings)
    method.validate(problem)
    return method.identify(problem, measurement, streams(seed))


HARDENED = Hardened(FEW_SPEEDS, 1e13)
HARDENED_DATA = measured(HARDENED, REFERENCE, noise=Noise(0.01, 0.0))


def test_where_it_is_not_rational_another_surrogate_takes_over_and_it_is_said():
    found = identified(HARDENED, HARDENED_DATA, 16, max_updates=1)
    assert len(found.remarks) == 1
    assert "a rational function" in found.remarks[0] and found.remarks[0].endswith("Kriging takes over")
    assert found.model_evaluations == 17 and "nugget" in found.notes


def test_the_report_of_an_identification_says_what_took_over():
    method = KSMEA(Rational(), LM(screening=100, starts=1), 16, max_updates=1)
    record = identification(
        Case(HARDENED, HARDENED_DATA), method, streams(), IdentificationOptions(intervals="none", crlb=False)
    )
    assert "Kriging takes over" in text(IdentificationRecord.from_data(record.to_data()))


def test_an_updating_step_is_the_left_out_sample_where_the_first_fit_has_none():
    found = identified(HARDENED, HARDENED_DATA, 13, max_updates=2, smc=1.0)  # which is never exceeded
    assert found.updates == 2 and found.remarks[0].endswith("Kriging takes over")


def test_where_it_is_not_rational_the_true_model_can_take_over():
    found = identified(HARDENED, HARDENED_DATA, 16, max_updates=1, budget=60, surrogate={"fallback": "none"})
    assert found.remarks[0].endswith("the true model takes over") and found.stop == "budget"


def test_where_it_is_not_rational_the_run_can_stop():
    with pytest.raises(Unsuited, match="take surrogate=kriging"):
        identified(HARDENED, HARDENED_DATA, 16, surrogate={"fallback": "stop"})


@pytest.mark.parametrize("seed", mostly_slow(range(4), but=[0]))
def test_all_five_unknowns_without_noise_from_13_evaluations(seed):
    """Amplitudes of any truth between the limits; no evaluation beside the 13 samples. `benchmarks/rational.py` has 100."""
    problem = CountedProblem(PLAIN)
    truth = PLAIN.parameters.to_si(np.random.default_rng([7, seed]).random(5))
    found = identified(problem, measured(PLAIN, truth, "amplitude"), 13, seed, max_updates=0, budget=13)
    assert np.allclose(found.x, truth, rtol=1e-6, atol=0)
    assert problem.meter.evaluations == found.model_evaluations == 13 and not problem.meter.jacobians
    assert found.stop == "optimizer" and found.updates == 0 and found.modelled is None


@pytest.mark.parametrize("seed", mostly_slow(range(3), but=[0]))
def test_with_noise_it_ends_at_the_maximum_of_the_true_models_likelihood(seed):
    """So that it is as near to the CRLB as any method can be: a hundredth of it is far below what 100 draws could see."""
    noise = Noise(0.1, 0.0)
    measurement = measured(PLAIN, REFERENCE, "amplitude", noise, seed)
    found = identified(PLAIN, measurement, 13, seed, max_updates=0)
    objective = model_objective(Model(PLAIN), Misfit(measurement, "likelihood"))
    descend(objective, PLAIN.parameters.to_cube(found.x), max_iterations=50)
    crlb = identifiability(PLAIN, REFERENCE, noise, Observable.AMPLITUDE, noise_known=True).crlb
    assert np.all(np.abs(found.x - PLAIN.parameters.to_si(objective.result().u)) < 0.01 * crlb)


def test_a_problem_that_tells_of_no_impedances_is_refused():
    class Silent(CountedProblem):
        unknown_impedances = ()

    with pytest.raises(SettingError, match=r"names its `unknown_impedances`.*take surrogate=kriging"):
        KSMEA(Rational(), LM(), 40).validate(Silent(PLAIN))


def test_samples_alone_are_for_its_substitute():
    u = latin_hypercube(12, 2, np.random.default_rng(0))
    y = np.column_stack([u.sum(axis=1), u.prod(axis=1)])
    assert Rational().least_samples(2) == Kriging().least_samples(2)
    expected = Kriging().fit(u, y, np.random.default_rng(0)).predict(u + 0.01)
    assert np.array_equal(Rational().fit(u, y, np.random.default_rng(0)).predict(u + 0.01), expected)
    with pytest.raises(SettingError, match="expected the impedances"):
        Rational(fallback="stop").fit(u, y, np.random.default_rng(0))


def test_impedances_are_pairs_of_unknowns_with_the_ports_that_share_them():
    assert PLAIN.unknown_impedances == (UnknownImpedance("kxx", "cxx", 2), UnknownImpedance("kyy", "cyy", 2))
    unequal = {(item.stiffness, item.damping): item.n_port for item in with_unequal_bearings(PLAIN).unknown_impedances}
    assert unequal == {("kxx1", "cxx1"): 1, ("kyy1", "cyy1"): 1, ("kxx2", "cxx2"): 1, ("kyy2", "cyy2"): 1}
    damping_known = dataclasses.replace(
        PLAIN, unknowns=tuple(item for item in PLAIN.unknowns if item.parameter.name != "cxx")
    )
    assert damping_known.unknown_impedances[0] == UnknownImpedance("kxx", "", 2)


def test_they_are_handed_on_where_nothing_else_acts():
    assert CountedProblem(PLAIN).unknown_impedances == PLAIN.unknown_impedances
    assert create("effect", "residual_bow", {}).added_to(PLAIN).unknown_impedances == ()
