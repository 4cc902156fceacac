"""The RK-4 rig of Table 7: what each reading of its printed lengths means."""

import dataclasses
import math

import numpy as np
import pytest

from ksmea.errors import SettingError
from problems.rk4 import DISK_MASS, LAYOUTS, RK4, rk4_rotor, solid_thickness
from problems.rotor.finite_elements.assembly import assemble, displacement_row
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.segments import Material
from problems.rotor.free_motion.critical_speeds import critical_speeds
from problems.rotor.response.unknowns import rotor_at

RPM = math.pi / 30
SECOND_MOMENT = math.pi / 4 * 0.005**4


def published(**settings):
    """The rotor with the coefficients of Table 7 and the assumed damping."""
    rig = RK4(**settings)
    problem = rig.build()
    return rotor_at(problem.rotor, problem.unknowns, list(rig.reference().values()))


@pytest.mark.parametrize(("layout", "first"), [("span_320", 4386.3), ("span_440", 2718.4), ("span_200", 8681.6)])
def test_first_critical_speed_of_each_layout(layout, first):
    """The figures in the module's docstring; near 4400, 2700 and 8700 rpm by an independent program."""
    found = critical_speeds(published(layout=layout), 10_000 * RPM)[0] / RPM
    assert found == pytest.approx(first, abs=0.1)


def midspan_flexibility(span):
    """Deflection per force halfway between the bearings, m/N: bending, shear (κ = 0.886, Cowper), two bearings."""
    shear_stiffness = 0.886 * 210e9 / 2.6 * math.pi * 0.005**2
    return span**3 / (48 * 210e9 * SECOND_MOMENT) + span / (4 * shear_stiffness) + 1 / (2 * 28e6)


@pytest.mark.parametrize("span", [0.2, 0.32, 0.44])
def test_first_critical_speed_is_that_of_a_mass_on_a_light_shaft(span):
    # Rayleigh with the static deflection, ω² = k/(m + 17/35 m_shaft), errs by some 1e-4 for so light a shaft.
    shaft_mass = 7850 * math.pi * 0.005**2 * span
    expected = math.sqrt(1 / midspan_flexibility(span) / (DISK_MASS + 17 / 35 * shaft_mass))
    material = Material(210e9, 7850.0, 0.3)
    rotor = rk4_rotor(span, 0.0, disk_radius=0.038, disk_thickness=None, material=material, mesh=10)
    bearings = tuple(Bearing(b.position, kxx=28e6, kyy=32e6) for b in rotor.bearings)
    found = critical_speeds(dataclasses.replace(rotor, bearings=bearings), 10_000 * RPM, 32)[0]
    assert found == pytest.approx(expected, rel=1e-3)


def test_disk_size_hardly_matters():
    firsts = [
        critical_speeds(published(disk_diameter=diameter), 5_000 * RPM, n_scan=8)[0] for diameter in (50.0, 76.0, 100.0)
    ]
    assert max(firsts) / min(firsts) - 1 < 2e-4


@pytest.mark.parametrize("layout", LAYOUTS)
def test_mass_and_static_stiffness(layout):
    span, overhang = LAYOUTS[layout]
    rotor = published(layout=layout)
    matrices = assemble(rotor)
    translation = np.tile([1.0, 0, 0, 0], len(rotor.node_positions))
    expected = DISK_MASS + 7850 * math.pi * 0.005**2 * (span + overhang)
    assert translation @ matrices.mass @ translation == pytest.approx(expected, rel=1e-10)

    load = displacement_row(rotor, span / 2, "x")
    deflection = load @ np.linalg.solve(matrices.stiffness, load)
    assert deflection == pytest.approx(midspan_flexibility(span), rel=1e-5)


def test_bearings_are_far_stiffer_than_the_shaft():
    assert 28e6 / (48 * 210e9 * SECOND_MOMENT / 0.32**3) == pytest.approx(185, abs=0.5)


@pytest.mark.parametrize(
    ("layout", "counts"), [("span_320", (8, 8, 6)), ("span_440", (11, 11)), ("span_200", (5, 5, 6))]
)
def test_sixth_node_of_the_default_mesh_is_where_the_default_probe_looks(layout, counts):
    problem = RK4(layout=layout).build()
    assert tuple(segment.n_element for segment in problem.rotor.segments) == counts
    assert np.allclose(np.diff(problem.rotor.node_positions), 0.02)
    assert [channel.position for channel in problem.channels] == pytest.approx([problem.rotor.node_positions[5]] * 2)


def test_default_mesh_is_fine_enough():
    coarse, fine = (RK4(mesh=mesh).build() for mesh in (22, 88))
    x = np.array([list(RK4().reference().values())])
    assert np.abs(coarse.response(x) / fine.response(x) - 1).max() < 1e-5


@pytest.mark.parametrize("layout", LAYOUTS)
def test_reduced_response_is_the_dense_one(layout):
    problem = RK4(layout=layout, n_speed=7).build()
    x = problem.parameters.to_si(np.random.default_rng(1).random((20, 5)))
    # Below the critical speed, or across it with little damping: rounding of stiffnesses that differ by 1e4.
    assert np.abs(problem.response(x) / problem.dense_response(x) - 1).max() < 1e-8


def test_reference_is_table_7_inside_the_bounds():
    problem, reference = RK4().build(), RK4().reference()
    assert tuple(reference) == problem.parameters.names
    x = np.array(list(reference.values()))
    assert problem.parameters.in_units(x) == pytest.approx([28, 32, 1, 1, 80])
    assert np.all((problem.parameters.lower < x) & (x < problem.parameters.upper))


def test_band_in_rpm():
    speed = RK4().build().speed
    assert speed / RPM == pytest.approx(np.arange(1500, 2501, 25))


def test_disk_of_given_thickness_keeps_its_mass():
    (solid,), (thick,) = (RK4(disk_thickness=thickness).build().rotor.disks for thickness in (None, 25.0))
    assert (solid.mass, thick.mass) == pytest.approx((DISK_MASS, DISK_MASS))
    assert solid.polar_inertia == pytest.approx(thick.polar_inertia)
    assert thick.diametral_inertia - solid.diametral_inertia == pytest.approx(
        DISK_MASS * (0.025**2 - solid_thickness(0.038, 7850) ** 2) / 12
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"layout": "span_330"}, "unknown value for layout: 'span_330'; did you mean 'span_320'"),
        ({"disk_diameter": 10.0}, "disk_diameter: expected a number above 10"),
        ({"disk_thickness": 0.0}, "disk_thickness: expected a number above 0"),
        ({"young_modulus": float("nan")}, "young_modulus: expected a number above 0"),
        ({"mesh": 2}, "at least 3 elements, got 2"),
        ({"mesh": 0}, "mesh: expected a number at least 1"),
        ({"sensors": [0.45]}, "up to 0.44 m, the shaft's length in layout span_320"),
        ({"sensors": [0.33], "layout": "span_200"}, "up to 0.32 m"),
        ({"sensors": []}, "at least one entry"),
        ({"directions": ["z"]}, "expected x, y or degrees"),
        ({"speed_from": 2500.0, "speed_to": 1500.0}, "more than speed_from"),
        ({"limits": {"k": [1, 2]}}, "unknown name in limits"),
        ({"limits": {"u": [1]}}, r"expected \[lower, upper\] in g mm"),
    ],
)
def test_bad_settings(changes, message):
    with pytest.raises(SettingError, match=message) as caught:
        RK4(**changes)
    assert "\n" not in str(caught.value)
