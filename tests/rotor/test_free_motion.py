"""Critical speeds, followed modes and layouts: closed forms, published numbers, and second routes."""

import dataclasses

import numpy as np
import pytest

from ksmea import load_problem
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.rotordynamics.whirl import direction_of_whirl
from ksmea.studies.rotordynamics import RotordynamicsOptions, critical_speeds, rotordynamics
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.free_motion.critical_speeds import critical_speeds as of_whole_rotor
from problems.rotor.free_motion.modes import undamped_critical_speeds
from problems.three_disk import ThreeDisk
from published_rotor import PUBLISHED_CRITICALS, published
from rigid_rotor import STIFFNESS, problem_of, rigid_rotor
from tilting_rotor import HALF_SPAN, rigid_properties, tilting_rotor
from tilting_rotor import STIFFNESS as OF_TILTING

RPM = np.pi / 30
THREE_DISK = load_problem("three_disk")
PLAIN = ThreeDisk(sensors=[0.1], n_speed=9).build()
REFERENCE = THREE_DISK.x()


def effect(name, **settings):
    return registry.create("effect", name, settings)


def drawn(problem, x, **options):
    return rotordynamics(problem, np.asarray(x), RotordynamicsOptions(**options), title="rotor")


def test_a_simply_supported_beam_has_its_closed_form_critical_speeds():
    """Ω_n = (nπ/L)² √(EI/ρA), Euler and Bernoulli's, of a beam so slender (r/L = 1/400) that shear, rotary inertia and
    gyroscopic moments change the third by (3π r/2L)² (3 + E/κG)/2, which is 4e-4."""
    length, radius, steel = 2.0, 0.005, Material(2e11, 7800.0, 0.3)
    beam = Rotor((ShaftSegment(length, radius, steel, 24),), bearings=(Bearing(0.0), Bearing(length)))
    expected = [
        (n * np.pi / length) ** 2 * np.sqrt(steel.young_modulus / steel.density) * radius / 2 for n in (1, 2, 3)
    ]
    for found in undamped_critical_speeds(beam, 1e10):  # 1e5 times the beam's own stiffness
        assert found[:3] == pytest.approx(expected, rel=5e-4)


def test_a_rigid_rotor_has_its_closed_form_critical_speeds_forward_and_backward():
    """Bounce at √(2k/M) both ways, pitch at √(2ka²/(I_d ∓ I_p)): forward, backward."""
    rotor = tilting_rotor()
    mass, polar, diametral = rigid_properties(rotor)
    bounce, arm = np.sqrt(2 * OF_TILTING / mass), 2 * HALF_SPAN**2 * OF_TILTING
    forward, backward = undamped_critical_speeds(rotor, OF_TILTING)
    assert forward[:2] == pytest.approx(
        sorted([bounce, np.sqrt(arm / (diametral - polar))]), rel=2e-5
    )  # the shaft is rigid
    assert backward[:2] == pytest.approx(sorted([bounce, np.sqrt(arm / (diametral + polar))]), rel=2e-5)


def test_a_thin_disk_on_a_jeffcott_rotor_has_no_forward_tilting_critical_speed():
    """A disk in the middle of a massless shaft: bounce at √(k/m), tilting backward at √(k_t/(I_d + I_p)), forward at
    √(k_t/(I_d − I_p)) for a long disk and nowhere for a thin one; k = 48EI/L³, k_t = 12EI/L on pinned ends."""
    light, length, radius = Material(2e11, 1e-6, 0.3), 1.0, 0.01
    half = ShaftSegment(length / 2, radius, light, 2, shear_flexibility=0.0)
    bending = light.young_modulus * half.second_moment
    for polar, diametral in ((0.02, 0.01), (0.01, 0.03)):
        disk = Disk(length / 2, 5.0, polar_inertia=polar, diametral_inertia=diametral)
        rotor = Rotor((half, half), (disk,), (Bearing(0.0), Bearing(length)))
        forward, backward = (found[found < 1e4] for found in undamped_critical_speeds(rotor, 1e10))
        bounce = np.sqrt(48 * bending / length**3 / disk.mass)
        tilting = 12 * bending / length
        # 1e-5: bearings of 1e10 N/m, and a shaft of 1e-9 kg
        assert backward == pytest.approx([bounce, np.sqrt(tilting / (diametral + polar))], rel=1e-5)
        further = [np.sqrt(tilting / (diametral - polar))] if diametral > polar else []
        assert forward == pytest.approx([bounce, *further], rel=1e-5)


