"""The two-disk RK-4 rig: what its owners' claims mean, and whether its published run-up fits band and units."""

import csv
import dataclasses
import math
import os
from pathlib import Path

import numpy as np
import pytest

from ksmea.errors import SettingError
from problems.rk4_two_disk import DISK_MASS, LAYOUTS, RK4TwoDisk, two_disk_rotor
from problems.rotor.finite_elements.assembly import assemble
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Disk, Material
from problems.rotor.free_motion.critical_speeds import critical_speeds
from problems.rotor.free_motion.modes import natural_modes
from problems.rotor.response.unknowns import rotor_at

RPM = math.pi / 30
STEEL = Material(210e9, 7850.0, 0.3)
RIGID = 1e10  # N/m, a million times the shaft's stiffness
DATA = Path(os.environ.get("KSMEA_DATA", Path(__file__).resolve().parents[3] / "shared" / "data"))


def first_criticals(layout, stiffness):
    """The first pair of critical speeds, rpm, on equal supports all but undamped."""
    rotor = two_disk_rotor(layout, STEEL, 14)  # elements of 40 mm: the shaft is slender, 0.01 rpm off
    # Supports that differ by 1e-4 part modes that would otherwise cross.
    supports = [Bearing(b.position, kxx=stiffness, kyy=1.0001 * stiffness, cxx=1.0, cyy=1.0) for b in rotor.bearings]
    return critical_speeds(dataclasses.replace(rotor, bearings=tuple(supports)), 2500 * RPM, 16)[:2] / RPM


def assumed(layout):
    settings = RK4TwoDisk(layout=layout)
    problem = settings.build()
    return rotor_at(problem.rotor, problem.unknowns, list(settings.reference().values()))


CRITICALS = {  # rpm, the table in the module's docstring
    "beam_model": {0.02: 1149, 0.05: 1503, 0.1: 1715, 0.2: 1857, 0.5: 1960, 1.0: 1998},
    "bearing_centres_560": {0.02: 1091, 0.05: 1378, 0.1: 1537, 0.2: 1638, 0.5: 1708, 1.0: 1733},
}


@pytest.mark.parametrize(("layout", "pair"), [("beam_model", (2037, 2088)), ("bearing_centres_560", (1759, 1806))])
def test_critical_speeds_on_rigid_supports(layout, pair):
    assert first_criticals(LAYOUTS[layout], RIGID) == pytest.approx(pair, abs=0.6)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_critical_speeds_in_the_bounds_of_stiffness(layout):
    found = [first_criticals(LAYOUTS[layout], stiffness * 1e6) for stiffness in CRITICALS[layout]]
    assert [pair[0] for pair in found] == pytest.approx(list(CRITICALS[layout].values()), abs=0.6)
    assert max(pair[1] - pair[0] for pair in found) < 50  # what gyroscopic moments alone can part


def test_disks_240_mm_apart_between_bearings_560_mm_apart_are_ruled_out():
    other = dataclasses.replace(LAYOUTS["beam_model"], bearings=(0.0, 0.56))
    assert first_criticals(other, RIGID) == pytest.approx((1487, 1505), abs=0.6)  # the run-up peaks at 1665


def test_rigid_supports_in_closed_form():
    # Two equal masses at a from the ends of a span L move together: a force at each deflects each by
    # F a²(3L − 4a)/(6EI). Without the shaft's mass and the disks' inertia.
    span, arm, second_moment = 0.48, 0.12, math.pi / 4 * 0.005**4
    expected = math.sqrt(6 * 210e9 * second_moment / (arm**2 * (3 * span - 4 * arm) * DISK_MASS))
    rotor = two_disk_rotor(LAYOUTS["beam_model"], Material(210e9, 1.0, 0.3), 14)
    points = tuple(Disk(disk.position, disk.mass, 0.0, 0.0) for disk in rotor.disks)
    bearings = tuple(Bearing(b.position, kxx=RIGID, kyy=1.01 * RIGID) for b in rotor.bearings)
    found = critical_speeds(Rotor(rotor.segments, points, bearings), 4000 * RPM, 16)[0]
    assert found == pytest.approx(expected, rel=1e-3)  # shear takes off 0.1 %


@pytest.mark.parametrize("layout", LAYOUTS)
def test_assumed_coefficients_have_what_the_owners_read(layout):
    lower, upper = critical_speeds(assumed(layout), 2500 * RPM, 16)[:2]
    assert (lower / RPM, upper / RPM) == pytest.approx((1648, 1750), abs=1.0)
    oscillating = [mode for mode in natural_modes(assumed(layout), lower) if mode.damping_ratio < 0.5]
    assert oscillating[0].damping_ratio == pytest.approx(0.04, rel=0.01)


