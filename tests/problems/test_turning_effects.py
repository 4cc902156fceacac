"""Stiffness that turns with the shaft: closed forms, integration over time, and what it does to measurements."""

import dataclasses

import numpy as np
import pytest
import scipy

from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.load import Load
from problems.rotor.extension.turning import GRAVITY, port_forces, weight_of
from problems.rotor.finite_elements.assembly import assemble, assemble_free, displacement_row
from problems.rotor.finite_elements.data import Hub
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk

HARMONICS = (1.0, 2.0, 3.0)
PLAIN = ThreeDisk(sensors=[0.5], n_speed=20).build()
ISOTROPIC = np.array([60e6, 60e6, 1e-3, 1e-3, 2e-4])  # as good as undamped
EPSILON = 0.05


def effect(name, **settings):
    return registry.create("effect", name, settings)


def through(problem, harmonics=HARMONICS, speed=None):
    channels = [Channel(0.5, axis, harmonic) for harmonic in harmonics for axis in "xy"]
    return problem.at(problem.speed if speed is None else np.asarray(speed), channels)


def response(place, theta, x, problem):
    return place.added_to(problem).response(np.concatenate([x, theta])[None])[0]


def stiffer(part, x, problem):
    return response(effect("youngs_modulus"), [part], x, problem)


@pytest.mark.parametrize("sign", [1, -1])
def test_an_unbalance_along_an_axis_of_an_asymmetric_shaft_meets_its_stiffness_there(sign):
    """On isotropic bearings without damping nothing leaves that axis: the shaft is one with E (1 ± ε). Four shapes of bending
    leave out a seventieth of what that changes up to the first critical speeds."""
    speed = np.array([50.0, 150.0, 300.0])
    problem = through(PLAIN, (1.0,), speed)
    found = response(effect("shaft_asymmetry"), [sign * EPSILON, 0.0], ISOTROPIC, problem)
    expected, without = stiffer(sign * EPSILON, ISOTROPIC, problem), problem.response(ISOTROPIC[None])[0]
    assert np.abs(found - expected) == pytest.approx(0, abs=0.02 * np.abs(expected - without).max())
    assert np.abs(found - without).max() > 0.01 * np.abs(without).max()


def test_slow_rolling_sag_is_seen_twice_a_turn():
    """The sag is g/k along the axes: at low speed 2X is half the difference of the sags of two shafts with E (1 ± ε), and turns
    forward. Where the stiffer axis ξ starts horizontal, the sag is largest a quarter turn later: y = −s̄ + … cos 2φ."""
    problem = through(PLAIN, speed=[0.01])
    found = response(effect("shaft_asymmetry"), [EPSILON, 0.0], ISOTROPIC, problem)[0]

    def sag(part):
        material = PLAIN.rotor.segments[0].material
        scaled = dataclasses.replace(material, young_modulus=(1 + part) * material.young_modulus)
        rotor = rotor_at(PLAIN.rotor, PLAIN.unknowns, ISOTROPIC)
        rotor = dataclasses.replace(
            rotor, segments=tuple(dataclasses.replace(s, material=scaled) for s in rotor.segments)
        )
        down = np.linalg.solve(assemble(rotor).stiffness, weight_of(rotor, -np.pi / 2))
        return displacement_row(rotor, 0.5, "y") @ down

    expected = (sag(EPSILON) - sag(-EPSILON)) / 2  # above 0: less far down where it is stiffer
    assert found[3] == pytest.approx(-expected, rel=0.02)  # of four shapes of bending
    assert found[2] == pytest.approx(1j * found[3], rel=1e-4)  # (1, −i) times a number: forward
    assert np.abs(found[4:]).max() < 1e-4 * abs(expected)  # no 3X of the weight


def test_the_weight_of_a_rotor_is_its_mass():
    down = weight_of(PLAIN.rotor, -np.pi / 2).reshape(-1, 4)
    mass = sum(s.material.density * s.area * s.length for s in PLAIN.rotor.segments) + sum(
        d.mass for d in PLAIN.rotor.disks
    )
    assert down[:, 1].sum() == pytest.approx(-GRAVITY * mass, rel=1e-9)
    assert np.abs(down[:, 0]).max() < 1e-9 * GRAVITY * mass


@pytest.mark.parametrize("name", ["shaft_asymmetry", "crack"])
def test_2x_peaks_at_half_of_a_critical_speed(name):
    """The weight is the force that meets the natural frequency at twice the speed."""
    critical = PLAIN.critical_speeds(np.array([60e6, 60e6, 5e3, 5e3, 2e-4]), 600.0)[-1]
    speed = np.linspace(0.4, 0.6, 401) * critical
    problem = through(PLAIN, (1.0, 2.0), speed)
    found = response(effect(name).locations(problem)[0], [0.02, 0.0], np.array([60e6, 60e6, 5e3, 5e3, 2e-4]), problem)
    peak = speed[np.argmax(np.abs(found[:, 2]))]
    # gyroscopic moments are those of half the speed, which moves a natural frequency of this rotor by some per cent
    assert peak == pytest.approx(critical / 2, rel=0.03)


