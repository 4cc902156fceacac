"""Cones, layers, couplings in line, lumped masses and segments with damping or tension of their own: closed forms, invariants, and many
short cylinders as a second route."""

import dataclasses

import numpy as np
import pytest
import scipy.linalg
from scipy.integrate import quad

from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.problem.parameters import Parameter
from problems.rotor.finite_elements import shaft
from problems.rotor.finite_elements.assembly import assemble, assemble_free, displacement_row
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.mesh import element_at, elements
from problems.rotor.finite_elements.sections import rings
from problems.rotor.finite_elements.segments import CouplingSegment, Disk, Layer, Material, ShaftSegment
from problems.rotor.free_motion.modes import eigenpairs
from problems.rotor.response.dense import dense_response
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, Unknown
from tiers import mostly_slow

STEEL = Material(2.1e11, 7850.0, 0.3)
SLEEVE = Material(6895.0, 7850.0, 0.3)  # 1 psi: a mass that carries no load


def frequencies(rotor, speed, n_mode=6):
    found = eigenpairs(assemble(rotor, speed), speed)[0].imag
    return np.sort(found[found > 20.0])[:n_mode]


def cone(n_element=1, **changes):
    given = {"outer_radius_right": 0.02, "inner_radius_right": 0.008, "inner_radius": 0.01, **changes}
    return ShaftSegment(0.3, 0.045, STEEL, n_element, **given)


def steps(segment, n):
    """Cone as n cylinders with the radii of their middles."""

    def at(left, right, fraction):
        return left + ((left if right is None else right) - left) * fraction

    middles = (np.arange(n) + 0.5) / n
    return tuple(
        ShaftSegment(
            segment.length / n,
            at(segment.outer_radius, segment.outer_radius_right, middle),
            segment.material,
            inner_radius=at(segment.inner_radius, segment.inner_radius_right, middle),
        )
        for middle in middles
    )


def test_static_deflection_of_a_cone_is_exact():
    """A held solid cone under a force and a moment at its thin end: ∫ (P a + M) a / EI da, and shear, by an adaptive quadrature."""
    segment = cone(inner_radius=0.0, inner_radius_right=None)
    [ring] = rings(element_at(Rotor((segment,)), 0))

    def radius(z):
        return 0.045 + (0.02 - 0.045) * z / 0.3

    def bending(power):
        return quad(lambda z: (0.3 - z) ** power / (2.1e11 * np.pi / 4 * radius(z) ** 4), 0, 0.3, epsrel=1e-12)[0]

    kappa, modulus = 6 * 1.3 / (7 + 6 * 0.3), 2.1e11 / 2.6
    shear = quad(lambda z: 1 / (kappa * modulus * np.pi * radius(z) ** 2), 0, 0.3, epsrel=1e-12)[0]
    expected = [[bending(2) + shear, bending(1)], [bending(1), bending(0)]]
    np.testing.assert_allclose(ring.flexibility, expected, rtol=1e-9)


def test_a_general_ring_of_constant_section_is_the_cylinder():
    segment = ShaftSegment(0.3, 0.04, STEEL, 2, inner_radius=0.01)
    rotor = Rotor((segment,))
    written_out = Rotor((dataclasses.replace(segment, outer_radius_right=0.04, inner_radius_right=0.01),))
    for one, other in zip(elements(rotor), elements(written_out)):
        first, second = shaft.element_matrices(one), shaft.element_matrices(other)
        for name in ("mass", "gyroscopic", "stiffness"):
            expected = getattr(first, name)
            np.testing.assert_allclose(getattr(second, name), expected, atol=1e-12 * np.abs(expected).max())
    for place in (0.05, 0.11, 0.29):
        row = displacement_row(rotor, place, "30")
        np.testing.assert_allclose(displacement_row(written_out, place, "30"), row, atol=1e-14)
    tension, drag = (
        [make(element_at(each, 0)) for each in (rotor, written_out)] for make in (shaft.geometric_stiffness, shaft.drag)
    )
    for one, other in (tension, drag):
        np.testing.assert_allclose(other, one, atol=1e-12 * np.abs(one).max())


