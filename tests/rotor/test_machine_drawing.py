"""Facts of a drawing for machine people: separation margins, sag and static loads.

Undamped, free and unheld rotors are included.
"""

import dataclasses

import numpy as np
import pytest

from ksmea.measurement.channel import Channel
from ksmea.problem.parameters import Parameter
from ksmea.rotordynamics.margins import peaks, required_margin, separation_margins
from ksmea.show.rotordynamics_text import critical_speed_table, text
from ksmea.studies.rotordynamics import RotordynamicsOptions, rotordynamics
from ksmea.units import RPM
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.free_motion.static_load import GRAVITY, static_sag, weight_shares
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import UnbalanceTarget, Unknown

STEEL = Material(211e9, 7810.0, 0.2993)
PROBE = Channel(0.5, "x")


def friswell(damping):
    """Friswell, Penny, Garvey & Lees 2010, example 5.9.1 (without damping) and 5.9.5 (3000 N s/m)."""
    disks = tuple(
        Disk.from_geometry(at, outer_radius=radius, inner_radius=0.025, thickness=0.07, density=7810.0)
        for at, radius in ((0.5, 0.14), (1.0, 0.175))
    )
    held = {"kxx": 1e6, "kyy": 1e6, "cxx": damping, "cyy": damping}
    segments = tuple(ShaftSegment(0.5, 0.025, STEEL, 8) for _ in range(3))
    return Rotor(segments, disks, (Bearing(0.0, **held), Bearing(1.5, **held)), (UnbalancePlane(0.5),))


def problem_of(rotor):
    unknown = Unknown(Parameter("u", "kg m", 1.0, 1e-4, 1e-2), (UnbalanceTarget(0),))
    return RotorProblem(rotor, (unknown,) if rotor.unbalance else (), 4500 * RPM * np.linspace(0.02, 1, 45), (PROBE,))


def drawn(rotor, **options):
    problem = problem_of(rotor)
    return rotordynamics(
        problem, np.full(len(problem.parameters), 1e-3), RotordynamicsOptions(**options), title="rotor"
    )


def test_an_undamped_rotor_neither_grows_nor_decays():
    """Published frequencies at 4000 rpm (rad/s), section 5.9.1 of the book."""
    found = drawn(friswell(0.0), speed_rpm=4000.0)
    motions = found.shapes.motions.eigenvalue[:4]
    np.testing.assert_allclose(motions.imag, [85.39, 87.80, 251.78, 294.71], rtol=1e-4)  # five digits printed
    assert np.all(motions.real == 0)
    assert {each.amplification_factor for each in found.critical_speeds} == {None}
    table = critical_speed_table(found)
    assert set(table["amplification factor"]) == {"undamped"} and set(table["log decrement"]) == {"0"}
    assert "grows" not in text(found) and np.isinf(found.threshold)


def test_critical_speeds_stand_beside_the_undamped_ones_that_they_become():
    """Damping only moves them: with a hundredth of it each lies within 1 % of the undamped one, which is followed down from there."""
    little, full = drawn(friswell(30.0)), drawn(friswell(3000.0))
    undamped = drawn(friswell(0.0))
    known = [(each.harmonic, each.direction, each.speed) for each in undamped.critical_speeds]
    for found in (little, full):
        for each in found.critical_speeds:
            if each.undamped is not None:
                same = [speed for harmonic, way, speed in known if (harmonic, way) == (each.harmonic, each.direction)]
                assert min(abs(each.undamped / speed - 1) for speed in same) < 1e-6
    assert all(abs(each.speed / each.undamped - 1) < 0.01 for each in little.critical_speeds)


def test_a_rotor_that_nothing_holds_is_stable_and_draws():
    free = dataclasses.replace(friswell(0.0), bearings=(), unbalance=())
    found = drawn(free)
    assert np.isinf(found.threshold)
    assert found.layout.bearings == () and found.layout.sag is None
    assert found.critical_speeds  # of bending, free at both ends
    assert all(each.speed > 100 for each in found.critical_speeds)


