"""One rotor problem: with no effects it is the plain rotor, and it shares with every rotor with effects what is computed of it."""

import dataclasses
import pickle

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.measurement.campaign import Run
from ksmea.plugins.registry import create
from ksmea.problem.load import Load
from problems.rotor.extension.extended import ExtendedPhysics
from problems.rotor.response.unknowns import Inputs
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.9], n_speed=11).build()
X = PROBLEM.parameters.to_si(np.array([[0.2, 0.4, 0.3, 0.7, 0.5], [0.9, 0.1, 0.5, 0.2, 0.3]]))
SPEED = np.linspace(100.0, 1600.0, 7)
LOADS = (Load(0.5, "x", "force"),)
RUNOUT = create("effect", "runout", {"position": 0.1})


def gap(found, expected):
    return np.max(np.abs(found - expected)) / np.max(np.abs(expected))


def test_the_physics_of_effects_without_any_is_that_of_the_plain_rotor():
    """Two routes of one motion: what is left between them is rounding, and differences in the place of derivatives."""
    none, plain = ExtendedPhysics(PROBLEM, ()), PROBLEM.physics
    assert gap(none.response(X), plain.response(X)) < 1e-9
    assert gap(none.load_response(X, LOADS), plain.load_response(X, LOADS)) < 1e-9
    assert gap(none.dense_response(X), plain.dense_response(X)) < 1e-9
    for found, expected in zip(none.linearised(X[0]), plain.linearised(X[0])):
        assert gap(found, expected) < 1e-6
    one, other = (physics.free_motion(X[0], 1600.0, 30) for physics in (none, plain))
    assert one.frequencies(SPEED) == pytest.approx(other.frequencies(SPEED), rel=1e-7)
    assert one.growth_rate(SPEED) == pytest.approx(other.growth_rate(SPEED), rel=1e-6)
    assert one.is_passive(SPEED) and other.is_passive(SPEED)
    assert none.unbalance(X[0]) == plain.unbalance(X[0]) and none.parameters == plain.parameters


def test_effects_may_be_given_with_the_rotor_or_added_to_it():
    added = RUNOUT.added_to(PROBLEM)
    given = dataclasses.replace(PROBLEM, effects=(RUNOUT,))
    x = np.hstack([X, [[1e-6, 2e-6], [0.0, 3e-6]]])
    np.testing.assert_array_equal(given.response(x), added.response(x))
    assert given.parameters == added.parameters and added.parameters.names[5:] == ("runout_x", "runout_y")
    assert PROBLEM.effects == () and PROBLEM.plain is PROBLEM and added.plain is PROBLEM


def test_a_changed_rotor_keeps_its_effects():
    x = np.append(X[0], [1e-6, 2e-6])[None]
    bowed = RUNOUT.added_to(PROBLEM)
    seen = bowed.at(PROBLEM.speed[:3], PROBLEM.channels[:1])
    assert seen.effects == bowed.effects and gap(seen.response(x)[0, :, 0], bowed.response(x)[0, :3, 0]) < 1e-9
    weighted = bowed.with_unbalance(0.5, 1e-4, 0.3)
    expected = PROBLEM.with_unbalance(0.5, 1e-4, 0.3).response(X[:1]) + bowed.response(x) - PROBLEM.response(X[:1])
    assert gap(weighted.response(x), expected) < 1e-9
    assert bowed.with_phase_origin().parameters.names == (
        *PROBLEM.parameters.names,
        "phase_origin",
        "runout_x",
        "runout_y",
    )


def test_a_rotor_without_effects_goes_as_it_is():
    assert PROBLEM.going(Run("", 1, direction="down")) is PROBLEM and PROBLEM.next_to(np.zeros((11, 2))) is PROBLEM


def test_a_rotor_with_effects_can_be_sent_to_workers():
    x = np.append(X[0], [1e-6, 2e-6])[None]
    bowed = RUNOUT.added_to(PROBLEM)
    before = pickle.loads(pickle.dumps(bowed)).response(x)
    np.testing.assert_array_equal(before, bowed.response(x))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(bowed)).response(x), before)


def test_bearings_that_change_with_speed_enter_at_one_place(monkeypatch):
    """As coefficients given over speed would: the plain rotor then moves like the one with the effect.

    Its response is by updates: a polynomial has the impedances of the unknowns in its coefficients.
    """
    slope, full = 0.3, float(PROBLEM.speed[-1])
    sloped = create("effect", "speed_dependent_stiffness", {}).added_to(PROBLEM)
    x, at_rest = np.hstack([X, [[slope], [slope]]]), Inputs.bearings_at
    expected = sloped.response(x), sloped.load_response(x, LOADS), sloped.growth_rate(x[0], SPEED)
    frequencies = sloped.free_rotor(x[0], 1600.0).frequencies(SPEED)

    def rising(inputs, speed):
        stiffness, damping, mass = at_rest(inputs, speed)
        return stiffness * (1 + slope * speed / full), damping, mass

    monkeypatch.setattr(Inputs, "bearings_at", rising)
    found = PROBLEM.physics._by_updates(X), PROBLEM.load_response(X, LOADS), PROBLEM.growth_rate(X[0], SPEED)
    assert all(gap(one, other) < 1e-8 for one, other in zip(found, expected))
    assert PROBLEM.free_rotor(X[0], 1600.0).frequencies(SPEED) == pytest.approx(frequencies, rel=1e-8)


def test_an_effect_of_readings_leaves_the_modes_alone():
    assert len(PROBLEM.critical_speeds(X[0]))
    found = RUNOUT.added_to(PROBLEM).campbell(np.append(X[0], [0.0, 0.0]), SPEED)
    # 1e-5: how far modes in a reduced space are true
    assert found.frequency[:, :2] == pytest.approx(PROBLEM.campbell(X[0], SPEED).frequency[:, :2], rel=1e-5)


def test_two_effects_that_are_the_same_are_refused_when_they_are_added():
    with pytest.raises(SettingError, match="expected each unknown once, got runout_x again"):
        RUNOUT.added_to(RUNOUT.added_to(PROBLEM))
