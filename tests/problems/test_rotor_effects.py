"""Effects that change the shaft, and a mass on it: closed forms of beam theory."""

import dataclasses

import numpy as np
import pytest

from beams import euler_load, frequencies_of_a_pinned_beam, natural_frequencies, pinned, uniform
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.plugins import registry
from ksmea.problem.parameters import Parameter
from problems.rotor.finite_elements.assembly import assemble_free, displacement_row, node_dof
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import Hub, Rotor, UnbalancePlane
from problems.rotor.finite_elements.segments import Disk, MassChange
from problems.rotor.finite_elements.shaft import shear_coefficient
from problems.rotor.free_motion.modes import natural_modes
from problems.rotor.free_motion.static_load import buckling_load
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, Unknown
from problems.three_disk import ThreeDisk

SETTINGS = ThreeDisk(sensors=[0.1, 0.2, 0.5], n_speed=14)
PLAIN = SETTINGS.build()
REFERENCE = np.array([SETTINGS.reference()[name] for name in PLAIN.parameters.names])
STIFF = 1e12  # N/m: a pin beside shafts of 1e5 N/m and less


def effect(name, **settings):
    return registry.create("effect", name, settings)


def on_pins(rotor):
    ends = (Bearing(0.0, kxx=STIFF, kyy=STIFF), Bearing(rotor.length, kxx=STIFF, kyy=STIFF))
    return dataclasses.replace(rotor, bearings=ends)


def changed(name, rotor, value, **settings):
    return effect(name, **settings).rotor(rotor, np.array([value]))


def held(rotor, dof):
    """Stiffness without held degrees of freedom, and which are left."""
    left = np.setdiff1d(np.arange(4 * len(rotor.node_positions)), dof)
    return assemble_free(rotor).stiffness[np.ix_(left, left)], left


# a mass


@pytest.mark.parametrize("position", [0.0, 0.2, 0.75])
def test_an_added_mass_is_a_disk_without_moments_of_inertia(position):
    fine = ThreeDisk(mesh=26, sensors=[0.1, 0.2, 0.5], n_speed=14).build()  # with a node at 0.75 m
    heavier = dataclasses.replace(fine.rotor, disks=(*fine.rotor.disks, Disk(position, 4.0, 0.0, 0.0)))
    expected = dataclasses.replace(fine, rotor=heavier).response(REFERENCE[None])
    found = effect("added_mass", position=position).added_to(fine).response(np.append(REFERENCE, 4.0)[None])
    assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()


@pytest.mark.parametrize("inertia", ["none", "assumed", "free"])
def test_mass_may_be_missing_only_where_there_is_some(inertia):
    """Whatever its limits admit, beside a lighter disk too, each motion has a positive kinetic energy."""
    drawn = dataclasses.replace(PLAIN, is_as_drawn=True)
    for place, is_bare in ((0.2, False), (0.0, True), (0.35, True)):
        added = effect("added_mass", position=place, inertia=inertia).placed_on(drawn)
        lower, upper = np.transpose([(item.lower, item.upper) for item in added.parameters(drawn)])
        assert (lower[0] == 0.0) == is_bare
        assert upper[0] == pytest.approx(0.1 * drawn.rotor.mass)
        for corner in (np.concatenate([lower[:1], upper[1:]]), lower):
            lightest = added.rotor(drawn.rotor, corner)
            if not is_bare:
                lightest = effect("disk_mass", position=place).placed_on(drawn).rotor(lightest, np.array([-0.3]))
            segments = tuple(dataclasses.replace(each, n_element=12) for each in lightest.segments)
            mass = assemble_free(dataclasses.replace(lightest, segments=segments)).mass
            assert np.linalg.eigvalsh(mass).min() > 0