def test_the_scan_and_the_direct_eigenproblem_find_the_same_undamped_critical_speeds():
    rotor = published()
    alike = dataclasses.replace(
        rotor, bearings=tuple(Bearing(each.position, kxx=6e7, kyy=6e7, cxx=900.0, cyy=900.0) for each in rotor.bearings)
    )
    free = problem_of(alike, 1500.0).free_rotor(np.array([6e7]), 4000.0)
    found = critical_speeds(free, np.linspace(1.0, 3000.0, 101), [1.0])
    direct = {
        name: each[each < 3000.0] for name, each in zip(("forward", "backward"), undamped_critical_speeds(alike, 6e7))
    }
    for direction, expected in direct.items():
        # 1e-5: the scan sees the rotor by its lowest modes
        assert [each.undamped for each in found if each.direction == direction] == pytest.approx(
            list(expected), rel=1e-5
        )


def test_published_critical_speeds_are_found_with_their_damping():
    """Lalanne & Ferraris; and of the whole rotor's own eigenvalues, to 1e-5: the scan sees it by its lowest modes."""
    found = drawn(THREE_DISK.problem, THREE_DISK.x(), highest_rpm=26_000, harmonics=[1.0]).critical_speeds
    for each, (expected, tolerance) in zip(found, PUBLISHED_CRITICALS.items(), strict=True):
        assert each.speed / RPM == pytest.approx(expected, rel=tolerance)
        assert each.undamped / RPM == pytest.approx(expected, rel=tolerance)
    assert [each.speed for each in found] == pytest.approx(of_whole_rotor(published(), 26_000 * RPM), rel=1e-5)
    modes = THREE_DISK.modes(found[0].speed, n_mode=1)
    assert found[0].damping_ratio == pytest.approx(modes[0].damping_ratio, rel=1e-4)
    assert found[0].amplification_factor == pytest.approx(1 / (2 * modes[0].damping_ratio), rel=1e-4)


def test_the_amplification_factor_is_that_of_the_response():
    """Of a lightly damped rotor the width of the peak at 1/√2 of its height is Ω/AF."""
    first = drawn(THREE_DISK.problem, THREE_DISK.x(), highest_rpm=3700, harmonics=[1.0]).critical_speeds[0]
    width = first.speed / first.amplification_factor
    speed = first.speed + np.linspace(-1.5, 1.5, 301) * width
    response = np.abs(THREE_DISK.response(speed=speed)[:, 0])
    above = speed[response >= response.max() / np.sqrt(2)]
    assert above[-1] - above[0] == pytest.approx(width, rel=0.03)  # steps of 1 %, and 1 − dω/dΩ of 1 % here
    assert speed[np.argmax(response)] == pytest.approx(first.speed, abs=0.02 * width)


def test_effects_at_zero_change_nothing():
    extended = effect("cross_coupling_antisymmetric").added_to(
        effect("flexible_pedestal", loss_factor=0.02).added_to(PLAIN)
    )
    speed = np.array([100.0, 1000.0])
    own = PLAIN.free_rotor(REFERENCE, 2000.0).frequencies(speed)[:, -20:]
    x = np.append(REFERENCE, np.zeros(len(extended.parameters) - len(REFERENCE)))
    found = extended.free_rotor(x, 2000.0).frequencies(speed)
    # 1e-6: supports without mass or compliance have eigenvalues at infinity beside these
    assert found[:, -20:] == pytest.approx(own, rel=1e-6)


