"""Natural frequencies, whirl and critical speeds: the published rotor, and rigid rotors in closed form."""

import numpy as np
import pytest

from problems.rotor.finite_elements.assembly import assemble, assemble_free
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Material
from problems.rotor.free_motion.critical_speeds import _crossings, critical_speeds
from problems.rotor.free_motion.modes import frequency_curves, natural_modes
from problems.three_disk import ThreeDisk
from published_rotor import PUBLISHED_CRITICALS, published
from tilting_rotor import DAMPING, HALF_SPAN, STIFFNESS, rigid_properties, tilting_rotor

RPM = np.pi / 30
STEEL = Material(young_modulus=200e9, density=7800.0, poisson_ratio=0.3)


# Lalanne & Ferraris, Rotordynamics Prediction in Engineering: the example rotor, isotropic shaft on two bearings.
PUBLISHED_FREQUENCIES = (55.41, 67.21, 157.9, 193.7, 249.9, 407.6)  # Hz at 25 000 rpm


def test_published_frequencies():
    found = [mode.frequency / (2 * np.pi) for mode in natural_modes(published(), 25_000 * RPM, 6)]
    # 0.05 %: four printed digits, and a mesh and shear coefficient that the book does not share in detail.
    assert found == pytest.approx(PUBLISHED_FREQUENCIES, rel=5e-4)


def test_published_critical_speeds():
    found = critical_speeds(published(), 26_000 * RPM) / RPM
    assert len(found) == len(PUBLISHED_CRITICALS)
    # As above; the fifth was printed without damping, which moves it by 0.10 %.
    for speed, (expected, tolerance) in zip(found, PUBLISHED_CRITICALS.items(), strict=True):
        assert speed == pytest.approx(expected, rel=tolerance)


def test_response_peaks_at_the_critical_speeds():
    settings = ThreeDisk()
    problem = settings.build()
    x = np.array(list(settings.reference().values()))
    criticals = critical_speeds(published(), 5_000 * RPM)
    # Damping ratios near 4e-4 give half-widths of 0.15 rad/s, so a step of 0.01 rad/s resolves each peak.
    for critical in criticals:
        near = critical + np.linspace(-1.0, 1.0, 201)
        amplitude = np.abs(problem.at(near, problem.channels).response(x[None])[0]).max(axis=1)
        assert near[np.argmax(amplitude)] == pytest.approx(critical, abs=0.05)


def test_whole_rotor_has_symmetric_mass_and_stiffness_and_skew_gyroscopics():
    matrices = assemble_free(published())
    for matrix, sign in ((matrices.mass, 1), (matrices.stiffness, 1), (matrices.gyroscopic, -1)):
        assert np.allclose(matrix, sign * matrix.T, rtol=0, atol=1e-14 * np.abs(matrix).max())
    coupled = Rotor(published().segments, bearings=(Bearing(0.0, kxy=2.0, kyx=3.0, cxy=5.0, cyx=7.0),))
    on_bearing, free = assemble(coupled), assemble_free(coupled)
    assert np.allclose((on_bearing.stiffness - free.stiffness)[:2, :2], [[0, 2], [3, 0]], atol=1e-5)
    assert np.array_equal((on_bearing.damping - free.damping)[:2, :2], [[0, 5], [7, 0]])


def on_isotropic_bearings(stiffness=5e7, damping=200.0):
    bearings = [Bearing(z, kxx=stiffness, kyy=stiffness, cxx=damping, cyy=damping) for z in (0.0, 1.3)]
    rotor = published()
    return Rotor(rotor.segments, rotor.disks, tuple(bearings), rotor.unbalance)


def test_whirl_pairs_meet_at_standstill_on_isotropic_bearings():
    modes = natural_modes(on_isotropic_bearings(), 0.0, 6)
    frequency = np.array([mode.frequency for mode in modes])
    # 1e-9: rounding of the eigenvalue solver on a spectrum that reaches 1e6 rad/s.
    assert np.allclose(frequency[::2], frequency[1::2], rtol=1e-9)


def test_spin_parts_the_pairs_into_backward_and_forward():
    still = [mode.frequency for mode in natural_modes(on_isotropic_bearings(), 0.0, 4)]
    spinning = natural_modes(on_isotropic_bearings(), 1000.0, 4)
    assert [mode.whirl for mode in spinning] == ["backward", "forward", "backward", "forward"]
    for pair in (slice(0, 2), slice(2, 4)):
        backward, forward = (mode.frequency for mode in spinning[pair])
        assert backward < still[pair][0] < forward


def test_reversed_spin_swaps_the_direction():
    ahead, behind = (natural_modes(on_isotropic_bearings(), speed, 4) for speed in (1000.0, -1000.0))
    assert [mode.frequency for mode in ahead] == pytest.approx([mode.frequency for mode in behind], rel=1e-9)
    assert [mode.whirl for mode in behind] == ["forward", "backward", "forward", "backward"]