@pytest.mark.parametrize("position", [0.0, 0.5, 0.77])
@pytest.mark.parametrize("mass", [4.0, -2.0])
def test_an_added_mass_may_have_moments_of_inertia(position, mass):
    """As a disk of that mass and size, which is lighter in its place where mass is missing."""
    at = [disk for disk in PLAIN.rotor.disks if disk.position == position]
    radius = np.sqrt(at[0].polar_inertia / at[0].mass) if at else 0.1 * np.sqrt(5 / 8)
    shape = at[0].diametral_inertia / at[0].polar_inertia if at else 0.5
    polar = 1.5 * mass * radius**2
    fine = ThreeDisk(mesh=26, sensors=[0.1, 0.2, 0.5], n_speed=14).build()
    exact = MassChange(
        0.75 if position == 0.77 else position, mass, polar, shape * polar, True, offset=0.02 * (position == 0.77)
    )
    expected = dataclasses.replace(fine, rotor=dataclasses.replace(fine.rotor, masses=(exact,))).response(
        REFERENCE[None]
    )
    free = effect("added_mass", position=position, inertia="free")
    found = free.added_to(fine).response(np.append(REFERENCE, [mass, 1.5])[None])
    assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
    assumed = effect("added_mass", position=position, inertia="assumed", radius=radius * np.sqrt(1.5))
    found = assumed.added_to(fine).response(np.append(REFERENCE, mass)[None])
    assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()


def test_masses_with_inertia_are_looked_for_on_rotors_that_were_drawn():
    drawn = dataclasses.replace(PLAIN, is_as_drawn=True)
    found = [str(place) for place in effect("added_mass").locations(drawn)]
    assert len(found) == 12 and found[6] == "at 0.2 m with a radius of gyration of 91.9 mm"
    assert found[9] == "at 0 m with a radius of gyration of 79.1 mm"  # a sleeve of 100 and 200 mm
    [free] = effect("added_mass").locations(drawn)[6].kin(drawn)
    assert free.inertia == "free" and free.kin(drawn) == [] and len(free.parameters(drawn)) == 2


def test_places_that_differ_by_rounding_are_one():
    rotor = dataclasses.replace(PLAIN.rotor, disks=(*PLAIN.rotor.disks, Disk(0.2 + 1e-12, 1.0, 1e-3, 1e-3)))
    assert len(effect("added_mass").locations(dataclasses.replace(PLAIN, rotor=rotor))) == 6


def test_masses_are_looked_for_on_disks_ends_and_long_spans():
    found = [str(place) for place in effect("added_mass").locations(PLAIN)]
    assert found == ["at 0.2 m", "at 0.5 m", "at 1 m", "at 0 m", "at 1.3 m", "at 0.75 m"]
    assert effect("added_mass").added_to(PLAIN).effects[0].position == 0.2


# an axial force


@pytest.mark.parametrize("part", [-0.5, 0.7])  # of the buckling load
def test_tension_raises_the_frequencies_of_a_pinned_beam_and_compression_lowers_them(part):
    """ω_n² = (nπ/L)⁴ EI/μ + (nπ/L)² N/μ of Euler and Bernoulli; a cubic element errs by (nπ/16)⁴/720."""
    beam = uniform(16, radius=1e-3, shear_flexibility=0.0)
    force = part * euler_load(beam)
    found = natural_frequencies(pinned(changed("axial_force", beam, force)), 0.0)[:6:2]
    assert found == pytest.approx(frequencies_of_a_pinned_beam(beam, 3, force), rel=2e-4)


@pytest.mark.parametrize("radius", [0.01, 0.1])
def test_a_shaft_on_two_pins_buckles_at_eulers_load_less_what_shear_takes(radius):
    """1/(1/N_E + 1/(κGA)); Richardson's extrapolation takes off what constant shear in an element leaves out."""
    beam = uniform(1, radius=radius)
    segment = beam.segments[0]
    of_shear = shear_coefficient(segment) * segment.material.shear_modulus * segment.area
    coarse, fine = (buckling_load(on_pins(uniform(n, radius=radius))) for n in (8, 16))
    assert (4 * fine - coarse) / 3 == pytest.approx(1 / (1 / euler_load(beam) + 1 / of_shear), rel=1e-5)


def test_under_its_buckling_load_a_shaft_has_a_natural_frequency_of_zero():
    beam = on_pins(uniform(8))
    [lowest, *_] = natural_frequencies(pinned(changed("axial_force", beam, -buckling_load(beam))), 0.0)
    assert lowest < 1e-3 * natural_frequencies(pinned(beam), 0.0)[0]