def test_amplification_factor_is_that_of_the_damping_ratio():
    """A Jeffcott rotor: |r| = Ω²/√((ω² − Ω²)² + (2ζωΩ)²); of little damping N_c/(N₂ − N₁) is 1/(2ζ), within 5 ζ² of it."""
    for ratio in (0.01, 0.05):
        speed = np.linspace(1.0, 300.0, 60_001)
        amplitude = speed**2 / np.sqrt((100.0**2 - speed**2) ** 2 + (2 * ratio * 100 * speed) ** 2)
        [peak] = peaks(speed, amplitude[:, None], [PROBE])
        assert peak.amplification_factor == pytest.approx(1 / (2 * ratio), rel=5 * ratio**2)
        assert peak.speed == pytest.approx(100 / np.sqrt(1 - 2 * ratio**2), rel=1e-6)


def test_margins_are_those_of_the_clause():
    assert required_margin(2.4, "below") == 0.0
    assert required_margin(2.5, "below") == pytest.approx(0.0)
    assert required_margin(5.0, "below") == pytest.approx(0.17 * (1 - 1 / 3.5))
    assert required_margin(5.0, "above") == pytest.approx(0.10 + 0.17 * (1 - 1 / 3.5))
    speed = np.linspace(1.0, 300.0, 6001)
    amplitude = speed**2 / np.sqrt((100.0**2 - speed**2) ** 2 + (0.1 * 100 * speed) ** 2)
    found = peaks(speed, amplitude[:, None], [PROBE])
    for low, high, side, actual in ((120, 200, "below", 1 - 1 / 1.2), (40, 80, "above", 0.25), (90, 110, "inside", 0)):
        [margin] = separation_margins(found, low, high)
        assert margin.side == side and margin.actual == pytest.approx(actual, abs=0.005)
        assert margin.is_met == (actual > 0.15)


def test_a_drawing_has_the_margins_of_its_operating_range():
    found = drawn(friswell(300.0), operating_rpm=[1500.0, 2000.0])
    assert {each.side for each in found.margins} == {"below", "above"}
    said = text(found)
    assert "separation margins for 1500 to 2000 rpm (API 617" in said
    near = {each.speed: 1 / (2 * each.damping_ratio) for each in found.critical_speeds if each.harmonic == 1.0}
    # 1X peaks of well separated modes are as sharp as their modes
    sharp = max(found.margins, key=lambda each: each.peak.speed).peak
    nearest = min(near, key=lambda speed: abs(speed - sharp.speed))
    assert sharp.amplification_factor == pytest.approx(near[nearest], rel=0.1)


def test_sag_and_loads_of_a_level_shaft():
    """A uniform shaft on two stiff springs: 5 w L⁴/(384 EI) in the middle and w L²/(8 κGA) of shear; half of its weight on each."""
    segment = ShaftSegment(1.2, 0.02, STEEL, 12)
    stiff = {"kxx": 1e14, "kyy": 1e14}
    rotor = Rotor((segment,), (), (Bearing(0.0, **stiff), Bearing(1.2, **stiff)))
    weight = 7810 * segment.area * GRAVITY
    bending = 5 * weight * 1.2**4 / (384 * 211e9 * segment.second_moment)
    nu = 0.2993
    shear = weight * 1.2**2 / (8 * (6 * (1 + nu) / (7 + 6 * nu)) * STEEL.shear_modulus * segment.area)
    assert static_sag(rotor).max() == pytest.approx(bending + shear, rel=1e-6)
    np.testing.assert_allclose(weight_shares(rotor), weight * 0.6, rtol=1e-9)
    # Overhung: levers share it, and the free end hangs lower than the line through the bearings
    overhung = dataclasses.replace(rotor, bearings=(Bearing(0.0, **stiff), Bearing(0.8, **stiff)))
    np.testing.assert_allclose(weight_shares(overhung), weight * 1.2 * np.array([0.25, 0.75]), rtol=1e-6)
    assert static_sag(overhung)[-1] > 0 > static_sag(overhung).min() - 1e-12
