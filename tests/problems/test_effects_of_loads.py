"""Loads that turn with the shaft, and readings that are late, against closed forms: a rigid rotor on two springs, and a bow."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.measurement.campaign import Campaign, Run
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.speeds import SpeedHistory
from ksmea.plugins import registry
from ksmea.problem.alignment import aligned
from problems.rotor.finite_elements.segments import Disk
from problems.three_disk import ThreeDisk
from rigid_rotor import DAMPING, MASS, NATURAL, STIFFNESS, problem_of, rigid_rotor

SPEED = NATURAL * np.array([0.3, 0.9, 1.7])
ARM = 0.3  # m, from the middle to either bearing
RIGID = problem_of(rigid_rotor(), SPEED)  # its disk has I_p 0.01 and I_d 0.02 kg m²; probes look at 0 m
BEARING = STIFFNESS + 1j * SPEED * DAMPING  # N/m, of each

SETTINGS = ThreeDisk(sensors=[0.1, 0.5], n_speed=9)
PLAIN = SETTINGS.build()
REFERENCE = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])


def effect(name, **settings):
    return registry.create("effect", name, settings)


def added(place, theta, problem=RIGID, own=(STIFFNESS,)):
    """Change of the response by an effect, (n_speed, n_channel) m."""
    x = np.concatenate([own, theta])[None]
    return place.added_to(problem).response(x)[0] - problem.response(np.array(own)[None])[0]


def bounce(force):
    """The middle of the rigid rotor under a force on it, in x."""
    return force / (2 * BEARING - MASS * SPEED**2)


def tilt(moment):
    """Its tilt φ_x about x under a forward moment: φ_y = −i φ_x, and x rises along the shaft by φ_y per metre."""
    return moment / (2 * ARM**2 * BEARING - (0.02 - 0.01) * SPEED**2)


# 1e-4: the shaft is a thousand times as stiff as its bearings, and its own tilting inertia is left out


def test_a_force_at_the_coupling_moves_and_tilts_a_rigid_rotor():
    """A forward force f (1, −i) at an arm a has the moment i a f about x, and φ_y = −i φ_x moves the far end by −a φ_y."""
    force = 3.0 - 4.0j
    found = added(effect("coupling_misalignment", position=0.6), [3.0, -4.0])
    expected = bounce(force) + 1j * ARM * tilt(1j * ARM * force)
    assert found == pytest.approx(np.outer(expected, [1, -1j]), rel=1e-4)


def test_a_moment_at_the_coupling_tilts_a_rigid_rotor_wherever_it_acts():
    expected = np.outer(1j * ARM * tilt(2.0 + 1.0j), [1, -1j])
    for position in (0.0, 0.6):
        found = added(effect("coupling_misalignment", position=position, kind="moment"), [2.0, 1.0])
        assert found == pytest.approx(expected, rel=1e-4)


def test_the_coupling_is_at_the_far_end_where_nobody_says():
    place = effect("coupling_misalignment")
    assert str(place) == "force at the far end" and str(place.placed_on(PLAIN)) == "force at 1.3 m"
    found = [str(each) for each in place.locations(PLAIN)]
    assert found == ["force at 0 m", "force at 1.3 m", "moment at 0 m", "moment at 1.3 m"]


def at_places(rotor, **keys):
    problem = dataclasses.replace(PLAIN, rotor=dataclasses.replace(rotor, **keys))
    place = effect("coupling_misalignment")
    return [str(each) for each in place.locations(problem)], place.caveat(problem)


def test_misalignment_acts_at_couplings_alone_and_without_any_at_ends_that_carry_no_disk():
    """The shaft is 0.1 m thick: a disk 0.15 m from its end leaves room for half a coupling, one 0.05 m from it does not."""
    rotor = PLAIN.rotor
    assert at_places(rotor, couplings=(0.5, 1.3)) == (
        ["force at 0.5 m", "force at 1.3 m", "moment at 0.5 m", "moment at 1.3 m"], ""
    )  # fmt: skip
    assert at_places(rotor, couplings=(0.51,)) == (["force at 0.51 m"], "")
    overhung = (*rotor.disks, dataclasses.replace(rotor.disks[0], position=1.3))
    places, caveat = at_places(rotor, disks=overhung)
    assert places == ["force at 0 m", "moment at 0 m"] and "state the position of each under `couplings`" in caveat
    at_both = (*overhung, dataclasses.replace(rotor.disks[0], position=0.0))
    assert at_places(rotor, disks=at_both)[0] == []
    beside = (*rotor.disks, dataclasses.replace(rotor.disks[0], position=1.2))
    assert len(at_places(rotor, disks=beside)[0]) == 4


def test_a_skewed_disk_tilts_a_rigid_rotor_by_the_difference_of_its_inertias():
    found = added(effect("skewed_disk"), [1e-3, 2e-3])
    expected = 1j * ARM * tilt((0.02 - 0.01) * SPEED**2 * (1e-3 + 2e-3j))
    assert found == pytest.approx(np.outer(expected, [1, -1j]), rel=1e-4)


def test_a_disk_as_stout_as_a_ball_has_no_skew():
    ball = dataclasses.replace(RIGID.rotor, disks=(Disk(0.3, MASS, 0.02, 0.02),))
    problem = dataclasses.replace(RIGID, rotor=ball)
    assert effect("skewed_disk").locations(problem) == []
    for position in (None, 0.3, 0.15):
        with pytest.raises(SettingError, match="expected a disk whose polar and diametral inertia differ, got none"):
            effect("skewed_disk", position=position).added_to(problem)
    with pytest.raises(SettingError, match="got none there"):
        effect("skewed_disk", position=0.1).added_to(PLAIN)


def test_late_readings_have_their_amplitudes_and_lag_in_proportion_to_speed():
    plain = PLAIN.response(REFERENCE[None])[0]
    late = plain + added(effect("timing_delay"), [2e-4], PLAIN, REFERENCE)
    assert np.angle(late / plain) == pytest.approx(np.tile(-2e-4 * PLAIN.speed[:, None], 4), abs=1e-9)
    assert np.abs(late) == pytest.approx(np.abs(plain), rel=1e-12)
    one = added(effect("timing_delay", position=0.5, direction="x"), [2e-4], PLAIN, REFERENCE)
    assert one[:, [0, 1, 3]] == pytest.approx(0, abs=1e-15) and one[:, 2] == pytest.approx((late - plain)[:, 2])


def test_a_delay_is_not_looked_for_in_amplitudes():
    values = np.ones((9, 4))
    assert effect("timing_delay").seen_in(measured(values=values)) is None
    assert effect("timing_delay").seen_in(measured(values=values * 1j)) == effect("timing_delay")


def measured(speed=PLAIN.speed, **keys):
    keys = {"values": np.ones((len(speed), 4), dtype=complex), **keys}
    return Measurement(speed, PLAIN.channels, noise=None, source="test", **keys)


SWEEP = SpeedHistory("run-up")


def test_a_thermal_bow_is_nothing_at_first_and_a_residual_one_at_last():
    place = effect("thermal_bow").locations(PLAIN)[0]
    found = added(place, [2e-5, -1e-5], PLAIN, REFERENCE)
    whole = added(effect("residual_bow"), [2e-5, -1e-5], PLAIN, REFERENCE)
    assert found == pytest.approx(np.linspace(0, 1, 9)[:, None] * whole, rel=1e-8)  # even speeds, in their order
    few = place.added_to(PLAIN).at(PLAIN.speed[3:5], PLAIN.channels)  # as when blocks of speeds are left out
    x = np.array([[*REFERENCE, 2e-5, -1e-5]])
    assert few.response(x)[0] == pytest.approx(place.added_to(PLAIN).response(x)[0, 3:5], rel=1e-9)


@pytest.mark.parametrize("speed", [PLAIN.speed, PLAIN.speed[::-1]], ids=["run-up", "coast-down"])
def test_it_grows_with_time_where_that_is_known(speed):
    time = np.arange(9.0) ** 2 + 40
    place = effect("thermal_bow").seen_in(measured(speed, history=SWEEP, time=time))
    grown = np.interp(PLAIN.speed, *zip(*sorted(zip(speed, np.arange(9.0) ** 2 / 64))))
    whole = added(effect("residual_bow"), [2e-5, 0.0], PLAIN, REFERENCE)
    assert added(place, [2e-5, 0.0], PLAIN, REFERENCE) == pytest.approx(grown[:, None] * whole, rel=1e-8)


def test_it_grows_with_the_rows_where_no_times_are_known_and_is_not_looked_for_in_steady_states():
    speed = PLAIN.speed**1.3
    place = effect("thermal_bow").seen_in(measured(speed, history=SWEEP))
    assert place.speeds == pytest.approx(speed) and place.grown == pytest.approx(np.linspace(0, 1, 9))
    assert effect("thermal_bow").seen_in(measured()) is None


def test_a_long_record_is_kept_by_few_knots():
    speed = np.linspace(200, 1500, 2000)
    place = effect("thermal_bow").seen_in(
        measured(speed, history=SWEEP, time=speed**2, values=np.ones((2000, 4), dtype=complex))
    )
    expected = (speed**2 - speed[0] ** 2) / np.ptp(speed**2)
    # a parabola between 33 knots is off by h²/8 of its curvature: (1/32)²/8 of 1.5 at most
    assert len(place.speeds) == 33 and np.abs(np.interp(speed, place.speeds, place.grown) - expected).max() < 2e-4


def in_runs(*directions):
    runs = tuple(Run(f"run{number}", 9, direction=direction) for number, direction in enumerate(directions))
    speed = np.tile(PLAIN.speed, len(runs))
    return measured(speed, campaign=Campaign(runs), values=np.ones((len(speed), 4), dtype=complex))


def test_run_up_and_run_down_of_a_campaign_differ_by_what_has_grown_between():
    measurement = in_runs("up", "down")
    place = effect("thermal_bow").seen_in(measurement)
    problem = aligned(PLAIN, measurement)
    x = np.array([*REFERENCE, 2e-5, -1e-5])[None]
    up, down = np.split(place.added_to(problem).response(x)[0], 2)
    whole = added(effect("residual_bow"), [2e-5, -1e-5], PLAIN, REFERENCE)
    grown = np.linspace(0, 0.5, 9)[:, None]
    assert up - PLAIN.response(REFERENCE[None])[0] == pytest.approx(grown * whole, rel=1e-8)
    assert down - up == pytest.approx((1 - 2 * grown) * whole, rel=1e-7, abs=1e-12)
    assert str(place) == "half sine between the bearings in runs up and down"


def test_runs_that_all_go_one_way_start_cold():
    assert effect("thermal_bow").seen_in(in_runs("up", "up")).grown == [0.0, 1.0]
    assert effect("thermal_bow").seen_in(in_runs("down")).grown == [1.0, 0.0]
    for unknown in (("up", ""), ("steady", "steady"), ("up", "down", "steady")):
        assert effect("thermal_bow").seen_in(in_runs(*unknown)) is None


def test_a_history_that_is_none_is_refused():
    for wrong in ({"speeds": [300.0, 200.0], "grown": [0.0, 1.0]}, {"speeds": [200.0]}):
        with pytest.raises(SettingError, match="speeds: expected rising ones, one for each of grown"):
            effect("thermal_bow", **wrong)