def test_on_pedestals_the_response_peaks_at_the_critical_speeds():
    extended = effect("flexible_pedestal", loss_factor=0.02).added_to(PLAIN)
    x = np.append(REFERENCE, [1e-8, 5e-9, 40.0])
    found = drawn(extended, x, highest_rpm=9000, harmonics=[1.0])
    assert "support" in found.layout.support and len(found.critical_speeds) == 3
    for each in found.critical_speeds:
        width = each.speed / each.amplification_factor
        near = each.speed + np.linspace(-1, 1, 41) * width
        response = np.abs(extended.at(near, extended.channels).response(x[None])[0]).max(axis=1)
        assert near[np.argmax(response)] == pytest.approx(each.speed, abs=0.1 * width)


def test_the_log_decrement_falls_below_zero_at_the_stability_threshold():
    problem = effect("internal_damping").added_to(problem_of(rigid_rotor(), 600.0))
    problem = effect("cross_coupling_antisymmetric").added_to(problem)
    falling = effect("speed_dependent_damping", full_speed=600.0).added_to(problem)
    x = np.array([STIFFNESS, 0.0, 0.6 * 300.0 * np.sqrt(2 * STIFFNESS / 20.0), -0.8])
    found = drawn(falling, x, highest_rpm=600 / RPM, speeds=201)
    least = np.nanmin(found.branches.log_decrement, axis=1)
    growing = found.branches.speed[least < 0]
    assert 0 < found.threshold < 600
    assert growing[0] == pytest.approx(found.threshold, abs=600 / 200)  # the next scanned speed


def test_modes_that_cross_keep_their_direction():
    """On isotropic bearings every mode is a circle at all speeds. Frequencies of forward ones rise, those of backward ones fall;
    the bounce of a rotor that is alike on both sides has the same both ways, of which every sum is a motion too."""
    rotor = tilting_rotor()
    alike = Rotor(published().segments, published().disks, tuple(Bearing(z, kxx=6e7, kyy=6e7) for z in (0.0, 1.3)))
    for isotropic, highest in ((rotor, 40_000), (alike, 40_000)):
        problem = problem_of(isotropic, 3000.0)
        branches = drawn(problem, np.array([isotropic.bearings[0].kxx]), modes=6, highest_rpm=highest).branches
        for frequency, direction in zip(branches.frequency[1:].T, branches.direction[1:].T):
            there = np.isfinite(frequency)
            assert len(set(direction[there])) == 1
            # 1e-6: the bounce that does not change with speed
            assert np.all(direction[there][0] * np.diff(frequency[there]) > -1e-6 * frequency[there][:-1])
    order = np.argsort(branches.frequency[[1, -1]], axis=1)
    assert not np.array_equal(*order)  # some did cross


def test_a_motion_that_hardly_moves_next_to_a_node_does_not_make_a_mode_mixed():
    x = np.array([1.0, 0.5, 0.01, -0.5, -1.0])
    y = -1j * x
    y[2] *= -1
    assert direction_of_whirl(x, y) == "forward" and direction_of_whirl(x, -y) == "backward"
    assert direction_of_whirl(x, 0 * y) == "mixed"


def test_a_direction_of_whirl_is_the_same_in_all_that_is_drawn():
    """Bearings seven times as stiff in y as in x: of the third mode nine tenths of the squared amplitudes at the nodes whirl backward,
    and less at 201 places along the shaft. What a mode is called must not depend on where it is looked at. Second route: the modes of
    the whole matrices."""
    x, rpm = np.array([1.39e7, 1e8, 500.0, 700.0, 2e-4]), 17298.0
    shapes = drawn(PLAIN, x, modes=6, speed_rpm=rpm).shapes
    assert direction_of_whirl(*shapes.motions.shape[2].T) == "mixed"  # so that there is something to be seen
    assert shapes.directions == tuple(mode.whirl for mode in PLAIN.modes(x, rpm * RPM, 6))
    assert shapes.directions[2] == "backward"