@pytest.mark.parametrize("n_element", mostly_slow([1, 3], but=[1]))
def test_cones_move_like_many_short_cylinders(n_element):
    """Steps of constant section converge with the square of their length: 160 are within 2e-5. One element per cone, whose radius doubles,
    is within its own mesh error of the fourth mode; three are 25 times nearer."""
    middle = ShaftSegment(0.25, 0.045, STEEL, 6)
    carried = {
        "disks": (Disk(0.3, 8.0, 0.05, 0.03),),
        "bearings": (Bearing(0.0, kxx=3e7, kyy=2e7, cxx=2e3, cyy=1e3), Bearing(0.55, kxx=3e7, kyy=3e7)),
    }
    mirrored = cone(n_element, outer_radius_right=0.045, inner_radius_right=0.01)
    mirrored = dataclasses.replace(mirrored, outer_radius=0.02, inner_radius=0.008)
    found = Rotor((mirrored, middle), **carried)
    fine = Rotor((*steps(mirrored, 160), middle), **carried)
    tolerance = {1: 6e-3, 3: 3e-4}[n_element]
    for speed in (0.0, 600.0):
        np.testing.assert_allclose(frequencies(found, speed, 4), frequencies(fine, speed, 4), rtol=tolerance)


def layered():
    sleeve = Layer(0.06, SLEEVE, 0.04)
    hub = Layer(0.075, dataclasses.replace(STEEL, young_modulus=7e10, density=2700.0), 0.06, outer_radius_right=0.065)
    return ShaftSegment(0.4, 0.04, STEEL, 4, layers=(sleeve, hub)), (sleeve, hub)


@pytest.mark.parametrize("segment", [layered()[0], cone(3), cone(2, stiffness_outer_radius=0.03)])
def test_rigid_motions_and_masses(segment):
    rotor = Rotor((segment,))
    matrices, nodes = assemble_free(rotor), rotor.node_positions
    shift = np.tile([1.0, 0.0, 0.0, 0.0], len(nodes))
    tilt = np.ravel([[z, 0.0, 0.0, 1.0] for z in nodes])
    size = np.abs(matrices.stiffness).max()
    assert np.abs(matrices.stiffness @ np.stack([shift, tilt], axis=1)).max() < 1e-10 * size
    assert shift @ matrices.mass @ shift == pytest.approx(segment.mass, rel=1e-10)
    # A tilt turns each section: Ω times the gyroscopic moment of the whole is the polar inertia, by quadrature of the rings
    tilt_y = np.ravel([[0.0, z, -1.0, 0.0] for z in nodes])

    def polar(z):
        parts = [(segment, 1), *((layer, layer.carries != "stiffness") for layer in segment.layers)]
        total = 0.0
        for ring, has_mass in parts:
            large, small = (
                left + ((left if right is None else right) - left) * z / segment.length
                for left, right in (
                    (ring.outer_radius, ring.outer_radius_right),
                    (ring.inner_radius, ring.inner_radius_right),
                )
            )
            total += has_mass * ring.material.density * np.pi / 2 * (large**4 - small**4)
        return total

    expected = quad(polar, 0, segment.length, epsrel=1e-10)[0]
    assert abs(tilt @ matrices.gyroscopic @ tilt_y) == pytest.approx(expected, rel=1e-9)


def test_layers_add_each_with_its_own_shear():
    segment, layers = layered()
    [together] = {element.segment for element in elements(Rotor((segment,)))}
    own = shaft.element_matrices(element_at(Rotor((dataclasses.replace(together, layers=()),)), 0))
    parts = [own]
    for layer in layers:
        alone = ShaftSegment(
            0.4, layer.outer_radius, layer.material, 4, layer.inner_radius, 1.0, layer.outer_radius_right
        )
        parts.append(shaft.element_matrices(element_at(Rotor((alone,)), 0)))
    whole = shaft.element_matrices(element_at(Rotor((segment,)), 0))
    for name in ("mass", "gyroscopic", "stiffness"):
        expected = sum(getattr(part, name) for part in parts)
        np.testing.assert_allclose(getattr(whole, name), expected, atol=1e-11 * np.abs(expected).max())


def test_a_layer_carries_mass_or_stiffness_alone():
    base = ShaftSegment(0.4, 0.04, STEEL, 1)
    plain, both, mass, stiffness = (
        shaft.element_matrices(element_at(Rotor((dataclasses.replace(base, layers=layers),)), 0))
        for layers in ((), *((Layer(0.06, STEEL, 0.04, carries=each),) for each in ("both", "mass", "stiffness")))
    )
    np.testing.assert_allclose(mass.stiffness, plain.stiffness, rtol=1e-9, atol=1.0)
    np.testing.assert_allclose(mass.mass, both.mass)
    np.testing.assert_allclose(stiffness.stiffness, both.stiffness)
    np.testing.assert_allclose(stiffness.mass, plain.mass, rtol=1e-9, atol=1e-9)