def test_shapes_are_scaled_to_a_largest_deflection_of_one():
    for mode in natural_modes(published(), 500.0, 4):
        assert mode.shape.shape == (14, 4)
        assert np.abs(mode.shape[:, :2]).max() == pytest.approx(1.0)


def test_rigid_rotor_in_closed_form():
    # Bounce: M λ² + 2cλ + 2k = 0. Pitch: I_d λ² − i I_p Ω λ + 2a²(cλ + k) = 0 in the complex tilt, whose solutions
    # with Im λ > 0 whirl forward and with Im λ < 0 backward.
    rotor, speed = tilting_rotor(), 400.0
    mass, polar, diametral = rigid_properties(rotor)
    bounce = np.roots([mass, 2 * DAMPING, 2 * STIFFNESS])
    arm = 2 * HALF_SPAN**2
    pitch = np.roots([diametral, arm * DAMPING - 1j * polar * speed, arm * STIFFNESS])
    expected = [(abs(root.imag), -root.real / abs(root)) for root in [*bounce, *pitch]]
    found = [(mode.frequency, mode.damping_ratio) for mode in natural_modes(rotor, speed, 4)]
    assert np.allclose(sorted(found), sorted(expected), rtol=1e-4)
    fastest = natural_modes(rotor, speed, 4)[-1]
    assert fastest.frequency == pytest.approx(pitch.imag.max(), rel=1e-4)
    assert fastest.whirl == "forward"


def test_rigid_critical_speeds_in_closed_form():
    # Bounce meets the spin at √(2k/M) in both whirls, pitch at √(2ka²/(I_d ± I_p)); undamped.
    rotor = tilting_rotor()
    undamped = Rotor(
        rotor.segments,
        rotor.disks,
        tuple(Bearing(b.position, kxx=1.001 * STIFFNESS, kyy=0.999 * STIFFNESS) for b in rotor.bearings),
    )
    mass, polar, diametral = rigid_properties(rotor)
    arm = 2 * HALF_SPAN**2 * STIFFNESS
    bounce = np.sqrt(2 * STIFFNESS * np.array([0.999, 1.001]) / mass)
    pitch = np.sqrt(arm / (diametral + np.array([polar, -polar])))
    found = critical_speeds(undamped, 400.0)
    # 2e-5 for the rigid shaft; the 0.1 % of anisotropy that parts the bounce pair moves pitch in its square.
    assert found == pytest.approx(np.sort([*bounce, *pitch]), rel=2e-5)


def test_overdamped_motion_is_no_mode():
    rotor = tilting_rotor()
    heavy = tuple(
        Bearing(b.position, kxx=STIFFNESS, kyy=STIFFNESS, cxx=1e5, cyy=1e5) for b in rotor.bearings
    )  # damping ratio far above 1 for bounce and pitch
    lowest = natural_modes(Rotor(rotor.segments, rotor.disks, heavy), 0.0, 1)[0]
    mass, _, _ = rigid_properties(rotor)
    assert lowest.frequency > 100 * np.sqrt(2 * STIFFNESS / mass)


@pytest.mark.parametrize("damping", [0.0, 500.0, 2e4, 3e5])  # N s/m: none, that of Table 1, and such as locks a bearing
def test_critical_speeds_are_those_of_all_eigenvalues(damping):
    rotor = on_isotropic_bearings(damping=damping)
    scanned = np.linspace(0.0, 2000.0, 41)[1:]
    # all degrees of freedom, each crossing by Brent's method to 1e-10
    expected = _crossings(frequency_curves(assemble(rotor)), scanned)
    assert critical_speeds(rotor, 2000.0, 40) == pytest.approx(expected, rel=1e-9)


def test_a_problem_tells_critical_speeds_modes_and_its_campbell_diagram_at_values_of_its_unknowns():
    settings = ThreeDisk()
    problem = settings.build()
    x = np.array([settings.reference()[name] for name in problem.parameters.names])
    assert np.array_equal(problem.critical_speeds(x, 5_000 * RPM), critical_speeds(published(), 5_000 * RPM))
    assert problem.critical_speeds(x) == pytest.approx(critical_speeds(published(), 1500.0))
    speed = np.array([0.0, 900.0])
    diagram = problem.campbell(x, speed, n_mode=4)
    assert diagram.frequency.shape == diagram.damping_ratio.shape == (2, 4)
    for spin, frequency, ratio in zip(speed, diagram.frequency, diagram.damping_ratio):
        modes = problem.modes(x, spin, 4)
        assert frequency == pytest.approx([mode.frequency for mode in modes], rel=1e-9)
        assert ratio == pytest.approx([mode.damping_ratio for mode in modes], rel=1e-6)
