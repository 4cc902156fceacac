"""Sizes of hidden effects: as large as the response, never so large that the rotor is unstable; others are refused."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.inference.maximisation import maximise
from ksmea.likelihood.fisher import projected, whitened_sensitivity
from ksmea.likelihood.likelihood import Likelihood
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.measurement.observable import Observable
from ksmea.plugins import registry
from ksmea.problem.counted import Model
from measurements.hidden_size import NOTICED, drawn_size, relative_change, size_of_drop
from measurements.synthetic import Synthetic
from problems.rotor.extension.effect import RotorEffect
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.2, 0.5], n_speed=27)
PLAIN = PROBLEM.build()
TRUTH = PROBLEM.reference()
X = np.array([TRUTH[name] for name in PLAIN.parameters.names])
COMPLEX = Observable.COMPLEX
# What these change stays small up to their physical limits or to where the rotor becomes unstable: one channel of six
# that reads 30 % too much is a tenth of the whole.
LIMITED = (
    "channel_gain", "cross_coupling_antisymmetric", "internal_damping", "probe_rotation", "speed_dependent_damping",
)  # fmt: skip
SLIGHT = ("disk_inertia", "probe_position")  # within the limits of a drawing


NONLINEAR = ("bilinear_stiffness", "clearance_rub", "cubic_stiffness")  # drawn for a second or more


def placed(name):
    return registry.create("effect", name, {}).locations(PLAIN)[0]


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name in NONLINEAR))
        for name in registry.registered("effect")
        if name != "local_force"
    ],
)
def test_what_a_drawn_effect_changes_is_of_the_size_of_the_response_and_the_rotor_is_stable(name):
    effect = placed(name)
    extended = effect.added_to(PLAIN)
    for seed in range(3):
        theta = drawn_size(effect, PLAIN, X, COMPLEX, np.random.default_rng(seed))
        x = np.concatenate([X, theta])
        assert extended.is_stable(x)
        assert all(item.lower <= value <= item.upper for item, value in zip(effect.parameters(PLAIN), theta))
        change = relative_change(PLAIN, extended, X, x[None], COMPLEX)[0]
        # 0.7: sizes that are looked at are a third apart, and the one below what is wanted is taken
        least = 0.002 if name in SLIGHT else 0.02 if name in LIMITED else NOTICED[0]
        assert 0.7 * least < change <= NOTICED[1]


@dataclasses.dataclass(frozen=True)
class Loud(RotorEffect):
    """An effect of someone else that draws as much as its limits let it."""

    def parameters(self, problem):
        return placed("residual_bow").parameters(problem)

    def draw(self, problem, rng):
        return np.array([self.parameters(problem)[0].upper, 0.0])

    def observed(self, response, channels, speed, theta):
        return response + theta[:, :1, None]


def test_a_draw_that_is_of_the_size_of_the_response_is_kept():
    effect = placed("mass")
    [theta] = drawn_size(effect, PLAIN, X, COMPLEX, np.random.default_rng(0))
    assert theta == effect.draw(PLAIN, np.random.default_rng(0))[0]


def test_an_effect_of_someone_else_is_scaled_too():
    theta = drawn_size(Loud(), PLAIN, X, COMPLEX, np.random.default_rng(0))
    rms = np.sqrt(np.mean(np.abs(PLAIN.response(X[None])) ** 2))
    # a constant addition is linear in its size, so that its rms is its size
    assert 0.7 * NOTICED[0] < theta[0] / rms <= NOTICED[1] and theta[1] == 0


def test_what_the_data_cannot_see_keeps_its_size():
    """A turned origin of all phases shows in no amplitude, whatever its size."""

    class Unseen(Loud):
        def observed(self, response, channels, speed, theta):
            return response * np.exp(1j * theta[:, :1, None] / 1e-4)

    theta = drawn_size(Unseen(), PLAIN, X, Observable.AMPLITUDE, np.random.default_rng(0))
    assert theta[0] == Unseen().draw(PLAIN, None)[0]


def test_all_draws_of_several_effects_together_are_stable():
    hiding = Synthetic(kind="complex", hidden=["cross_coupling_antisymmetric", "internal_damping", "flexible_pedestal"])
    for seed in range(3):
        problem, theta = hiding.with_hidden(PROBLEM, PLAIN, np.random.default_rng(seed))
        assert problem.is_stable(np.concatenate([X, theta]))


@pytest.mark.parametrize(
    "settings, message",
    [
        (
            {"hidden": ["cross_coupling_antisymmetric"], "sizes": {"kxy_antisymmetric": 1.0}},
            "measurement.sizes: expected a rotor that is stable up to its highest measured speed, 14324 rpm,"
            + " got one whose free motions grow from 1014 rpm, without a steady response; give other values",
        ),
        (
            {"truth": {"cxx": -0.1}},
            "measurement.truth: expected a rotor that is stable up to its highest measured speed, 14324 rpm,"
            + " got one whose free motions grow from rest",
        ),
    ],
)
def test_an_unstable_rotor_makes_no_data(settings, message):
    with pytest.raises(SettingError) as caught:
        Synthetic(kind="complex", **settings).true_values(PROBLEM)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_a_size_that_leaves_the_rest_no_room_is_refused_after_some_draws():
    sizes = {"kxy_antisymmetric": 5.0}
    with pytest.raises(SettingError, match="got none in 20 draws; give measurement"):
        Synthetic(hidden=["cross_coupling_antisymmetric", "runout"], sizes=sizes).true_values(PROBLEM)


@pytest.mark.parametrize("name", ["runout", "unbalance", "speed_dependent_stiffness"])
def test_a_size_of_a_deviance_drop_is_that_of_the_sensitivities_where_the_effect_is_small(name):
    noise, wanted = Noise(0.05, 1e-7), 40.0
    effect = placed(name)
    theta = size_of_drop(effect, PLAIN, X, wanted, noise, COMPLEX, np.random.default_rng(1))
    response, sensitivity = effect.added_to(PLAIN).linearised(np.concatenate([X, 0 * theta]))
    columns = np.append(PLAIN.parameters.width, theta)
    whitened = whitened_sensitivity(response, sensitivity * columns, noise, COMPLEX)
    left = projected(whitened[:, len(X) :].sum(axis=1, keepdims=True), whitened[:, : len(X)])
    # 20 %: the response is not quite linear in the effect, and the fit has its variance from its own response
    assert np.sum(left**2) == pytest.approx(wanted, rel=0.2)


@pytest.mark.parametrize("name", ["flexible_pedestal", "mass"])
def test_a_size_of_a_deviance_drop_holds_where_sensitivities_do_not(name):
    noise, effect = Noise(0.05, 1e-7), placed(name)
    small, large = (
        size_of_drop(effect, PLAIN, X, drop, noise, COMPLEX, np.random.default_rng(1)) for drop in (10, 1e4)
    )
    assert np.linalg.norm(large) > 1.5 * np.linalg.norm(small)
    response = effect.added_to(PLAIN).response(np.concatenate([X, large])[None])[0]
    likelihood = Likelihood(Model(PLAIN), Measurement(PLAIN.speed, PLAIN.channels, response, noise, ""))
    fits = [maximise(likelihood, PLAIN.parameters.to_cube(X * factor)) for factor in (1.0, 1.01, 0.99)]
    absent = effect.added_to(PLAIN)
    best = Likelihood(Model(absent), Measurement(PLAIN.speed, PLAIN.channels, response, noise, ""))
    drop = min(fit.deviance for fit in fits) - best.deviance(absent.parameters.to_cube(np.concatenate([X, large])))
    assert drop > 1e4 / 2  # no fit nearby explains half of what the size was drawn for


def test_a_size_of_a_deviance_drop_ends_where_the_rotor_becomes_unstable():
    effect = placed("internal_damping")
    theta = size_of_drop(effect, PLAIN, X, 1e6, Noise(0.05, 1e-7), COMPLEX, np.random.default_rng(1))
    extended = effect.added_to(PLAIN)
    assert extended.is_stable(np.concatenate([X, theta]))
    assert not extended.is_stable(np.concatenate([X, 1.1 * theta]))


def test_a_deviance_drop_without_noise_is_refused():
    with pytest.raises(SettingError, match="expected_drop: expected noise"):
        Synthetic(kind="complex", hidden=["runout"], expected_drop=60.0)


def test_a_deviance_drop_of_nothing_is_refused():
    with pytest.raises(SettingError, match="expected_drop: expected hidden effects"):
        Synthetic(kind="complex", relative=0.05, expected_drop=60.0)


def test_stated_noise_is_what_the_fit_is_told_and_not_what_is_drawn():
    settings = {"kind": "complex", "relative": 0.06, "floor": 0.1}
    draw = lambda data: data.measure(PROBLEM, TRUTH, np.random.default_rng(1), np.random.default_rng(2))
    right, wrong = draw(Synthetic(**settings)), draw(Synthetic(**settings, stated=0.5))
    assert np.array_equal(right.values, wrong.values)
    assert wrong.noise.levels == ((0.03, pytest.approx(0.05e-6)),)
