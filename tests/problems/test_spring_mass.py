"""Springs with mass: an absorber on the shaft holds it at its own frequency, and a mass of all bearings is their inertia."""

import dataclasses

import numpy as np
import pytest

import ksmea
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


def test_places_that_differ_by_rounding_are_one():
    """Stated positions and sums of lengths: 0.85 m and 0.8500000000000001 m."""
    first = PLAIN.rotor.disks[0]
    twice = dataclasses.replace(first, position=first.position * (1 + 2e-16))
    at_end = dataclasses.replace(first, position=PLAIN.rotor.length * (1 - 2e-16))
    rotor = dataclasses.replace(PLAIN.rotor, disks=(*PLAIN.rotor.disks, twice, at_end))
    problem = dataclasses.replace(PLAIN, rotor=rotor)
    for name in (
        "added_mass",
        "spring_mass",
        "annular_seal",
        "clearance_rub",
        "unbalance",
        "hub_stiffening",
        "disk_mass",
    ):
        said = [str(each) for each in effect(name).locations(problem)]
        assert len(set(said)) == len(said) > 0, said


def test_an_extended_rotor_has_modes_and_critical_speeds_from_python(tmp_path):
    path = tmp_path / "extended.yaml"
    path.write_text(
        "problem: {name: three_disk}\neffects:\n  - {name: added_mass, position: 0.75}\n  - {name: spring_mass, position: 1.0}\n"
    )
    extended, plain = ksmea.load_problem(str(path)), ksmea.load_problem("three_disk")
    added = {"attached_mass": 1.0, "attached_frequency": 30.0, "attached_damping_ratio": 2.0}
    heavy, light = ({**added, "added_mass": mass} for mass in (3.0, 0.0))
    expected = plain.critical_speeds(highest=1000.0)
    assert extended.critical_speeds(light, highest=1000.0) == pytest.approx(expected, rel=1e-6)  # another reduction
    lower = extended.critical_speeds(heavy, highest=1000.0)
    assert np.all(lower[:2] < expected[:2])
    assert [mode.frequency for mode in extended.modes(500.0, light)] == pytest.approx(
        [mode.frequency for mode in plain.modes(500.0)], rel=1e-6
    )
    assert extended.campbell([100.0, 500.0], heavy) is not None
    assert "Free motions leave out the spring-mass" in str(extended.draw(heavy))
