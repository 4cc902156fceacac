"""Motions at a harmonic of the speed of rotation: reductions and the dense route, and what channels of a harmonic read."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.plugins import registry
from ksmea.problem.load import Load
from problems.rotor.finite_elements.assembly import assemble
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.loads import unit_loads
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.response import dense
from problems.rotor.response.model import impedances_of
from problems.rotor.response.receptance import at_harmonic, reduce_rotor
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk(sensors=[0.1, 0.77], n_speed=20).build()
TRUTH = np.array([50e6, 70e6, 500.0, 700.0, 2e-4])
SPEED = np.linspace(50.0, 400.0, 12)


def damped_rotor():
    """Flexible, on cross-coupled bearings with damping, with internal damping too: every matrix has a say."""
    steel = Material(2.1e11, 7800.0, 0.3)
    bearing = {"kxx": 2e7, "kxy": 3e6, "kyx": -1e6, "kyy": 3e7, "cxx": 2e3, "cxy": 100.0, "cyx": -50.0, "cyy": 1e3}
    return Rotor(
        (ShaftSegment(1.0, 0.025, steel, 6),),
        (Disk(0.5, 30.0, 0.4, 0.2),),
        (Bearing(0.0, **bearing), Bearing(1.0, **bearing)),
        (UnbalancePlane(0.5, 1e-4),),
        internal_damping=1e-5,
    )


@pytest.mark.parametrize("harmonic", [0.5, 2.0, 3.0])
def test_a_reduction_at_a_harmonic_is_the_motion_under_a_load_of_that_frequency(harmonic):
    """D(ω) with ω = hΩ written out here, while gyroscopic moments and N go with the spin speed Ω."""
    rotor = damped_rotor()
    loads = unit_loads(rotor, [Load(0.5, "x"), Load(0.5, "y", "moment")], len(SPEED))
    channels = [Channel(0.5, "x", harmonic), Channel(0.2, "y", harmonic)]
    impedances = impedances_of(rotor, (), of_all_bearings=True)
    reduction = reduce_rotor(rotor, impedances, SPEED, channels, loads, harmonic=harmonic)
    parts = [
        [b.stiffness[i.row, i.column] + 1j * harmonic * SPEED * b.damping[i.row, i.column]]
        for i in impedances
        for b in [rotor.bearings[i.bearing]]
    ]
    found = reduction.response_per_load(np.array(parts))[:, 1:, 0]
    whole, read = assemble(rotor), dense.channel_rows(rotor, channels, harmonic)
    for index, spin in enumerate(SPEED):
        omega = harmonic * spin
        stiffness = whole.stiffness + spin * whole.circulatory - omega**2 * whole.mass
        stiffness = stiffness + 1j * omega * (whole.damping + spin * whole.gyroscopic)
        expected = read @ np.linalg.solve(stiffness, loads[index])
        # rounding of 1e-16 grows by the ratio of stiffnesses of elements and modes, 1e4
        assert np.abs(found[..., index] - expected).max() < 1e-10 * np.abs(expected).max()


def test_a_motion_at_a_harmonic_feels_springs_alike_and_dampers_as_much_more():
    """Coefficients of bearings are functions of the spin speed: z = k + iωc at ω = hΩ."""
    k, c = 4e6, 300.0
    assert at_harmonic(k + 1j * SPEED * c, 3.0) == pytest.approx(k + 3j * SPEED * c, rel=1e-15)


def test_a_baseline_model_answers_at_the_speed_of_rotation_alone():
    """Forces of unbalance are at 1X, and the model is linear: 2X and 3X read nothing, and 1X what it reads without them."""
    there = (PROBLEM.channels[0], Channel(0.1, "x", 2.0), Channel(0.77, "y", 3.0), PROBLEM.channels[1])
    seen = PROBLEM.at(PROBLEM.speed, there)
    one = PROBLEM.at(PROBLEM.speed, (there[0], there[3]))
    for answer in (
        lambda p: p.response(TRUTH[None])[0],
        lambda p: p.dense_response(TRUTH[None])[0],
        lambda p: p.sensitivity(TRUTH),
    ):
        whole = answer(seen)
        assert np.all(whole[:, 1:3] == 0)
        assert np.array_equal(whole[:, [0, 3]], answer(one))


def test_a_runout_is_read_at_the_speed_of_rotation_and_a_gain_at_all_harmonics():
    seen = PROBLEM.at(PROBLEM.speed, (Channel(0.1, "x"), Channel(0.1, "x", 2.0)))
    runout = registry.create("effect", "runout", {}).locations(seen)[0]
    changed = runout.added_to(seen).response(np.append(TRUTH, [1e-6, 0.0])[None])[0] - seen.response(TRUTH[None])[0]
    assert np.abs(changed[:, 0]).min() > 9e-7 and np.all(changed[:, 1] == 0)


def test_a_channel_says_its_harmonic_where_it_is_not_1x():
    assert str(Channel(0.1, "x")) == "x at 0.1 m"
    assert str(dataclasses.replace(Channel(0.1, "x"), harmonic=2.0)) == "2X x at 0.1 m"
    assert str(Channel(0.1, "y", 0.5)) == "0.5X y at 0.1 m"
    with pytest.raises(SettingError, match="expected a number above 0"):
        Channel(0.1, "x", 0.0)