def test_overdamped_motions_are_no_critical_speeds():
    rotor = published()
    damped = tuple(dataclasses.replace(each, cxx=1e8, cyy=1e8) for each in rotor.bearings)
    free = problem_of(dataclasses.replace(rotor, bearings=damped), 1500.0)
    found = drawn(free, np.array([rotor.bearings[0].kxx]), harmonics=[1.0])
    assert all(each.damping_ratio < np.sqrt(0.5) for each in found.critical_speeds)


def test_a_disk_is_drawn_as_the_ring_that_it_is():
    layout = THREE_DISK.problem.free_rotor(THREE_DISK.x(), 1000.0).layout(100.0)
    assert [disk.outer_radius for disk in layout.disks] == pytest.approx([0.12, 0.20, 0.20])  # Table 1 of the paper
    assert [disk.thickness for disk in layout.disks] == pytest.approx([0.05, 0.05, 0.06])
    density, length, radius = 7800.0, 1.3, 0.05
    assert layout.mass == pytest.approx(density * np.pi * radius**2 * length + sum(disk.mass for disk in layout.disks))
    point = Rotor(published().segments, (Disk(0.2, 5.0, 0.0, 0.0),), published().bearings)
    [disk] = problem_of(point, 100.0).free_rotor(np.array([5e7]), 1000.0).layout(100.0).disks
    assert disk.outer_radius is None and disk.thickness == 0.0


def test_effects_that_no_linear_eigenproblem_has_are_told():
    found = drawn(effect("shaft_asymmetry").added_to(PLAIN), np.append(REFERENCE, [0.01, 0.0]), modes=2)
    assert found.remarks == ("Free motions leave out shaft asymmetry, whose stiffness turns with the shaft.",)
    assert found.layout.effects[0].name == "shaft asymmetry"


def test_what_cannot_be_drawn_is_refused():
    with pytest.raises(SettingError, match="knows its rotor"):
        drawn(load_problem("three_disk").parameters, [0.0])
    with pytest.raises(SettingError, match="stiffness_to"):
        RotordynamicsOptions(stiffness_from=5.0, stiffness_to=1.0)
    with pytest.raises(SettingError, match="harmonics"):
        RotordynamicsOptions(harmonics=[])
    one = dataclasses.replace(published(), bearings=published().bearings[:1])
    held_by_one = problem_of(dataclasses.replace(one, bearings=(one.bearings[0], Bearing(0.0))), 1000.0)
    assert drawn(held_by_one, np.array([5e7]), modes=2).speed_map is None


def test_an_extended_rotor_knows_its_critical_speeds_and_modes():
    """Effects at zero change nothing: 1e-5 is how far modes in a reduced space are true. On pedestals the study finds the same."""
    extended = effect("cross_coupling_antisymmetric").added_to(PLAIN)
    x = np.append(REFERENCE, np.zeros(len(extended.parameters) - len(REFERENCE)))
    highest = 9000 * RPM
    assert extended.critical_speeds(x, highest) == pytest.approx(PLAIN.critical_speeds(REFERENCE, highest), rel=1e-5)
    own, found = PLAIN.modes(REFERENCE, 300.0, 4), extended.modes(x, 300.0, 4)
    assert [each.frequency for each in found] == pytest.approx([each.frequency for each in own], rel=1e-5)
    assert [each.whirl for each in found] == [each.whirl for each in own]
    assert [each.shape.shape for each in found] == [each.shape.shape for each in own]
    speed = np.array([100.0, 300.0])
    assert extended.campbell(x, speed, 4).frequency == pytest.approx(
        PLAIN.campbell(REFERENCE, speed, 4).frequency, rel=1e-5
    )
    softer, at = effect("flexible_pedestal", loss_factor=0.02).added_to(PLAIN), np.append(REFERENCE, [1e-8, 5e-9, 40.0])
    of_study = [each.speed for each in drawn(softer, at, highest_rpm=9000, harmonics=[1.0]).critical_speeds]
    assert set(np.round(of_study, 3)) <= set(np.round(softer.critical_speeds(at, highest), 3))