def test_tension_straightens_a_bow():
    """Of a sine on two pins 1/(1 + N/N_E) is left (Timoshenko & Gere 1961, section 1.12)."""
    beam = dataclasses.replace(on_pins(uniform(16, shear_flexibility=0.0)), unbalance=(UnbalancePlane(0.5),))
    unknown = Unknown(Parameter("kxx", "N/m", 1.0, 0.5 * STIFF, 1.5 * STIFF), (BearingTarget(0, "kxx"),))
    problem = RotorProblem(beam, (unknown,), np.array([1e-3]), (Channel(0.5, "x"),))
    both = effect("axial_force").added_to(effect("residual_bow").added_to(problem))
    force = 0.2 * euler_load(beam)
    [[[found]]] = both.response(np.array([[STIFF, 1e-5, 0.0, force]]))
    assert found == pytest.approx(1e-5 / 1.2, rel=1e-5)  # the mesh: (π/16)⁴/720 = 2e-6


def test_a_shaft_that_one_bearing_holds_has_no_axial_force():
    rotor = dataclasses.replace(PLAIN.rotor, bearings=PLAIN.rotor.bearings[:1])
    unknown = Unknown(Parameter("kxx", "N/m", 1.0, 1e7, 9e7), (BearingTarget(0, "kxx"),))
    lonely = dataclasses.replace(PLAIN, rotor=rotor, unknowns=(unknown,))
    assert effect("axial_force").locations(lonely) == []
    with pytest.raises(SettingError, match="bearings at two places"):
        effect("axial_force").added_to(lonely)


# damping from outside


def test_external_damping_of_a_uniform_shaft_falls_with_the_frequency_of_the_mode():
    """ζ_n = c/(2 μ ω_n); rotary inertia and shear of so thin a shaft take off 1e-4."""
    beam = on_pins(uniform(16, radius=5e-3))
    segment, damping = beam.segments[0], 40.0
    modes = natural_modes(changed("external_damping", beam, damping), 0.0, 6)[::2]
    of_beam = frequencies_of_a_pinned_beam(beam, 3)
    expected = damping / (2 * segment.material.density * segment.area * of_beam)
    assert [mode.damping_ratio for mode in modes] == pytest.approx(expected, rel=3e-3)


def test_external_damping_does_not_turn_with_the_shaft():
    matrices = assemble_free(changed("external_damping", uniform(4), 40.0))
    assert not matrices.circulatory.any() and matrices.damping.any()


def test_standing_damping_of_a_uniform_shaft_rises_with_the_frequency_of_the_mode():
    """ζ_n = β ω_n/2, on pins, which bear all of it; the pins' own stiffness takes off 1e-3."""
    beam, beta = on_pins(uniform(16, radius=5e-3)), 2e-5
    modes = natural_modes(changed("standing_damping", beam, beta), 0.0, 6)[::2]
    assert [mode.damping_ratio for mode in modes] == pytest.approx(
        beta / 2 * frequencies_of_a_pinned_beam(beam, 3), rel=3e-3
    )
    matrices = assemble_free(changed("standing_damping", uniform(4), beta))
    assert not matrices.circulatory.any() and matrices.damping == pytest.approx(beta * matrices.stiffness)


# the beam theory


@pytest.mark.parametrize("change", [-1.0, -0.4, 1.0])
def test_shear_flexibility_gives_the_frequencies_of_a_stubby_beam(change):
    """Rayleigh's at −1, Timoshenko's with 1/(1 + s) of the shear stiffness above; extrapolated as in test_shaft.py."""
    coarse, fine = (
        natural_frequencies(pinned(changed("shear_theory", uniform(n, radius=0.1), change)), 0.0)[:4:2]
        for n in (16, 32)
    )
    expected = frequencies_of_a_pinned_beam(uniform(1, radius=0.1), 2, shear_flexibility=1 + change, rotary=True)
    assert (4 * fine - coarse) / 3 == pytest.approx(expected, rel=3e-5)


def test_a_model_without_shear_can_only_have_more():
    rotor = changed("shear_theory", PLAIN.rotor, -1.0)
    bernoulli = dataclasses.replace(PLAIN, rotor=rotor)
    [limits] = effect("shear_theory").parameters(bernoulli)
    assert (limits.lower, limits.upper) == (0.0, 1.0)
    draws = [effect("shear_theory").draw(bernoulli, np.random.default_rng(seed))[0] for seed in range(20)]
    assert min(draws) > 0


# the hub


def stepped_deflection(beam, hub, stiffening):
    """Middle of a beam on two pins under 1 N there, stiffer over a hub in its middle, m: bending and shear."""
    [segment] = beam.segments
    bending = segment.material.young_modulus * segment.second_moment
    of_shear = shear_coefficient(segment) * segment.material.shear_modulus * segment.area
    half, free = beam.length / 2, (beam.length - hub) / 2
    return (free**3 + (half**3 - free**3) / (1 + stiffening)) / (6 * bending) + beam.length / (4 * of_shear)