def test_a_stiffness_diameter_bends_as_a_thinner_shaft_with_the_mass_of_the_thick_one():
    thick = ShaftSegment(0.4, 0.06, STEEL, 1, stiffness_outer_radius=0.05)
    found = shaft.element_matrices(element_at(Rotor((thick,)), 0))
    thin = shaft.element_matrices(element_at(Rotor((ShaftSegment(0.4, 0.05, STEEL),)), 0))
    np.testing.assert_allclose(found.stiffness, thin.stiffness, atol=1e-12 * np.abs(thin.stiffness).max())
    shift = np.tile([1.0, 0.0, 0.0, 0.0], 2)
    assert shift @ found.mass @ shift == pytest.approx(7850 * np.pi * 0.06**2 * 0.4)


def test_switches_of_inertia_and_shear():
    segment = ShaftSegment(0.2, 0.05, STEEL)
    full, none = (
        shaft.element_matrices(element_at(Rotor((each,)), 0))
        for each in (segment, dataclasses.replace(segment, rotary_inertia=False, gyroscopic=False))
    )
    assert not np.any(none.gyroscopic)
    tilt = np.array([0.0, 0.0, 0.0, 1.0, 0.2, 0.0, 0.0, 1.0])
    assert tilt @ (full.mass - none.mass) @ tilt == pytest.approx(7850 * np.pi / 4 * 0.05**4 * 0.2)
    given = dataclasses.replace(segment, shear_coefficient=6 * 1.3 / (7 + 6 * 0.3))
    own = shaft.element_matrices(element_at(Rotor((given,)), 0))
    np.testing.assert_allclose(own.stiffness, full.stiffness, rtol=1e-12, atol=1e-3)


def test_a_coupling_in_line_is_springs_between_its_ends_and_lumps_on_them():
    """Two rigid-ish shafts on a coupling: its lateral mode is that of two masses on a spring, √(k (1/m₁ + 1/m₂))."""
    stiff = Material(1e15, 1.0, 0.3)
    part = ShaftSegment(0.1, 0.05, stiff)
    coupling = CouplingSegment(0.1, (2e6, 3e6), (1e9, 1e9), masses=(5.0, 3.0), damping=(10.0, 20.0))
    rotor = Rotor((part, coupling, part))
    assert rotor.mass == pytest.approx(8.0, abs=1e-2)
    matrices = assemble(rotor)
    squared = scipy.linalg.eigh(matrices.stiffness, matrices.mass, eigvals_only=True)
    for stiffness in coupling.stiffness:
        ends = [5.0 + part.mass, 3.0 + part.mass]
        expected = stiffness * sum(1 / mass for mass in ends)
        # The ends of the shafts tilt a little about their own middles: 1e-3 of a stiffness of 1e9 N m/rad
        assert np.min(np.abs(squared / expected - 1)) < 0.02
    row = displacement_row(rotor, 0.15, "x")
    assert row[4] == pytest.approx(0.5) and row[8] == pytest.approx(0.5)
    relative = np.zeros(16)
    relative[4], relative[8] = 1.0, -1.0
    assert relative @ matrices.damping @ relative == pytest.approx(4 * 10.0)


def test_lumped_masses_are_disks_that_may_have_inertia_alone():
    segment = ShaftSegment(0.4, 0.03, STEEL, 4)
    disk = Rotor((segment,), disks=(Disk(0.2, 5.0, 0.02, 0.01),))
    lumped = Rotor((segment,), masses=(Disk(0.2, 5.0, 0.0, 0.0, True), Disk(0.2, 0.0, 0.02, 0.01, True)))
    for name in ("mass", "gyroscopic"):
        one, other = (getattr(assemble_free(each), name) for each in (disk, lumped))
        np.testing.assert_allclose(other, one, rtol=1e-15)
    with pytest.raises(SettingError, match="mass of a disk: expected a number above 0"):
        Disk(0.2, 0.0, 0.02, 0.01)


def test_tension_of_a_segment_is_that_of_the_whole_shaft_where_all_have_it():
    segment = ShaftSegment(0.4, 0.01, STEEL, 8)
    bearings = (Bearing(0.0, kxx=1e9, kyy=1e9), Bearing(0.4, kxx=1e9, kyy=1e9))
    each = Rotor((dataclasses.replace(segment, axial_force=4e4),), bearings=bearings)
    whole = Rotor((segment,), bearings=bearings, axial_force=4e4)
    np.testing.assert_allclose(frequencies(each, 0.0), frequencies(whole, 0.0), rtol=1e-9)
    assert frequencies(each, 0.0)[0] > 1.02 * frequencies(Rotor((segment,), bearings=bearings), 0.0)[0]


