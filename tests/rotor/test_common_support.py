"""One block under all bearings: it couples them, moves with their bounce, and does not feel their tilting."""

import numpy as np
import pytest

from ksmea.plugins import registry
from problems.rotor.finite_elements.assembly import assemble_free, node_dof
from problems.rotor.finite_elements.bearing import on_common
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk
from rigid_rotor import NATURAL, STIFFNESS, problem_of, rigid_rotor

SPEED = NATURAL * np.array([0.3, 0.9, 1.7])
RIGID = problem_of(rigid_rotor(), SPEED)
SETTINGS = ThreeDisk(sensors=[0.1, 0.5], n_speed=7)
PLAIN = SETTINGS.build()
REFERENCE = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])


def effect(name, **settings):
    return registry.create("effect", name, settings)


def on_block(problem, along_x, along_y, loss_factor):
    both = [effect("foundation_resonance", direction=axis, loss_factor=loss_factor) for axis in ("x", "y")]
    extended = both[1].added_to(both[0].added_to(problem))
    return extended, np.array([*along_x, *along_y])


def test_bearings_on_a_block_are_the_inverse_of_added_compliances():
    """(Z⁻¹ + T A Tᵀ)⁻¹ of all ports, T taking the block to each bearing."""
    rng = np.random.default_rng(0)
    shape = (3, 2, 2, 4, 5)
    impedance = 1e7 * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
    compliance = 1e-8 * (rng.standard_normal((2, 4, 5)) + 1j * rng.standard_normal((2, 4, 5)))
    found = on_common(impedance, compliance).reshape(6, 6, 4, 5)
    carries = np.tile(np.eye(2), (3, 1))
    for n in range(4):
        for frequency in range(5):
            flexibility = np.zeros((6, 6), dtype=complex)
            for bearing in range(3):
                own = slice(2 * bearing, 2 * bearing + 2)
                flexibility[own, own] = np.linalg.inv(impedance[bearing, :, :, n, frequency])
            flexibility += carries @ np.diag(compliance[:, n, frequency]) @ carries.T
            assert found[:, :, n, frequency] == pytest.approx(np.linalg.inv(flexibility), rel=1e-9)


def test_a_rigid_block_is_none_whatever_its_mass():
    extended, _ = on_block(PLAIN, (0, 0), (0, 0), 0.05)
    found = extended.response(np.array([[*REFERENCE, 0.0, 500.0, 0.0, 90.0]]))[0]
    assert found == pytest.approx(PLAIN.response(REFERENCE[None])[0], rel=1e-10)


def test_two_equal_bearings_that_move_alike_stand_on_half_the_block_each():
    """Bounce of a rigid rotor: a block of compliance s and mass m is two pedestals of 2 s and m / 2."""
    spring, mass = 2e-7, 12.0
    extended, theta = on_block(RIGID, (spring, mass), (spring, mass), 0.05)
    pedestals = effect("flexible_pedestal", loss_factor=0.05).added_to(RIGID)
    found = extended.response(np.array([[STIFFNESS, *theta]]))
    expected = pedestals.response(np.array([[STIFFNESS, 2 * spring, 2 * spring, mass / 2]]))
    assert found == pytest.approx(expected, rel=1e-8)
    assert np.abs(found - RIGID.response(np.array([[STIFFNESS]]))).max() > 0.1 * np.abs(found).max()


def test_bearings_that_push_against_each_other_do_not_move_the_block():
    """Tilting of the same rotor, by a moment in its middle: as on the ground, and on pedestals it is not."""
    moment = effect("coupling_misalignment", position=0.3, kind="moment")

    def tilting(problem, theta):
        x = np.array([STIFFNESS, *theta])
        return moment.added_to(problem).response(np.append(x, [5.0, 0.0])[None]) - problem.response(x[None])

    on_ground = tilting(RIGID, [])
    extended, theta = on_block(RIGID, (2e-7, 12.0), (2e-7, 12.0), 0.05)
    assert tilting(extended, theta) == pytest.approx(on_ground, rel=1e-6)
    on_pedestals = tilting(effect("flexible_pedestal", loss_factor=0.02).added_to(RIGID), [4e-7, 4e-7, 6.0])
    assert np.abs(on_pedestals - on_ground).max() > 0.1 * np.abs(on_ground).max()


def test_one_axis_moves_and_the_other_does_not():
    found = effect("foundation_resonance", direction="y").added_to(RIGID)
    response = found.response(np.array([[STIFFNESS, 2e-7, 12.0]]))[0]
    plain = RIGID.response(np.array([[STIFFNESS]]))[0]
    assert response[:, 0] == pytest.approx(plain[:, 0], rel=1e-9)
    assert np.all(np.abs(response[:, 1] - plain[:, 1]) > 0.02 * np.abs(plain[:, 1]))


def all_eigenvalues(speed, spring, mass, loss_factor):
    """Of the whole rotor on a block with its own two degrees of freedom, (n,) 1/s."""
    rotor = rotor_at(PLAIN.rotor, PLAIN.unknowns, REFERENCE)
    free = assemble_free(rotor)
    n = len(free.mass)
    inertia, damping, stiffness = np.zeros((3, n + 2, n + 2), dtype=complex)
    inertia[:n, :n], damping[:n, :n], stiffness[:n, :n] = free.mass, speed * free.gyroscopic, free.stiffness
    block = n + np.arange(2)
    inertia[block, block] = mass
    stiffness[block, block] = (1 + 1j * loss_factor) / np.array(spring)
    for bearing in rotor.bearings:
        ends = np.zeros((2, n + 2))
        ends[[0, 1], node_dof(rotor.node_at(bearing.position, "bearing"))[:2]] = 1.0
        ends[[0, 1], block] = -1.0
        stiffness += ends.T @ bearing.stiffness @ ends
        damping += ends.T @ bearing.damping @ ends
    top = np.hstack([np.zeros_like(stiffness), np.eye(n + 2)])
    return np.linalg.eigvals(np.vstack([top, -np.linalg.solve(inertia, np.hstack([stiffness, damping]))]))


def test_growth_is_that_of_all_degrees_of_freedom():
    spring, mass = (1e-8, 4e-9), (150.0, 400.0)
    extended, theta = on_block(PLAIN, (spring[0], mass[0]), (spring[1], mass[1]), 0.05)
    speeds = np.array([150.0, 700.0, 1500.0])
    found = extended.growth_rate(np.append(REFERENCE, theta), speeds)
    for speed, growth in zip(speeds, found):
        values = all_eigenvalues(speed, spring, mass, 0.05)
        expected = values.real[(values.imag >= 0) & (np.abs(values) < 6000.0)].max()
        # as in test_stability.py: rounding of the eigenvalues of a matrix whose norm is 1e12, and what the reduction leaves out
        assert growth == pytest.approx(expected, rel=3e-3, abs=3e-4)
