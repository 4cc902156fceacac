"""Springs with mass: an absorber on the shaft holds it at its own frequency, and a mass of all bearings is their inertia."""

import dataclasses

import numpy as np
import pytest

from ksmea.measurement.channel import Channel
from ksmea.plugins import registry
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk

SETTINGS = ThreeDisk(sensors=[0.1, 0.5], n_speed=16)
PLAIN = SETTINGS.build()
TRUTH = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])


def effect(name, **settings):
    return registry.create("effect", name, settings)


def response(name, theta, problem=PLAIN, **settings):
    return effect(name, **settings).added_to(problem).response(np.concatenate([TRUTH, theta])[None])[0]


def test_an_undamped_absorber_holds_its_place_at_its_own_frequency():
    """Den Hartog 1956, section 3.2: the shaft stands still there, however small the mass is."""
    speed = np.array([600.0, 900.0])
    problem = PLAIN.at(speed, [Channel(1.0, "x"), Channel(0.1, "x")])
    held = np.abs(response("spring_mass", [0.5, 600.0, 1e-9], problem, position=1.0))
    free = np.abs(problem.response(TRUTH[None])[0])
    assert held[0, 0] < 1e-6 * free[0, 0] and held[0, 1] > 1e-3 * free[0, 1]


def test_far_below_its_frequency_it_is_an_added_mass():
    mass, natural = 2.0, 100 * float(np.max(PLAIN.speed))
    local = effect("local_force", law="spring_mass", position=0.5)
    assert [item.name for item in local.parameters(PLAIN)] == ["local_m", "local_f_0", "local_damping_ratio"]
    found = local.added_to(PLAIN).response(np.concatenate([TRUTH, [mass, natural, 0.01]])[None])[0]
    expected = response("added_mass", [mass], position=0.5)
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()  # needles magnify 1e-4, the stiffening


def test_a_mass_of_all_bearings_is_their_inertia_in_response_and_in_growth():
    rotor = rotor_at(PLAIN.rotor, PLAIN.unknowns, TRUTH)
    bearings = tuple(dataclasses.replace(each, mxx=3.0, myy=5.0) for each in rotor.bearings)
    unbalance = tuple(item for item in PLAIN.unknowns if item.parameter.name == "u")
    heavy = dataclasses.replace(PLAIN, rotor=dataclasses.replace(rotor, bearings=bearings), unknowns=unbalance)
    expected = heavy.response(TRUTH[None, -1:])[0]
    assert np.abs(response("bearing_mass", [3.0, 5.0]) - expected).max() < 1e-8 * np.abs(expected).max()
    problem, x = effect("bearing_mass").added_to(PLAIN), np.concatenate([TRUTH, [3.0, 5.0]])
    speed = np.linspace(100, 1500, 5)
    assert problem.growth_rate(x, speed) == pytest.approx(heavy.growth_rate(TRUTH[-1:], speed), rel=1e-3)
    criticals = heavy.critical_speeds(TRUTH[-1:], 1500.0)
    assert problem.critical_speeds(x, 1500.0) == pytest.approx(criticals, rel=1e-6)
