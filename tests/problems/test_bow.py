"""Shapes of a bent shaft against beam theory, and what probes read of them."""

import dataclasses

import numpy as np
import pytest

from beams import uniform
from ksmea.errors import SettingError
from ksmea.measurement.channel import Channel
from ksmea.plugins import registry
from problems.rotor.extension.bow import bow_shape, bow_shapes
from problems.rotor.finite_elements.assembly import assemble_free, displacement_row
from problems.rotor.finite_elements.bearing import Bearing
from problems.rotor.finite_elements.data import UnbalancePlane
from problems.rotor.finite_elements.segments import Disk
from problems.rotor.response.problem import RotorProblem

LEFT, RIGHT = 0.1, 0.8  # m, bearings of a shaft of 1 m
# shear and the mesh: (radius / span)² of 3e-4, and exact deflections at nodes
ROTOR = dataclasses.replace(
    uniform(40),
    bearings=(Bearing(LEFT, kxx=1e12, kyy=1e12), Bearing(RIGHT, kxx=1e12, kyy=1e12)),
    unbalance=(UnbalancePlane(0.5, 0.0, 0.0),),
)


def deflection(shape, position, rotor=ROTOR):
    bent = bow_shape(rotor, shape, assemble_free(rotor).stiffness)
    return float((displacement_row(rotor, position, "x") @ bent).real)


def test_a_force_in_the_middle_bends_as_beam_theory_says_and_leaves_overhangs_straight():
    """w = x (3 L² − 4 x²)/L³ of the largest up to the middle, with a slope of 3/L at the bearing."""
    span = RIGHT - LEFT
    assert deflection("force at 0.45", 0.45) == pytest.approx(1)
    assert deflection("force at 0.45", LEFT + span / 4) == pytest.approx(11 / 16, rel=2e-3)
    assert deflection("force at 0.45", 0.0) == pytest.approx(-3 * LEFT / span, rel=2e-3)


def test_a_moment_at_an_overhang_bends_the_span_and_the_overhang():
    """M at the end of an overhang a: w = −M x (L² − x²)/(6 E I L) between, M a (L/3 + a/2)/(E I) at the end."""
    span, arm = RIGHT - LEFT, 1.0 - RIGHT
    x = span / 2
    expected = -x * (span**2 - x**2) / (6 * span) / (arm * (span / 3 + arm / 2))
    assert abs(deflection("moment at 1", 1.0)) == pytest.approx(1)
    assert deflection("moment at 1", LEFT + x) / deflection("moment at 1", 1.0) == pytest.approx(expected, rel=2e-3)


def test_half_a_sine_goes_on_along_its_tangents():
    slope = np.pi / (RIGHT - LEFT)
    assert deflection("sine", (LEFT + RIGHT) / 2) == pytest.approx(1) and deflection("sine", LEFT) == pytest.approx(
        0, abs=1e-12
    )
    assert deflection("sine", 0.0) == pytest.approx(-slope * LEFT)
    assert deflection("whole", 0.25) == pytest.approx(np.sin(np.pi / 4))


@pytest.mark.parametrize("shape", ["sine", "force at 0.5", "moment at 1", "force at 0.05"])
def test_probes_read_the_bow_on_stiff_bearings_at_low_speed(shape):
    probes = tuple(Channel(position, axis) for position in (0.0, 0.5, 1.0) for axis in ("x", "y"))
    problem = RotorProblem(ROTOR, (), np.array([0.01]), probes)
    bowed = registry.create("effect", "residual_bow", {"shapes": [shape]}).added_to(problem)
    found = bowed.response(np.array([[3e-5, -1e-5]]))[0, 0]
    expected = np.repeat([deflection(shape, position) for position in (0.0, 0.5, 1.0)], 2) * np.tile([1, -1j], 3)
    # the shaft's own stiffness beside that of its bearings, 3e4 and 1e12 N/m
    assert found == pytest.approx((3e-5 - 1e-5j) * expected, rel=1e-5, abs=1e-11)


def test_two_shapes_add_and_have_unknowns_of_their_own():
    problem = RotorProblem(ROTOR, (), np.array([50.0]), (Channel(0.5, "x"), Channel(1.0, "y")))

    def response(shapes, theta):
        return (
            registry.create("effect", "residual_bow", {"shapes": shapes}).added_to(problem).response(np.array([theta]))
        )

    both = registry.create("effect", "residual_bow", {"shapes": ["sine", "force at 1"]})
    assert both.added_to(problem).parameters.names == ("bow_x", "bow_y", "bow_2_x", "bow_2_y")
    assert str(both) == "half sine between the bearings and as under a force at 1 m"
    apart = response(["sine"], [1e-5, 2e-5]) + response(["force at 1"], [-2e-5, 1e-6])
    assert response(both.shapes, [1e-5, 2e-5, -2e-5, 1e-6]) == pytest.approx(apart, rel=1e-12)


def test_no_shape_depends_on_the_mesh():
    """An element is exact at its ends under a moment within it: 0.575 m is a node of 40 elements, not of 20."""
    coarse = dataclasses.replace(
        ROTOR, segments=tuple(dataclasses.replace(each, n_element=20) for each in ROTOR.segments)
    )
    shape = "moment at 0.575"
    here, there = (deflection(shape, place, coarse) for place in (0.25, 0.95))
    assert here / there == pytest.approx(deflection(shape, 0.25) / deflection(shape, 0.95), rel=1e-9)


def test_a_drawn_rotor_is_bent_at_disks_couplings_and_middles_of_long_spans():
    disk = Disk(0.35, 1.0, 1e-3, 1e-3)
    rotor = dataclasses.replace(ROTOR, disks=(disk,), couplings=(0.03,))
    assert bow_shapes(rotor) == [
        "sine", "whole", "force at 0.35", "force at 0.03", "force at 0.575", "moment at 0.35", "moment at 0.03", "moment at 0.575"
    ]  # fmt: skip
    drawn = RotorProblem(rotor, (), np.array([50.0]), (Channel(0.5, "x"),), is_as_drawn=True)
    effect = registry.create("effect", "residual_bow", {})
    assert len(effect.locations(drawn)) == 8 and len(effect.kin(drawn)) == 28
    exact = dataclasses.replace(drawn, is_as_drawn=False)
    assert effect.locations(exact) == [effect] and effect.kin(exact) == []
    assert bow_shapes(dataclasses.replace(rotor, bearings=rotor.bearings[:1])) == ["whole"]


@pytest.mark.parametrize("shapes", [[], ["sine", "sine"], ["banana"], ["force at"], ["torque at 0.5"], ["a", "b", "c"]])
def test_shapes_that_are_none_are_refused_in_a_line(shapes):
    with pytest.raises(SettingError, match=r"shapes: expected .*, got") as caught:
        registry.create("effect", "residual_bow", {"shapes": shapes})
    assert "\n" not in str(caught.value)
