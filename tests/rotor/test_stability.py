"""Stability: thresholds in closed form, all eigenvalues of a state matrix with every degree of freedom, and the contract."""

import dataclasses

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.problem.problem import Problem
from ksmea.rotordynamics.stability import lowest_unstable_speed
from problems.rotor.extension.effect import RotorEffect
from problems.rotor.finite_elements.assembly import assemble_free, node_dof
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk
from rigid_rotor import DAMPING, NATURAL, STIFFNESS, problem_of, rigid_rotor

HIGHEST = 600.0  # rad/s
SETTINGS = ThreeDisk(sensors=[0.1], n_speed=9)
PLAIN = SETTINGS.build()
REFERENCE = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])


def effect(name, **settings):
    return registry.create("effect", name, settings)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_cross_coupling_is_stable_up_to_damping_times_frequency(sign):
    """κ = c ω_n on isotropic bearings, of either sign and at any spin speed: the bounce of a rigid rotor."""
    problem = effect("cross_coupling_antisymmetric").added_to(problem_of(rigid_rotor(), HIGHEST))
    critical = sign * DAMPING * NATURAL
    # 1e-3 on either side: flexibility of the shaft and tilting move the bounce by less than 1e-5
    assert problem.stability_threshold(np.array([STIFFNESS, 0.999 * critical]), HIGHEST) == np.inf
    assert problem.stability_threshold(np.array([STIFFNESS, 1.001 * critical]), HIGHEST) == 0.0


def test_coefficients_are_functions_of_the_spin_speed_and_not_of_the_whirl_frequency():
    """Damping c (1 + b Ω/Ω₁) that falls to κ / ω_n: the bounce whirls at ω_n, and becomes unstable at another speed."""
    problem = problem_of(rigid_rotor(), HIGHEST)
    falling = effect("speed_dependent_damping", full_speed=HIGHEST)
    problem = effect("cross_coupling_antisymmetric").added_to(falling.added_to(problem))
    slope, part = -0.8, 0.7  # κ = 0.7 c ω_n
    found = problem.stability_threshold(np.array([STIFFNESS, slope, part * DAMPING * NATURAL]), HIGHEST)
    assert found == pytest.approx(HIGHEST * (1 - part) / -slope, rel=1e-3) and abs(found - NATURAL) > 50


@pytest.mark.parametrize("ratio", [0.0, 0.5, 2.0])
def test_internal_damping_is_stable_up_to_a_speed_above_the_critical_one(ratio):
    """Ω = ω_n (1 + c_e/c_i) of a Jeffcott rotor, c_e on the disk and c_i = β k (Friswell et al. 2010, section 7.3)."""
    light = Material(young_modulus=2e11, density=1e-3, poisson_ratio=0.3)
    half = ShaftSegment(0.5, 0.01, light, 1)
    stiffness = 48 * 2e11 * half.second_moment  # N/m, of a simply supported shaft of 1 m; it shears by 2e-4 more
    beta = 1e-5
    external = ratio * beta * stiffness
    bearings = (
        Bearing(0.0, kxx=1e10, kyy=1e10),
        Bearing(1.0, kxx=1e10, kyy=1e10),
        Bearing(0.5, cxx=external, cyy=external),
    )
    rotor = Rotor((half, half), (Disk(0.5, 10.0, 1e-4, 1e-4),), bearings)
    problem = effect("internal_damping").added_to(problem_of(rotor, HIGHEST))
    frequency = np.sqrt(stiffness / 10.0)
    found = problem.stability_threshold(np.array([1e10, beta]), 4 * frequency)
    # 1e-3: shear, and bearings 1e5 times as stiff as the shaft
    assert found == pytest.approx(frequency * (1 + ratio), rel=1e-3)