def test_damping_of_segments_is_that_of_the_whole_shaft_where_all_have_it():
    segment = ShaftSegment(0.4, 0.01, STEEL, 6)
    bearings = (Bearing(0.0, kxx=1e7, kyy=2e7), Bearing(0.4, kxx=1e7, kyy=1e7))
    each = Rotor((dataclasses.replace(segment, internal_damping=2e-5),), bearings=bearings)
    whole = Rotor((segment,), bearings=bearings, internal_damping=2e-5)
    for name in ("damping", "circulatory"):
        one, other = (getattr(assemble(rotor), name) for rotor in (each, whole))
        np.testing.assert_allclose(one, other, atol=1e-12 * np.abs(other).max())
    # On the ground, in proportion to mass and stiffness: ζ = α/2ω + βω/2 of a free shaft, mode by mode
    free = Rotor((dataclasses.replace(segment, standing_damping=(4.0, 1e-6)),))
    values = eigenpairs(assemble(free), 0.0)[0]
    bending = values[values.imag > 500.0]
    for value in bending[np.argsort(bending.imag)][:4]:
        size = abs(value)
        assert -value.real / size == pytest.approx(4.0 / (2 * size) + 1e-6 * size / 2, rel=1e-6)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: cone(outer_radius_right=0.005), "right end: expected 0 <= inner < outer"),
        (lambda: Layer(0.03, STEEL, 0.04), "radii of a layer"),
        (lambda: Layer(0.03, STEEL, 0.02, carries="weight"), "unknown part that a layer carries 'weight'"),
        (lambda: cone(stiffness_outer_radius=0.002), "shaft segment's stiffness"),
        (lambda: CouplingSegment(0.1, (-1.0, 1.0), (1.0, 1.0)), "stiffness of a coupling"),
    ],
)
def test_what_is_no_section_is_refused(make, words):
    with pytest.raises(SettingError, match=words):
        make()


def hysteretic(loss_factor):
    """A shaft on two stiff bearings with external damping, so that its forward mode is driven by the loss factor alone."""
    segment = ShaftSegment(0.4, 0.01, STEEL, 6, loss_factor=loss_factor)
    bearings = (Bearing(0.0, kxx=1e9, kyy=1e9), Bearing(0.4, kxx=1e9, kyy=1e9))
    return Rotor((segment,), bearings=bearings, unbalance=(UnbalancePlane(0.2, 1e-6),))


def test_hysteresis_of_the_turning_shaft_drives_forward_whirl_and_damps_backward_whirl():
    """Of a mode below the spin speed that is all bending, λ² = −ω² (1 ∓ iη): σ = ±ηω/2, forward up, backward down, at any spin."""
    rotor = hysteretic(0.02)
    for speed in (2000.0, 4000.0):
        values = eigenpairs(assemble(rotor, speed), speed)[0]
        lowest = sorted(values[values.imag > 10], key=lambda value: value.imag)[:2]
        backward, forward = sorted(lowest, key=lambda value: value.real)
        assert forward.real == pytest.approx(0.02 * forward.imag / 2, rel=5e-3)  # the bearings bend a little too
        assert backward.real == pytest.approx(-0.02 * backward.imag / 2, rel=5e-3)


def test_a_bent_shaft_that_turns_along_feels_no_hysteresis():
    """Forward motion at 1X is a constant bend of the shaft; on bearings unlike in x and y its backward part is damped."""
    channels = (Channel(0.2, "x"), Channel(0.2, "y"))
    speed = np.linspace(100.0, 900.0, 9)
    plain, lossy = (dense_response(each, speed, channels) for each in (hysteretic(0.0), hysteretic(0.02)))
    np.testing.assert_allclose(lossy, plain, rtol=1e-9)
    unlike = (Bearing(0.0, kxx=1e6, kyy=3e5), Bearing(0.4, kxx=1e6, kyy=3e5))
    both = [
        dense_response(dataclasses.replace(hysteretic(loss), bearings=unlike), speed, channels) for loss in (0.0, 0.02)
    ]
    assert np.abs(both[1] / both[0] - 1).max() > 1e-4


def test_the_reduction_has_hysteresis_as_the_dense_route_has_it():
    rotor = dataclasses.replace(
        hysteretic(0.05), bearings=(Bearing(0.0, kyy=4e5, cxx=50, cyy=80), hysteretic(0).bearings[1])
    )
    unknown = Unknown(Parameter("k", "N/m", 1.0, 1e5, 1e6), (BearingTarget(0, "kxx"),))
    problem = RotorProblem(rotor, (unknown,), np.linspace(100.0, 900.0, 9), (Channel(0.2, "x"), Channel(0.1, "y")))
    x = np.array([[2e5], [7e5]])
    np.testing.assert_allclose(problem.response(x), problem.dense_response(x), rtol=1e-9)
