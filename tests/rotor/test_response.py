"""Unbalance response by the dense route against closed forms, with its signs."""

import dataclasses

import numpy as np
import pytest

from ksmea.measurement.channel import Channel
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.finite_elements.shaft import shear_coefficient
from problems.rotor.response.dense import dense_response

# A shaft without weight, but with a mass matrix that is still regular: 1e-9 of the disk's mass.
WEIGHTLESS = Material(young_modulus=200e9, density=1e-6, poisson_ratio=0.3)
SEGMENT = ShaftSegment(0.5, 0.01, WEIGHTLESS, 2)
MASS = 10.0  # kg
UNBALANCE = 3e-4  # kg m
STIFFNESS, DAMPING = 2e5, 300.0  # of each bearing
MIDDLE = (Channel(0.5, "x"), Channel(0.5, "y"))


def jeffcott(phase=0.0, bearing=None):
    """A disk in the middle of a weightless shaft on two equal bearings."""
    bearing = bearing or Bearing(0.0, kxx=STIFFNESS, kyy=STIFFNESS, cxx=DAMPING, cyy=DAMPING)
    return Rotor(
        segments=(SEGMENT, SEGMENT),
        disks=(Disk(0.5, MASS, polar_inertia=0.05, diametral_inertia=0.03),),
        bearings=(bearing, dataclasses.replace(bearing, position=1.0)),
        unbalance=(UnbalancePlane(0.5, UNBALANCE, phase),),
    )


def shaft_stiffness():
    """Of a simply supported shaft at its middle, with shear: 1/k = L³/(48EI) + L/(4κGA)."""
    bending = WEIGHTLESS.young_modulus * SEGMENT.second_moment
    shear = shear_coefficient(SEGMENT) * WEIGHTLESS.shear_modulus * SEGMENT.area
    return 1 / (1 / (48 * bending) + 1 / (4 * shear))


def jeffcott_response(speed):
    """x = m e Ω²/(k − MΩ²), with the shaft in series with both bearings: 1/k = 1/k_shaft + 1/(2k_b + 2iΩc_b)."""
    series = 1 / (1 / shaft_stiffness() + 1 / (2 * STIFFNESS + 2j * speed * DAMPING))
    return UNBALANCE * speed**2 / (series - MASS * speed**2)


def test_jeffcott_rotor_in_closed_form():
    natural = np.sqrt(1 / (1 / shaft_stiffness() + 0.5 / STIFFNESS) / MASS)
    speed = natural * np.array([0.1, 0.5, 0.9, 0.99, 1.0, 1.01, 1.1, 2.0, 10.0])
    response = dense_response(jeffcott(), speed, MIDDLE)
    # 1e-6: the shaft's remaining mass, 1e-9 at most, magnified by the resonance.
    assert response[:, 0] == pytest.approx(jeffcott_response(speed), rel=1e-6)
    # The orbit turns from +x to +y: y lags x by a quarter turn, and is as large on isotropic bearings.
    assert response[:, 1] == pytest.approx(-1j * jeffcott_response(speed), rel=1e-6)
    assert np.argmax(np.abs(response[:, 0])) == 4


def test_heavy_spot_turns_inside_above_the_critical_speed():
    natural = np.sqrt(1 / (1 / shaft_stiffness() + 0.5 / STIFFNESS) / MASS)
    below, above = dense_response(jeffcott(), natural * np.array([0.2, 50.0]), MIDDLE)[:, 0]
    assert abs(np.angle(below, deg=True)) < 2  # damping leaves a lag of that order
    # Far above, the disk turns about its centre of mass: x → −m e/M, up to (1/50)² = 4e-4.
    assert above == pytest.approx(-UNBALANCE / MASS, rel=1e-3)


def test_phase_turns_the_whole_response():
    speed = np.array([50.0, 120.0])
    anisotropic = Bearing(0.0, kxx=STIFFNESS, kyy=2 * STIFFNESS, kxy=3e4, cxx=DAMPING, cyy=DAMPING)
    straight, turned = (dense_response(jeffcott(phase, anisotropic), speed, MIDDLE) for phase in (0.0, 0.7))
    assert turned == pytest.approx(straight * np.exp(0.7j), rel=1e-12)