def all_eigenvalues(rotor, speed, spring=None, mass=0.0, loss_factor=0.0):
    """Of the whole rotor with a pedestal under each bearing where `spring` (2,) m/N is given, (n,) rad/s."""
    free = assemble_free(rotor)
    n, n_pedestal = len(free.mass), 0 if spring is None else 2 * len(rotor.bearings)
    mass_matrix, damping, stiffness = np.zeros((3, n + n_pedestal, n + n_pedestal), dtype=complex)
    mass_matrix[:n, :n] = free.mass
    damping[:n, :n] = free.damping + speed * free.gyroscopic
    stiffness[:n, :n] = free.stiffness + speed * free.circulatory
    for index, bearing in enumerate(rotor.bearings):
        ends = node_dof(rotor.node_at(bearing.position, "bearing"))[:2][:, None] == np.arange(n + n_pedestal)
        ends = ends.astype(float)  # motion of the shaft less that of the pedestal
        if n_pedestal:
            pedestal = n + 2 * index + np.arange(2)
            ends[[0, 1], pedestal] = -1.0
            mass_matrix[pedestal, pedestal] = mass
            stiffness[pedestal, pedestal] += (1 + 1j * loss_factor) / np.asarray(spring)
        stiffness += ends.T @ bearing.stiffness @ ends
        damping += ends.T @ bearing.damping @ ends
    top = np.hstack([np.zeros_like(stiffness), np.eye(len(stiffness))])
    return np.linalg.eigvals(np.vstack([top, -np.linalg.solve(mass_matrix, np.hstack([stiffness, damping]))]))


def largest_growth(eigenvalues, highest=6000.0):
    """The largest growth rate of motions that whirl with ω from 0 to the frequency that the reduction keeps, 1/s."""
    return eigenvalues.real[(eigenvalues.imag >= 0) & (np.abs(eigenvalues) < highest)].max()


SPEEDS = np.array([150.0, 700.0, 1500.0])
# 1/s: rounding of eigenvalues of the whole state matrix, whose norm is 1e12, and what the reduction leaves out
NEAR = {"rel": 3e-3, "abs": 3e-4}


@pytest.mark.parametrize("cross", [0.0, 2e5, 1e6])
def test_growth_is_that_of_all_degrees_of_freedom(cross):
    rotor = rotor_at(PLAIN.rotor, PLAIN.unknowns, REFERENCE)
    bearings = tuple(dataclasses.replace(bearing, kxy=cross, kyx=-cross) for bearing in rotor.bearings)
    for beta in (0.0, 2e-5):
        problem = effect("internal_damping").added_to(effect("cross_coupling_antisymmetric").added_to(PLAIN))
        found = problem.growth_rate(np.array([*REFERENCE, cross, beta]), SPEEDS)
        whole = dataclasses.replace(rotor, bearings=bearings, internal_damping=beta)
        expected = [largest_growth(all_eigenvalues(whole, speed)) for speed in SPEEDS]
        assert found == pytest.approx(expected, **NEAR)


@pytest.mark.parametrize("spring, mass", [((1e-8, 1.3e-8), 20.0), ((2e-8, 1e-9), 60.0), ((1e-12, 1e-12), 1e-2)])
@pytest.mark.parametrize("cross", [0.0, 1e6])
def test_pedestals_take_part_at_the_frequency_of_the_whirl(spring, mass, cross):
    rotor = rotor_at(PLAIN.rotor, PLAIN.unknowns, REFERENCE)
    bearings = tuple(dataclasses.replace(bearing, kxy=cross, kyx=-cross) for bearing in rotor.bearings)
    whole = dataclasses.replace(rotor, bearings=bearings)
    pedestal = effect("flexible_pedestal", loss_factor=0.05)
    problem = effect("cross_coupling_antisymmetric").added_to(pedestal.added_to(PLAIN))
    found = problem.growth_rate(np.array([*REFERENCE, *spring, mass, cross]), SPEEDS)
    expected = [largest_growth(all_eigenvalues(whole, speed, spring, mass, 0.05)) for speed in SPEEDS]
    assert found == pytest.approx(expected, **NEAR)