# A Jeffcott rotor, on which effects act by the same numbers: ports are its x and y.

MASS, SPRING, DAMPER, SPEED, FORCE, WEIGHT = 1.0, 1.0, 0.1, 0.37, 0.2, 1.0


def per_port(place, theta):
    """κ_m (1, n_order, 2, 2) of one shape of bending, in units of the spring."""
    whole = place.turning_stiffness(PLAIN.rotor, np.array([theta]))
    n_shape = whole.shape[-1] // 2
    return SPRING * whole[:, :, ::n_shape, ::n_shape]


def hill(turning, spring=(SPRING, SPRING)):
    """Orders 0 to 3 of its motion, (4, 2): forces at its ports move it by P_h each."""
    inverse = [
        np.diag([1 / (k - (h * SPEED) ** 2 * MASS + 1j * h * SPEED * DAMPER) for k in spring])[None, None]
        for h in range(4)
    ]
    forces = np.zeros((4, 2), complex)
    forces[0], forces[1] = [0, -WEIGHT], np.array([1, -1j]) * FORCE / 2
    motion = [(each @ force)[..., :] for each, force in zip(inverse, forces)]
    added = port_forces(inverse, motion, [np.zeros((1, 1, 2, 2))] * 4, turning)
    return np.array([(w + (p @ f[..., None])[..., 0])[0, 0] for w, p, f in zip(motion, inverse, added)])


def integrated(stiffness, spring=(SPRING, SPRING)):
    """Integrated response after the free motion has died away, by Fourier's integral over 16 turns.

    It has decayed by e^{−0.05 · 1 000}.
    """

    def slope(t, state):
        q, v = state[:2], state[2:]
        force = FORCE * np.array([np.cos(SPEED * t), np.sin(SPEED * t)]) - [0, WEIGHT]
        return np.concatenate([v, (force - DAMPER * v - np.array(spring) * q - stiffness(SPEED * t) @ q) / MASS])

    turns = np.arange(16 * 256) / 256 + 60
    time = 2 * np.pi * turns / SPEED
    found = scipy.integrate.solve_ivp(slope, (0, time[-1]), np.zeros(4), "DOP853", time, rtol=1e-9, atol=1e-12).y[:2]
    return np.array([np.mean(found * np.exp(-2j * np.pi * h * turns), axis=1) for h in range(4)])


def along(angle):
    n = np.array([np.cos(angle), np.sin(angle)])
    return np.outer(n, n)


def test_an_asymmetric_jeffcott_rotor_moves_as_integrated_over_time():
    """Isotropic supports: nothing is cut off, and 1X and 2X are right within the integration."""
    size, angle = 0.2, 0.4
    found = hill(per_port(effect("shaft_asymmetry"), size * np.array([np.cos(2 * angle), np.sin(2 * angle)])))
    expected = integrated(lambda phi: SPRING * size * (along(phi + angle) - along(phi + angle + np.pi / 2)))
    assert np.abs(found - expected).max() < 1e-7 * np.abs(expected).max()
    assert np.abs(expected[2]).max() > 0.05 and np.abs(expected[3]).max() < 1e-9


def test_on_other_supports_what_is_cut_off_is_small():
    """Backward 1X becomes 3X, and that 5X, which is left out: ε² of a part that moves little so far above its critical speed."""
    size, spring = 0.1, (1.0, 1.3)
    found = hill(per_port(effect("shaft_asymmetry"), [size, 0.0]), spring)
    expected = integrated(lambda phi: SPRING * size * (along(phi) - along(phi + np.pi / 2)), spring)
    assert np.abs(found - expected).max() < 3e-3 * np.abs(expected).max()
    assert np.abs(expected[3]).max() > 1e-3


def test_a_cracked_jeffcott_rotor_moves_as_integrated_over_time():
    """Open where it points down, closed half a turn later, written out. Orders from 4 on are left out: 4X is near 3X times the loss."""
    loss, angle = 0.1, 0.7
    element = effect("crack", position=0.45, length=0.1)
    found = hill(per_port(element, loss * np.array([np.cos(angle), np.sin(angle)])))

    def lost(phi):
        opening = (1 - np.sin(phi + angle)) / 2
        return -SPRING * loss * opening * along(phi + angle)

    expected = integrated(lost)
    assert np.abs(found - expected).max() < 3e-3 * np.abs(expected).max()
    assert all(np.abs(expected[h]).max() > 1e-3 for h in (1, 2, 3))