def test_range_of_damping_in_the_default_bounds():
    ratios = []
    for damping in np.geomspace(10.0, 1000.0, 9):
        rotor = assumed("beam_model")
        supports = [dataclasses.replace(b, cxx=float(damping), cyy=float(damping)) for b in rotor.bearings]
        modes = natural_modes(dataclasses.replace(rotor, bearings=tuple(supports)), 1648 * RPM)
        ratios.append(next(mode.damping_ratio for mode in modes if mode.damping_ratio < 0.5))
    assert min(ratios) == pytest.approx(0.004, abs=5e-4)
    assert max(ratios) == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_mass(layout):
    matrices = assemble(assumed(layout))
    translation = np.tile([0, 1.0, 0, 0], len(matrices.mass) // 4)
    expected = 2 * DISK_MASS + 7850 * math.pi * 0.005**2 * 0.56
    assert translation @ matrices.mass @ translation == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_reduced_response_is_the_dense_one(layout):
    problem = RK4TwoDisk(layout=layout, n_speed=9, directions=["x", "y"]).build()
    x = problem.parameters.to_si(np.random.default_rng(2).random((20, 8)))
    # Relative to the largest amplitude at each speed: two unbalances may all but cancel at one probe.
    scale = np.abs(problem.dense_response(x)).max(axis=2, keepdims=True)
    assert (np.abs(problem.response(x) - problem.dense_response(x)) / scale).max() < 1e-7


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_unknown_is_seen_by_the_one_probe(layout):
    settings = RK4TwoDisk(layout=layout)
    problem = settings.build()
    x = np.array(list(settings.reference().values()))
    effect = np.abs(problem.sensitivity(x) * problem.parameters.width).max(axis=(0, 1))
    assert effect.min() > 1e-3 * np.abs(problem.response(x[None])).max()


@pytest.mark.parametrize("layout", LAYOUTS)
def test_reference_is_complete_and_inside_the_bounds(layout):
    settings = RK4TwoDisk(layout=layout)
    problem, reference = settings.build(), settings.reference()
    assert tuple(reference) == problem.parameters.names
    x = np.array(list(reference.values()))
    assert np.all((problem.parameters.lower < x) & (x < problem.parameters.upper))
    assert problem.parameters.in_units(x)[4:] == pytest.approx([3, 30, 1.5, 100])


def test_default_channel_is_the_published_one():
    assert [str(channel) for channel in RK4TwoDisk().build().channels] == ["x at 0.12 m"]
    assert [str(channel) for channel in RK4TwoDisk(layout="bearing_centres_560").build().channels] == ["x at 0.08 m"]
    both = RK4TwoDisk(sensors=[0.12, 0.44], directions=["x", "y"]).build().channels
    assert len(both) == 4


def test_band_and_units_suit_the_published_run_up():
    path = DATA / "rk4" / "runup_bode_first_critical.csv"
    if not path.is_file():
        pytest.skip(f"no run-up at {path}; KSMEA_DATA names the directory of public data")
    with path.open() as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    speed, amplitude = (np.array([row[key] for row in rows]) for key in ("rpm", "amp_1x_um_0pk"))
    settings = RK4TwoDisk()
    problem = settings.build()
    lowest, highest = problem.speed[[0, -1]] / RPM
    assert lowest == pytest.approx(speed.min(), rel=0.01)
    assert highest == pytest.approx(speed.max(), rel=0.01)

    x = np.array([list(settings.reference().values())])
    model = np.abs(problem.at(speed * RPM, problem.channels).response(x))[0, :, 0] * 1e6
    assert speed[np.argmax(model)] == pytest.approx(speed[np.argmax(amplitude)], rel=0.03)
    assert model.max() == pytest.approx(amplitude.max(), rel=0.3)  # assumed unbalance: µm against µm, and no more


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"layout": "beam"}, "did you mean 'beam_model'"),
        ({"mesh": 4}, "at least 5 elements, got 4"),
        ({"sensors": [0.57]}, "at most 0.56"),
        ({"sensors": []}, "at least one entry"),
        ({"directions": ["x", "x"]}, "none twice"),
        ({"speed_from": 2400.0, "speed_to": 1040.0}, "more than speed_from"),
        ({"n_speed": 0}, "at least 1"),
        ({"young_modulus": 0.0}, "above 0"),
        ({"density": -1.0}, "above 0"),
        ({"limits": {"phase": [0, 1]}}, "did you mean 'phase"),
        ({"limits": {"phase1": [90, -90]}}, r"\[90, -90\] deg"),
    ],
)
def test_bad_settings(changes, message):
    with pytest.raises(SettingError, match=message) as caught:
        RK4TwoDisk(**changes)
    assert "\n" not in str(caught.value)
