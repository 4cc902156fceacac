"""Equivalents of a pair: one effect that makes the change of both, another pair, idle effects."""

from types import SimpleNamespace

import numpy as np
import pytest

from ksmea.diagnosis.equivalents import _of_pairs, alone_in_place_of, pairs_in_place_of
from ksmea.diagnosis.trials import Candidate, Explanation, trial_of
from ksmea.fits.fitting import Fit, fit_from_values, fit_nearby
from ksmea.fits.search import Search
from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from problems.three_disk import ThreeDisk
from tests.diagnosis.conftest import SENSORS, TRUTH

NOISE = Noise(0.03, 2e-8)
PLANE = 0.2  # m


def gain(direction=None, position=PLANE):
    effect = registry.create("effect", "channel_gain", {"position": position, "direction": direction})
    return Candidate("channel_gain", effect)


def candidate(name, place=0):
    return Candidate(name, list(registry.create("effect", name, {}).locations(rotor()))[place])


def rotor():
    return ThreeDisk(sensors=SENSORS, n_speed=27).build().with_phase_origin()


@pytest.fixture(scope="module")
def fits():
    """The baseline model fitted to data that hide gains, and a model with candidates fitted from values of theirs."""

    def of(hidden, values):
        fine = ThreeDisk(mesh=26, sensors=SENSORS, n_speed=27).build().with_phase_origin()
        for each in hidden:
            fine = each.effect.added_to(fine)
        truth = np.array([TRUTH[name] for name in rotor().parameters.names])
        response = fine.dense_response(np.append(truth, values)[None])[0]
        data = observe(response, "complex", NOISE, np.random.default_rng(3))
        case = Case(rotor(), Measurement(fine.speed, fine.channels, data, NOISE, "made"))
        baseline = fit_from_values(case, truth)

        def fit(candidates, sizes):
            problem = case.problem
            for each in candidates:
                problem = each.effect.added_to(problem)
            return fit_from_values(case.by(problem), np.append(truth, sizes))

        return baseline, fit

    return of


def pair_of(first, second, baseline, fit, sizes, n=9):
    """The explanation by two candidates with sizes near those given, and the trial of the first alone."""
    alone = trial_of(first, fit([first], sizes[:1]), baseline, n)
    return Explanation.of_pair(alone, trial_of(second, fit([first, second], sizes), alone.fit, n)), alone


def low(trial, baseline):
    """A trial whose fit was left where the effect does nothing."""
    start = fit_nearby(trial.fit.problem, baseline, max_iterations=0)
    return trial_of(trial.candidate, Fit(start.likelihood, start.point), baseline, 9)


def test_gains_of_both_channels_of_a_plane_are_one_gain_of_the_plane(fits):
    """The pair stands beside no trial of the plane's gain that comes as near: that was left where it does nothing."""
    baseline, fit = fits([gain()], [0.2])
    x, y, plane = gain("x"), gain("y"), gain()
    pair, of_x = pair_of(x, y, baseline, fit, [0.2, 0.2])
    right = trial_of(plane, fit([plane], [0.2]), baseline, 9)
    mass = trial_of(candidate("mass"), fit([candidate("mass")], [0.0]), baseline, 9)
    assert not Explanation.of(low(right, baseline)).is_near(pair)
    found = alone_in_place_of(pair, [of_x, mass, low(right, baseline)], baseline, Search(np.random.default_rng(0)))
    best = found[0]
    assert best.candidate == plane and best.fit.deviance == pytest.approx(right.fit.deviance, abs=0.1)
    assert abs(best.fit.x[-1] - 0.2) < 0.05  # of 27 speeds with 3 %: a standard error is 0.005
    assert best.delta_bic > pair.delta_bic  # one unknown fewer
    assert alone_in_place_of(pair, [of_x, mass, right], baseline, Search(np.random.default_rng(0))) == []


def test_a_mass_beside_a_gain_is_found_where_a_modulus_beside_it_was(fits):
    baseline, fit = fits([candidate("mass"), gain("x")], [0.01, 0.2])
    modulus, mass, x = candidate("youngs_modulus"), candidate("mass"), gain("x")
    pair, of_modulus = pair_of(modulus, x, baseline, fit, [-0.01, 0.2])
    trials = [
        of_modulus,
        *(trial_of(each, fit([each], [size]), baseline, 9) for each, size in ((mass, 0.01), (x, 0.2))),
        trial_of(candidate("runout"), fit([candidate("runout")], [0.0, 0.0]), baseline, 9),
    ]
    [other] = pairs_in_place_of(pair, trials, [], baseline, Search(np.random.default_rng(0)))
    assert other.names == ("channel_gain", "mass")
    assert other.deviance_drop == pytest.approx(pair.deviance_drop, abs=1.0)  # both predict the same
    assert pairs_in_place_of(pair, trials, [other], baseline, Search(np.random.default_rng(0))) == []


def test_cosines_of_pairs_are_those_of_least_squares():
    rng = np.random.default_rng(1)
    bases = [np.linalg.qr(rng.standard_normal((20, n)))[0] for n in (1, 2, 3)]
    bases.append(bases[1])  # two that can do one thing
    change = rng.standard_normal(20)
    for (one, other), cosine in _of_pairs(change, bases).items():
        both = np.hstack([bases[one], bases[other]])
        left = change - both @ np.linalg.lstsq(both, change)[0]
        assert cosine == pytest.approx(np.sqrt(1 - (np.linalg.norm(left) / np.linalg.norm(change)) ** 2), abs=1e-7)


[GAIN] = candidate("channel_gain").effect.parameters(rotor())
NO_GAIN = -GAIN.lower / (GAIN.upper - GAIN.lower)  # in the unit cube


def explained(*names, u):
    """An explanation whose effects have values u in the unit cube."""
    applied, problem = tuple(map(candidate, names)), rotor()
    for each in applied:
        problem = each.effect.added_to(problem)
    fit = SimpleNamespace(problem=problem, u=np.append(np.full(len(problem.parameters) - len(u), 0.5), u))
    return Explanation(applied, fit, 100.0, 50.0, len(u), 0.0)


@pytest.mark.parametrize(
    ("u", "has"),
    [
        ([0.6, 0.7, 0.6], True),
        ([NO_GAIN, 0.7, 0.6], False),
        ([1.0, 0.7, 0.6], False),  # on its limit
        ([0.6, 0.7, 0.0], False),  # a block without a mass
        ([0.6, 0.0, 0.6], False),
    ],
)
def test_an_effect_without_a_size_within_its_limits_is_no_partner(u, has):
    assert explained("channel_gain", "foundation_resonance", u=np.array(u)).has_sizes is has