@pytest.mark.parametrize("width, n_element", [(0.5, 4), (0.3, 4), (0.13, 6), (0.05, 2), (3.0, 4)])
def test_a_hub_makes_a_stepped_beam_whatever_the_mesh(width, n_element):
    beam = uniform(n_element, radius=0.05)
    rotor = changed("hub_stiffening", beam, 1.7, position=0.5, width=width)
    load = displacement_row(rotor, 0.5, "x")
    stiffness, left = held(rotor, [*node_dof(0)[:2], *node_dof(n_element)[:2]])
    found = load[left] @ np.linalg.solve(stiffness, load[left])
    assert found == pytest.approx(stepped_deflection(beam, min(width, 1.0), 1.7), rel=1e-9)  # exact but for rounding


def test_the_width_of_a_hub_may_be_an_unknown():
    drawn = dataclasses.replace(PLAIN, is_as_drawn=True)
    places = effect("hub_stiffening").locations(drawn)
    assert len(places) == 6 and len(effect("hub_stiffening").locations(PLAIN)) == 3
    free = places[4]
    assert str(free) == "at 0.5 m with a width that changes from 50 mm"
    found = free.rotor(PLAIN.rotor, np.array([1.7, 0.6]))
    assert [(hub.position, hub.stiffening) for hub in found.hubs] == [(0.5, 1.7)]
    assert found.hubs[0].width == pytest.approx(0.08)
    x = np.append(REFERENCE, [1.7, 0.6])
    expected = effect("hub_stiffening", position=0.5, width=0.08).added_to(PLAIN).response(x[None, :-1])
    assert free.added_to(drawn).response(x[None]) == pytest.approx(expected, rel=1e-12)


def test_hubs_that_overlap_multiply_and_a_hub_of_nothing_is_none():
    beam = uniform(3)
    twice = changed(
        "hub_stiffening", changed("hub_stiffening", beam, 1.0, position=0.5, width=0.2), 0.5, position=0.5, width=0.2
    )
    once = changed("hub_stiffening", beam, 2.0, position=0.5, width=0.2)
    assert assemble_free(twice).stiffness == pytest.approx(assemble_free(once).stiffness, rel=1e-12)
    none = changed("hub_stiffening", beam, 0.0, position=0.45, width=0.2)
    expected = assemble_free(beam).stiffness
    assert np.abs(assemble_free(none).stiffness - expected).max() < 1e-12 * np.abs(expected).max()


def test_a_hub_is_as_wide_as_its_disk_or_as_the_shaft_is_thick():
    assert [place.width for place in effect("hub_stiffening").locations(PLAIN)] == pytest.approx([0.05, 0.05, 0.06])
    rotor = dataclasses.replace(PLAIN.rotor, disks=(Disk(0.2, 10.0, 0.2, 0.1), Disk(0.5, 10.0, 0.0, 0.0)))
    points = dataclasses.replace(PLAIN, rotor=rotor)
    assert [place.width for place in effect("hub_stiffening").locations(points)] == pytest.approx([0.1, 0.1])
    bare = dataclasses.replace(PLAIN, rotor=dataclasses.replace(PLAIN.rotor, disks=()))
    assert effect("hub_stiffening").locations(bare) == []
    with pytest.raises(SettingError, match="expected a disk on the rotor, got none"):
        effect("hub_stiffening").added_to(bare)


@pytest.mark.parametrize(
    "make, said",
    [
        (lambda: Rotor(PLAIN.rotor.segments, external_damping=float("nan")), "external damping"),
        (lambda: Rotor(PLAIN.rotor.segments, axial_force=float("inf")), "axial force"),
        (lambda: Rotor(PLAIN.rotor.segments, hubs=(Hub(5.0, 0.1, 1.0),)), "hub at 5 m"),
        (lambda: Hub(0.5, 0.0, 1.0), "width of a hub"),
        (lambda: Hub(0.5, 0.1, -1.0), "stiffening of a hub: expected a number above -1"),
        (lambda: dataclasses.replace(PLAIN.rotor.segments[0], shear_flexibility=-0.1), "shear flexibility"),
    ],
)
def test_a_rotor_refuses_what_cannot_be(make, said):
    with pytest.raises(SettingError, match=said):
        make()