def test_unbalance_on_y_is_the_one_on_x_a_quarter_turn_later():
    # Turning rotor, axes and unbalance by 90° together must turn the response: x' = y, y' = −x.
    speed = np.array([50.0, 120.0])
    bearing = Bearing(0.0, kxx=1e5, kyy=3e5, kxy=2e4, kyx=-1e4, cxx=100.0, cyy=200.0, cxy=30.0, cyx=5.0)
    turned_bearing = Bearing(0.0, kxx=3e5, kyy=1e5, kxy=1e4, kyx=-2e4, cxx=200.0, cyy=100.0, cxy=-5.0, cyx=-30.0)
    original = dense_response(jeffcott(0.3, bearing), speed, MIDDLE)
    turned = dense_response(jeffcott(0.3 - np.pi / 2, turned_bearing), speed, MIDDLE)
    assert turned[:, 0] == pytest.approx(original[:, 1], rel=1e-9)
    assert turned[:, 1] == pytest.approx(-original[:, 0], rel=1e-9)


def test_cross_coupling_on_a_rigid_rotor_in_closed_form():
    # (2K + 2iΩC − MΩ²) q = m e Ω² (1, −i) with a shaft 2.5e5 times stiffer than its stiffest bearing.
    stiff = Material(young_modulus=2e17, density=1e-6, poisson_ratio=0.3)
    segment = dataclasses.replace(SEGMENT, material=stiff)
    bearing = Bearing(0.0, kxx=1e5, kyy=3e5, kxy=2e4, kyx=-1e4, cxx=100.0, cyy=200.0, cxy=30.0, cyx=5.0)
    rotor = dataclasses.replace(jeffcott(bearing=bearing), segments=(segment, segment))
    speed = np.array([60.0, 140.0, 300.0])
    found = dense_response(rotor, speed, MIDDLE)
    for omega, response in zip(speed, found, strict=True):
        matrix = 2 * bearing.stiffness + 2j * omega * bearing.damping - MASS * omega**2 * np.eye(2)
        expected = np.linalg.solve(matrix, UNBALANCE * omega**2 * np.array([1, -1j]))
        # The shaft's flexibility is 4e-6 of a bearing's, magnified about 10 times near the resonance at 140 rad/s.
        assert response == pytest.approx(expected, rel=1e-4)


def test_planes_superpose():
    speed, channels = np.array([40.0, 90.0]), (Channel(0.3, "x"), Channel(0.8, "y"))
    planes = (UnbalancePlane(0.5, 1e-4, 0.2), UnbalancePlane(0.75, 2e-4, -1.0))
    alone = [dense_response(dataclasses.replace(jeffcott(), unbalance=(plane,)), speed, channels) for plane in planes]
    together = dense_response(dataclasses.replace(jeffcott(), unbalance=planes), speed, channels)
    assert together == pytest.approx(alone[0] + alone[1], rel=1e-10)


def test_force_and_motion_are_reciprocal_at_standstill_of_the_gyroscope():
    # Maxwell: with a symmetric dynamic stiffness, unbalance at A seen at B equals unbalance at B seen at A,
    # also at places between nodes.
    rotor, speed = jeffcott(), np.array([30.0])
    still = dataclasses.replace(rotor, disks=(Disk(0.5, MASS, 0.0, 0.03),))
    here, there = 0.11, 0.67
    seen = [
        dense_response(
            dataclasses.replace(still, unbalance=(UnbalancePlane(place, 1e-4),)), speed, (Channel(other, "x"),)
        )
        for place, other in ((here, there), (there, here))
    ]
    # The weightless shaft's own gyroscopics are what breaks reciprocity, by its share of the mass.
    assert seen[0] == pytest.approx(seen[1], rel=1e-6)
