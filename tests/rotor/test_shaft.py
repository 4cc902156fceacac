"""The shaft element against closed forms of beam theory."""

import numpy as np
import pytest
import scipy.linalg

from beams import natural_frequencies, pinned
from problems.rotor.finite_elements import shaft
from problems.rotor.finite_elements.assembly import assemble_free, displacement_row, node_dof
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.mesh import elements, locate
from problems.rotor.finite_elements.segments import Material, ShaftSegment

STEEL = Material(young_modulus=200e9, density=7800.0, poisson_ratio=0.3)
ROUNDING = 1e-9  # of results: rounding of stiffnesses that differ by several orders of magnitude


def uniform(n_element, length=1.0, outer_radius=0.1, inner_radius=0.0):
    return Rotor((ShaftSegment(length, outer_radius, STEEL, n_element, inner_radius),))


def shear_stiffness(segment):  # N
    return shaft.shear_coefficient(segment) * STEEL.shear_modulus * segment.area


def without(matrices, dof):
    """The matrices of a rotor some of whose degrees of freedom are held."""
    keep = np.setdiff1d(np.arange(len(matrices.mass)), dof)
    return matrices.on(np.eye(len(matrices.mass))[:, keep])


def test_shear_coefficient_of_known_sections():
    # Cowper 1966: a solid circle 6(1 + ν)/(7 + 6ν), a thin tube 2(1 + ν)/(4 + 3ν).
    nu = STEEL.poisson_ratio
    solid, tube = ShaftSegment(1.0, 0.1, STEEL), ShaftSegment(1.0, 0.1, STEEL, inner_radius=0.1 * (1 - 1e-6))
    assert shaft.shear_coefficient(solid) == pytest.approx(6 * (1 + nu) / (7 + 6 * nu), rel=1e-14)
    # The coefficient is even about the limit m → 1 up to terms of (1 − m)², here 1e-12.
    assert shaft.shear_coefficient(tube) == pytest.approx(2 * (1 + nu) / (4 + 3 * nu), rel=1e-10)


@pytest.mark.parametrize("inner_radius", [0.0, 0.06])
def test_symmetry(inner_radius):
    matrices = assemble_free(uniform(3, inner_radius=inner_radius))
    for symmetric in (matrices.mass, matrices.stiffness):
        assert np.allclose(symmetric, symmetric.T, rtol=0, atol=1e-14 * np.abs(symmetric).max())
    assert np.allclose(
        matrices.gyroscopic, -matrices.gyroscopic.T, rtol=0, atol=1e-14 * np.abs(matrices.gyroscopic).max()
    )
    assert np.abs(matrices.gyroscopic).max() > 0


def rigid_motions(rotor, about):
    """Unit translation in x and y, unit rotation about the x and y axes through z = `about`; (n_dof, 4)."""
    motion = np.zeros((len(rotor.node_positions), 4, 4))
    arm = rotor.node_positions - about
    motion[:, 0, 0] = motion[:, 1, 1] = 1
    motion[:, 1, 2], motion[:, 2, 2] = -arm, 1  # φ_x turns z into −y
    motion[:, 0, 3], motion[:, 3, 3] = arm, 1  # φ_y turns z into x
    return motion.reshape(-1, 4)


def test_rigid_motion_costs_nothing_and_has_the_mass_of_a_cylinder():
    rotor = uniform(4, length=1.2, inner_radius=0.04)
    segment, matrices = rotor.segments[0], assemble_free(rotor)
    motion = rigid_motions(rotor, about=0.6)
    assert np.abs(matrices.stiffness @ motion).max() < ROUNDING * np.abs(matrices.stiffness).max()

    mass = STEEL.density * segment.area * segment.length
    radii_squared = segment.outer_radius**2 + segment.inner_radius**2
    diametral = mass * (3 * radii_squared + segment.length**2) / 12
    polar = mass * radii_squared / 2
    assert np.allclose(
        motion.T @ matrices.mass @ motion, np.diag([mass, mass, diametral, diametral]), atol=1e-10 * mass
    )
    expected = np.zeros((4, 4))
    expected[2, 3], expected[3, 2] = polar, -polar
    assert np.allclose(motion.T @ matrices.gyroscopic @ motion, expected, atol=1e-12 * mass)


@pytest.mark.parametrize("n_element", [1, 3])
@pytest.mark.parametrize("direction", ["x", "y"])
def test_cantilever_deflects_as_in_closed_form_anywhere(n_element, direction):
    # A tip load F: w(z) = F z²(3L − z)/(6EI) + F z/(κGA). It is the element's own shape, so any mesh is exact,
    # and so is interpolation between nodes.
    rotor = uniform(n_element)
    segment, force = rotor.segments[0], 1e4
    held = without(assemble_free(rotor), node_dof(0))
    load = displacement_row(rotor, 1.0, direction)[4:] * force
    motion = np.concatenate([np.zeros(4), np.linalg.solve(held.stiffness, load)])
    for z in (0.13, 0.5, 0.77, 1.0):
        bending = force * z**2 * (3 - z) / (6 * STEEL.young_modulus * segment.second_moment)
        expected = bending + force * z / shear_stiffness(segment)
        assert displacement_row(rotor, z, direction) @ motion == pytest.approx(expected, rel=ROUNDING)