@pytest.mark.parametrize("theta", [(0.0, 0.0, 0.0), (0.0, 0.0, 30.0), (1e-15, 1e-15, 1e-9)])
def test_pedestals_that_are_rigid_or_without_mass_change_nothing(theta):
    pedestal = effect("flexible_pedestal", loss_factor=0.02).added_to(PLAIN)
    found = pedestal.growth_rate(np.array([*REFERENCE, *theta]), SPEEDS)
    assert found == pytest.approx(PLAIN.growth_rate(REFERENCE, SPEEDS), rel=1e-5)


def test_pedestals_without_mass_are_springs_in_series():
    """On undamped bearings, for then springs in series are one softer spring: η apart, which is next to nothing here."""
    stiff, soft = 5e7, 1 / (1 / 5e7 + 1e-8)
    x = np.array([stiff, stiff, 0.0, 0.0, 2e-4])
    pedestal = effect("flexible_pedestal", loss_factor=1e-9)
    problem = effect("internal_damping").added_to(pedestal.added_to(PLAIN))
    found = problem.growth_rate(np.array([*x, 1e-8, 1e-8, 0.0, 2e-5]), SPEEDS)
    softer = effect("internal_damping").added_to(PLAIN)
    expected = softer.growth_rate(np.array([soft, soft, 0.0, 0.0, 2e-4, 2e-5]), SPEEDS)
    assert found == pytest.approx(expected, rel=1e-4)


@dataclasses.dataclass(frozen=True)
class Push(RotorEffect):
    """An effect of someone else that acts through the impedance alone: a force ahead of the motion, over speed."""

    couples_axes = True

    def parameters(self, problem):
        return effect("cross_coupling_antisymmetric").parameters(problem)

    def draw(self, problem, rng):
        return np.array([1e5])

    def impedance(self, impedance, speed, theta):
        changed = impedance.copy()
        changed[:, 0, 1] += theta[:, :1] * speed / HIGHEST
        changed[:, 1, 0] -= theta[:, :1] * speed / HIGHEST
        return changed


def test_an_effect_of_someone_else_counts_as_its_impedance_has_it():
    problem = Push().added_to(problem_of(rigid_rotor(), HIGHEST))
    found = problem.stability_threshold(np.array([STIFFNESS, 2 * DAMPING * NATURAL]), HIGHEST)
    assert found == pytest.approx(HIGHEST / 2, rel=1e-3)


def test_without_any_damping_no_motion_grows():
    assert PLAIN.growth_rate(np.array([5e7, 7e7, 0.0, 0.0, 2e-4]), SPEEDS) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("mass, is_stable", [(3.0, True), (-3.0, False)])
def test_a_shaft_that_carries_less_inertia_than_none_is_not_stable(mass, is_stable):
    """3 kg on a radius of gyration of 0.5 m are more than the shaft between two disks has: no motion exists without them. A little
    cross-coupling keeps the rotor from being called passive."""
    problem = effect("added_mass", position=0.35, inertia="assumed", radius=0.5).added_to(PLAIN)
    problem = effect("cross_coupling_antisymmetric").added_to(problem)
    assert problem.is_stable(np.append(REFERENCE, [mass, 1.0])) is is_stable


def test_negative_damping_is_unstable_from_rest():
    assert PLAIN.stability_threshold(np.array([5e7, 7e7, -100.0, 100.0, 2e-4]), 1500.0) == 0.0


@pytest.mark.parametrize("onset", [3.0, 100.0, 999.0])
def test_the_lowest_speed_of_growth_is_found_wherever_it_lies(onset):
    assert lowest_unstable_speed(lambda speed: speed - onset, 1000.0) == pytest.approx(onset, abs=2e-3)


def test_no_growth_up_to_the_highest_speed_is_infinite_and_growth_from_rest_zero():
    assert lowest_unstable_speed(lambda speed: speed - 1001.0, 1000.0) == np.inf
    assert lowest_unstable_speed(np.ones_like, 1000.0) == 0.0


def test_a_problem_that_cannot_tell_says_so():
    class Line(Problem):
        def response(self, x):
            return x

    assert not Line().knows_stability and PLAIN.knows_stability
    with pytest.raises(SettingError, match="knows its damped eigenvalues, got Line"):
        Line().stability_threshold(REFERENCE, 100.0)
