"""Seals and journal bearings: against closed forms, published coefficients, and the pressure in the film itself."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.plugins import registry
from problems.rotor.extension.short_bearing import eccentricity_ratio, film_coefficients, modified_sommerfeld
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.free_motion.static_load import GRAVITY, weight_shares
from problems.rotor.response.dense import dense_response
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk
from rigid_rotor import DAMPING, MASS, NATURAL, STIFFNESS, problem_of, rigid_rotor

SETTINGS = ThreeDisk(sensors=[0.1, 0.5], n_speed=5)
PLAIN = SETTINGS.build()
REFERENCE = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])


def effect(name, **settings):
    return registry.create("effect", name, settings)


# An annular seal in the middle of a rigid rotor. 1e-4: its shaft is a thousand times as stiff as its bearings.


@pytest.mark.parametrize("swirl_ratio", [0.2, 0.5])
def test_a_seal_holds_and_damps_forward_whirl_as_the_liquid_sees_it(swirl_ratio):
    speed = NATURAL * np.array([0.3, 0.9, 1.7])
    rotor = problem_of(rigid_rotor(), speed)
    stiffness, damping = 3e5, 800.0
    found = effect("annular_seal", swirl_ratio=swirl_ratio).added_to(rotor)
    dynamic = 2 * (STIFFNESS + 1j * speed * DAMPING) + stiffness + 1j * speed * (1 - swirl_ratio) * damping
    expected = 1e-4 * speed**2 / (dynamic - MASS * speed**2)
    response = found.response(np.array([[STIFFNESS, stiffness, damping]]))[0]
    assert response == pytest.approx(np.outer(expected, [1, -1j]), rel=1e-4)


def test_a_seal_drives_a_rotor_unstable_where_the_liquid_overtakes_its_whirl():
    """D (ω − λΩ) + 2 c ω = 0 with ω the whirl, which the damping leaves where it is."""
    stiffness, damping = 3e5, 2 * DAMPING
    whirl = np.sqrt((2 * STIFFNESS + stiffness) / MASS)
    expected = whirl * (damping + 2 * DAMPING) / (0.5 * damping)
    sealed = effect("annular_seal").added_to(problem_of(rigid_rotor(), 1.5 * expected))
    found = sealed.stability_threshold(np.array([STIFFNESS, stiffness, damping]), 1.5 * expected)
    assert found == pytest.approx(expected, rel=1e-3)  # the damping shifts ω by its ratio squared


def test_seals_sit_at_disks_that_are_at_no_bearing_or_in_the_middle():
    assert [str(place) for place in effect("annular_seal").locations(PLAIN)] == ["at 0.2 m", "at 0.5 m", "at 1 m"]
    for disks in ((), (Disk(0.0, 5.0, 0.1, 0.1),)):
        other = dataclasses.replace(PLAIN, rotor=dataclasses.replace(PLAIN.rotor, disks=disks))
        assert [str(place) for place in effect("annular_seal").locations(other)] == ["at 0.65 m"]


# Short journal bearings.

EXAMPLE = {"diameter": 0.1, "length": 0.03, "viscosity": 0.1, "loads_n": [525.0, 525.0]}
CLEARANCE, LOAD = 1e-4, 525.0  # m, N
SPEED = 1500 * np.pi / 30


def test_published_coefficients_of_a_film():
    """Friswell, Penny, Garvey & Lees 2010, Example 5.5.1, and the CylindricalBearing of the ROSS library: all printed digits."""
    eccentricity = eccentricity_ratio(np.array(0.1 * SPEED * 0.1 * 0.03**3 / (8 * LOAD * CLEARANCE**2)))
    stiffness, damping = film_coefficients(eccentricity)
    assert float(eccentricity) == pytest.approx(0.2663, abs=5e-5)
    assert stiffness * LOAD / CLEARANCE / 1e6 == pytest.approx(np.array([[12.81, 16.39], [-25.06, 8.815]]), abs=5e-3)
    assert damping * LOAD / CLEARANCE / SPEED / 1e3 == pytest.approx(
        np.array([[232.9, -81.92], [-81.92, 294.9]]), abs=5e-2
    )


def film_force(position, velocity, speed, eta=0.1, length=0.03, radius=0.05):
    """Force (2,) N on a journal in (u, v) by the pressure of the film itself, at a position (m) and a velocity (m/s).

    P = −η L³/h³ (ḣ + Ω/2 h′) per length around it, none where it would be below zero, h = c − u cos θ − v sin θ."""
    theta = np.linspace(0, 2 * np.pi, 200001)[1:]
    normal = np.stack([np.cos(theta), np.sin(theta)])
    gap = CLEARANCE - position @ normal
    slope = position @ np.stack([np.sin(theta), -np.cos(theta)])
    pressure = -eta * length**3 / gap**3 * (-(velocity @ normal) + speed / 2 * slope)
    return -(np.maximum(pressure, 0) * normal).sum(axis=1) * radius * 2 * np.pi / len(theta)


@pytest.mark.parametrize("eccentricity", [0.05, 0.3, 0.7])
def test_coefficients_are_those_of_the_pressure_in_the_film(eccentricity):
    """Balance at rest, and slopes of the force by differences: 1e-4 of the largest, where cavitation begins is a corner."""
    attitude = np.arctan2(np.pi * np.sqrt(1 - eccentricity**2), 4 * eccentricity)
    rest = CLEARANCE * eccentricity * np.array([np.sin(attitude), -np.cos(attitude)])
    load = 0.1 * SPEED * 0.1 * 0.03**3 / (8 * CLEARANCE**2 * modified_sommerfeld(np.array(eccentricity)))
    assert film_force(rest, np.zeros(2), SPEED) == pytest.approx([0, load], abs=1e-6 * load)
    stiffness, damping = film_coefficients(np.array(eccentricity))
    step = 1e-4 * CLEARANCE

    def slopes(of_step):
        return np.stack([(of_step(-step * unit) - of_step(step * unit)) / (2 * step) for unit in np.eye(2)], axis=1)

    found = slopes(lambda move: film_force(rest + move, np.zeros(2), SPEED)) * CLEARANCE / load
    assert found == pytest.approx(stiffness, abs=1e-4 * np.abs(stiffness).max())
    found = slopes(lambda move: film_force(rest, SPEED * move, SPEED)) * CLEARANCE / load
    assert found == pytest.approx(damping, abs=1e-4 * np.abs(damping).max())


def test_the_eccentricity_is_the_inverse_of_the_sommerfeld_number():
    sommerfeld = np.logspace(-8, 8, 2001)
    assert modified_sommerfeld(eccentricity_ratio(sommerfeld)) == pytest.approx(sommerfeld, rel=1e-9)


def test_on_stiff_bearings_the_shaft_feels_the_film_alone():
    place = effect("short_journal_bearing", **EXAMPLE).placed_on(PLAIN)
    compliance = 1.3e-8
    clearance = place.clearance(np.array(compliance))
    problem = place.added_to(PLAIN)
    x = np.array([1e15, 1e15, 0.0, 0.0, REFERENCE[4], compliance])
    rotor = rotor_at(PLAIN.rotor, PLAIN.unknowns, x[:5])
    for index, speed in enumerate(PLAIN.speed):
        eccentricity = eccentricity_ratio(0.1 * speed * 0.1 * 0.03**3 / (8 * LOAD * clearance**2))
        a, b = film_coefficients(eccentricity)
        (kxx, kxy), (kyx, kyy) = a * LOAD / clearance
        (cxx, cxy), (cyx, cyy) = b * LOAD / clearance / speed
        film = {"kxx": kxx, "kxy": kxy, "kyx": kyx, "kyy": kyy, "cxx": cxx, "cxy": cxy, "cyx": cyx, "cyy": cyy}
        bearings = tuple(dataclasses.replace(bearing, **film) for bearing in rotor.bearings)
        expected = dense_response(dataclasses.replace(rotor, bearings=bearings), np.array([speed]), PLAIN.channels)
        assert problem.response(x[None])[0, index] == pytest.approx(expected[0], rel=1e-5)


def test_an_unloaded_film_has_the_compliance_that_the_unknown_says_and_swirls_at_half_the_speed():
    """Forward whirl at Ω sees a compliance −i s there: D (iΩ − iΩ/2) with D = 2/(s Ω)."""
    place = effect("short_journal_bearing", **{**EXAMPLE, "loads_n": [1e-3, 1e-3]}).placed_on(PLAIN)
    found = place.film_compliance(PLAIN.speed[-1:], np.array([1e-9]))[:, :, 0, 0, 0] @ np.array([1, -1j])
    assert found == pytest.approx(-1e-9j * np.array([1, -1j]), rel=1e-5)


def test_the_film_is_in_series_with_the_bearings():
    place = effect("short_journal_bearing", load_angle=-30.0).placed_on(PLAIN)
    speed, theta = PLAIN.speed[:3], np.array([[2e-9], [8e-9]])
    rng = np.random.default_rng(0)
    bearing = 1e7 * (rng.standard_normal((2, 2, 2, 2, 3)) + 1j * rng.standard_normal((2, 2, 2, 2, 3)))
    film = np.moveaxis(place.film_compliance(speed, theta[:, 0]), (0, 1), (-2, -1))
    expected = np.linalg.inv(np.linalg.inv(np.moveaxis(bearing, (1, 2), (-2, -1))) + film)
    found = np.moveaxis(place.impedance(bearing, speed, theta), (1, 2), (-2, -1))
    assert found == pytest.approx(expected, rel=1e-9)


def test_a_load_along_x_swaps_the_axes():
    down, along = (effect("short_journal_bearing", load_angle=angle).placed_on(PLAIN) for angle in (-90.0, 0.0))
    theta = np.array([5e-9])
    one, other = (place.film_compliance(PLAIN.speed, theta) for place in (down, along))
    turned = np.array([[one[1, 1], -one[1, 0]], [-one[0, 1], one[0, 0]]])
    assert other == pytest.approx(turned, rel=1e-9, abs=1e-9 * np.abs(one).max())


def test_bearings_share_the_weight_by_levers():
    rotor = PLAIN.rotor
    shares = weight_shares(rotor)
    shaft = [(segment.material.density * segment.area * segment.length, segment.length) for segment in rotor.segments]
    starts = np.cumsum([0.0, *(length for _, length in shaft)])
    masses = [mass for mass, _ in shaft] + [disk.mass for disk in rotor.disks]
    middles = [start + length / 2 for start, (_, length) in zip(starts, shaft)] + [
        disk.position for disk in rotor.disks
    ]
    right = GRAVITY * np.dot(masses, middles) / rotor.length
    assert shares == pytest.approx([GRAVITY * sum(masses) - right, right], rel=1e-9)


def test_one_bearing_alone_needs_its_load():
    rotor = dataclasses.replace(PLAIN.rotor, bearings=PLAIN.rotor.bearings[:1])
    targets = tuple(dataclasses.replace(item, targets=item.targets[:1]) for item in PLAIN.unknowns)
    lonely = dataclasses.replace(PLAIN, rotor=rotor, unknowns=targets)
    assert effect("short_journal_bearing").locations(lonely) == []
    with pytest.raises(SettingError, match="loads_n: expected one of each of 1 bearings"):
        effect("short_journal_bearing").added_to(lonely)
    assert effect("short_journal_bearing", loads_n=[900.0]).placed_on(lonely).diameter == pytest.approx(0.1)