def test_interpolation_passes_through_the_nodes():
    rotor = uniform(3)
    for node, position in enumerate(rotor.node_positions):
        row = displacement_row(rotor, position, "y")
        assert np.allclose(row, np.eye(16)[4 * node + 1], atol=1e-14)


def test_rotation_is_the_slope_less_the_constant_shear():
    element = elements(uniform(2))[0]
    length, phi, step = element.length, shaft.shear_parameter(element), 1e-5
    fractions = np.array([0.2, 0.5, 0.9])
    ahead, behind = (shaft.deflection_shapes(length, phi, fractions + sign * step) for sign in (1, -1))
    slope = (ahead - behind) / (2 * step * length)
    shear = slope - shaft.rotation_shapes(length, phi, fractions)
    expected = -phi / (1 + phi) * np.array([1 / length, 0.5, -1 / length, 0.5])
    # Central differences of a cubic err by its third derivative: 12 step² / 6 per length.
    assert np.allclose(shear, expected, atol=1e-8)


def test_locating_a_position():
    rotor = uniform(4)
    assert locate(rotor, 0.0) == (0, 0.0)
    assert locate(rotor, 1.0) == (3, 1.0)
    assert locate(rotor, 0.6) == (2, pytest.approx(0.4))


def rotating_beam_frequencies(segment, order, speed):
    """Whirl frequencies of a pinned Timoshenko shaft in its `order`-th sine, forward positive, rising, rad/s.

    With w = W sin βz and ψ = Ψ cos βz, both complex for the two planes:
    (κGA β² − ρA ω²) W − κGA β Ψ = 0 and −κGA β W + (EI β² + κGA − ρI ω² + 2ρI Ω ω) Ψ = 0.
    """
    beta, shear = order * np.pi / segment.length, shear_stiffness(segment)
    mass, inertia = STEEL.density * segment.area, STEEL.density * segment.second_moment
    translation = [-mass, 0, shear * beta**2]
    rotation = [-inertia, 2 * inertia * speed, STEEL.young_modulus * segment.second_moment * beta**2 + shear]
    return np.sort(np.roots(np.polysub(np.polymul(translation, rotation), [(shear * beta) ** 2])).real)


@pytest.mark.parametrize("speed", [0.0, 3000.0])
def test_frequencies_of_a_pinned_shaft_with_shear_and_gyroscopics(speed):
    coarse, fine = (natural_frequencies(pinned(uniform(n_element)), speed)[:4] for n_element in (16, 32))
    bending = [np.abs(rotating_beam_frequencies(uniform(1).segments[0], order, speed)[1:3]) for order in (1, 2)]
    # Richardson's extrapolation takes off the second order of the mesh; what remains is of fourth order, for the
    # second sine (2π/16)⁴/720 = 3e-5 on the coarse mesh.
    assert np.allclose((4 * fine - coarse) / 3, np.sort(np.concatenate(bending)), rtol=3e-5)
    if speed:
        backward, forward = bending[0]
        assert forward - backward > 0.01 * forward  # gyroscopics matter far more than the tolerance


@pytest.mark.parametrize(("outer_radius", "order"), [(0.1, 2), (1e-3, 4)])
def test_order_of_convergence(outer_radius, order):
    # Order 2 where shear counts, 4 in the slender limit (see problems.rotor.finite_elements.shaft).
    exact = rotating_beam_frequencies(uniform(1, outer_radius=outer_radius).segments[0], 2, 0.0)[2]
    errors = []
    for n_element in (4, 8, 16):
        matrices = pinned(uniform(n_element, outer_radius=outer_radius))
        squares = scipy.linalg.eigh(matrices.stiffness, matrices.mass, eigvals_only=True)
        errors.append(np.sqrt(squares[2]) / exact - 1)  # squares 0 and 1 are the first sine in x and y
    assert min(errors) > 0  # a conforming mesh is too stiff
    measured = np.log2(np.array(errors[:-1]) / errors[1:])
    # The next order still shows on the coarser pair by some tenths.
    assert measured == pytest.approx(order, abs=0.25)
    assert abs(measured[1] - order) < 0.1


def test_slender_shaft_is_eulers():
    # ω = (π/L)² √(EI/ρA); shear and rotary inertia take off (πr/2L)²(1 + E/κG)/2 = 5e-6 at r/L = 1/1000, and the
    # mesh adds (π/8)⁴/1440 = 2e-5.
    rotor = uniform(8, outer_radius=1e-3)
    segment = rotor.segments[0]
    euler = np.pi**2 * np.sqrt(STEEL.young_modulus * segment.second_moment / (STEEL.density * segment.area))
    assert natural_frequencies(pinned(rotor), 0.0)[0] == pytest.approx(euler, rel=5e-5)