@pytest.mark.parametrize(
    ("phi", "direction", "part"),
    [(-np.pi / 2, "y", 1.0), (-np.pi / 2, "x", 0.0), (0.0, "x", 0.5), (0.0, "y", 0.0), (np.pi / 2, "y", 0.0)],
)
def test_a_crack_softens_the_shaft_as_a_hub_stiffens_it(phi, direction, part):
    """At standstill, by κ(φ) = κ_0 + 2 Re Σ κ_m e^{imφ}, open when it points down, half open along x, closed upwards: on two supports
    a load bends the shaft further as a hub of stiffening −s, −s/2 and 0 does there, which covers parts of three elements. That the
    moment in each is its mean one leaves out (0.1 m/0.45 m)²/12 of it, as the moment grows from the support on."""
    rotor, crack, loss = PLAIN.rotor, effect("crack", position=0.45, length=0.12), 0.3
    load = displacement_row(rotor, 0.8, direction)
    ends = 1e12 * sum(np.outer(row, row) for z in (0.0, 1.3) for row in [displacement_row(rotor, z, d) for d in "xy"])

    def deflection(stiffness):
        return load @ np.linalg.solve(stiffness + ends, load)

    rows = crack.turning_rows(rotor)
    kappa = crack.turning_stiffness(rotor, np.array([[loss, 0.0]]))[0]
    orders = np.arange(1, len(kappa))[:, None, None]
    whole = assemble_free(rotor).stiffness
    found = deflection(whole + rows.T @ (kappa[0] + 2 * (kappa[1:] * np.exp(1j * orders * phi)).sum(0)).real @ rows)
    softer = dataclasses.replace(rotor, hubs=(Hub(0.45, 0.12, -part * loss),)) if part else rotor
    expected = deflection(assemble_free(softer).stiffness)
    assert found - deflection(whole) == pytest.approx(expected - deflection(whole), rel=5e-3, abs=1e-6 * expected)
    assert not part or expected > 1.01 * deflection(whole)


def test_a_crack_does_not_ask_how_the_shaft_is_cut():
    """Twice and four times as many elements move its change of the motion by what they move the rotor's own resonances."""
    x, theta = np.array([60e6, 60e6, 5e3, 5e3, 2e-4]), [0.3, 0.2]
    speed = np.linspace(60.0, 200.0, 15)

    def change(mesh):
        problem = through(ThreeDisk(sensors=[0.5], mesh=mesh).build(), speed=speed)
        return response(effect("crack", position=0.5), theta, x, problem) - problem.response(x[None])[0]

    coarse, finer, finest = map(change, (13, 26, 52))
    assert np.abs(finer - finest).max() < 0.01 * np.abs(finest).max()
    assert np.abs(coarse - finest).max() < 0.04 * np.abs(finest).max()


@pytest.mark.parametrize("length", [1e-6, 2.0])
def test_the_length_of_a_crack_is_one_of_the_shaft(length):
    with pytest.raises(SettingError, match="length: expected one of the shaft"):
        effect("crack", position=0.5, length=length).added_to(PLAIN)


def test_a_misaligned_coupling_acts_twice_a_turn_where_that_is_measured():
    """A 2X force of its own: that of a unit load at twice the frequency, by the matrices written out; by both routes, and beside a
    crack, whose orders it meets."""
    problem = through(PLAIN, (1.0, 2.0), [120.0, 310.0])
    place = effect("coupling_misalignment").locations(problem)[0]
    assert place.twice and not effect("coupling_misalignment").locations(PLAIN)[0].twice
    found = response(place, [0.0, 0.0, 30.0, 40.0], ISOTROPIC, problem)
    assert found[:, :2] == pytest.approx(problem.response(ISOTROPIC[None])[0][:, :2], rel=1e-9)
    whole = assemble(rotor_at(PLAIN.rotor, PLAIN.unknowns, ISOTROPIC))
    rows = np.array([displacement_row(PLAIN.rotor, place.position, axis) for axis in "xy"])
    read = np.array([displacement_row(PLAIN.rotor, 0.5, axis) for axis in "xy"])
    for index, spin in enumerate(problem.speed):
        stiffness = (
            whole.stiffness - (2 * spin) ** 2 * whole.mass + 2j * spin * (whole.damping + spin * whole.gyroscopic)
        )
        expected = read @ np.linalg.solve(stiffness, rows.T @ np.array([1, -1j]) * (30 + 40j))
        assert found[index, 2:] == pytest.approx(expected, rel=1e-9)
    both = effect("crack").added_to(place.added_to(problem))
    x = np.concatenate([ISOTROPIC, [3.0, 4.0, 30.0, 40.0, 0.2, 0.1]])[None]
    assert both.response(x) == pytest.approx(both.dense_response(x), rel=1e-6, abs=1e-12)


def test_they_are_tried_where_harmonics_were_measured():
    problem = through(PLAIN)
    noise, values = Noise(0.05, 1e-7), np.ones((20, 6), complex)
    whole = Measurement(problem.speed, problem.channels, values, noise, "test")
    for name in ("crack", "shaft_asymmetry"):
        assert effect(name).seen_in(whole) == effect(name)
        assert effect(name).seen_in(whole.through([0, 1])) is None


def test_there_is_no_response_to_unit_loads_of_which_multiples_are_taken():
    problem = effect("crack").added_to(PLAIN)
    with pytest.raises(SettingError, match="expected none that turns together with unit loads"):
        problem.load_response(np.append(ISOTROPIC, [0.1, 0.0])[None], [Load(0.5, "x")])
    stop = effect("local_force", position=0.5, law="cubic_spring")
    with pytest.raises(SettingError, match="together with a stiffness that turns with the shaft"):
        stop.added_to(problem)
