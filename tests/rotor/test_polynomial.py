"""The response as a ratio of polynomials against rank-one updates and the dense route, on machines of every kind."""

import dataclasses
import warnings

import numpy as np
import pytest

from ksmea.measurement.channel import Channel
from ksmea.problem.parameters import Parameter
from problems.drawn import Drawn
from problems.drawn_kinds import KINDS
from problems.rotor.finite_elements.bearing import COEFFICIENTS, Bearing, Pedestal, SpeedTable
from problems.rotor.finite_elements.data import Rotor, UnbalancePlane
from problems.rotor.finite_elements.segments import Disk, Material, ShaftSegment
from problems.rotor.response.model import finite
from problems.rotor.response.polynomial import ResponsePolynomial
from problems.rotor.response.problem import RotorProblem
from problems.rotor.response.unknowns import BearingTarget, OriginTarget, PedestalTarget, UnbalanceTarget, Unknown
from problems.three_disk import ThreeDisk

STEEL = Material(2e11, 7800.0, 0.3)
SPEED = np.linspace(60.0, 900.0, 29)
ROUNDING = 1e-11  # of the largest response: a thousand times what either route loses between its resonances


def unknown(name, lower, upper, *targets):
    return Unknown(Parameter(name, "SI", 1.0, lower, upper), targets)


def machine(unknowns):
    """A bearing with a table on a pedestal, one on the ground, two planes of unbalance."""
    columns = np.array([2e7, 1e6, -1e6, 3e7, 2e4, 0.0, 0.0, 3e4, 5.0, 0.0, 0.0, 5.0])
    table = SpeedTable((50.0, 450.0, 1000.0), tuple(tuple(columns * factor) for factor in (0.7, 1.0, 1.4)))
    pedestal = Pedestal(kxx=6e7, kyy=4e7, cxx=3e3, cyy=2e3, mxx=12.0, myy=15.0, loss_factor=0.03)
    rotor = Rotor(
        segments=(ShaftSegment(0.4, 0.04, STEEL, 4), ShaftSegment(0.6, 0.05, STEEL, 6)),
        disks=(Disk(0.4, 30.0, 0.6, 0.35), Disk(0.8, 20.0, 0.3, 0.16)),
        bearings=(Bearing(0.0, table=table, pedestal=pedestal), Bearing(1.0, kxx=3e7, kyy=2e7, cxx=2e4, cyy=3e4)),
        unbalance=(UnbalancePlane(0.4, 2e-4), UnbalancePlane(0.8, 1e-4, 0.7)),
    )
    return RotorProblem(rotor, unknowns, SPEED, (Channel(0.1, "x"), Channel(0.1, "y"), Channel(0.9, "30")))


CASES = {
    "a tied stiffness": (unknown("kxx", 1e7, 9e7, BearingTarget(1, "kxx"), BearingTarget(1, "kyy")),),
    "cross-coupling and mass": (
        unknown("kxy", -4e6, 4e6, BearingTarget(1, "kxy")),
        unknown("kyx", -4e6, 4e6, BearingTarget(1, "kyx")),
        unknown("mxx", 0.0, 9.0, BearingTarget(1, "mxx")),
        unknown("cyy", 1e3, 9e4, BearingTarget(1, "cyy")),
    ),
    "a factor of a table": (unknown("stiffness_factor", 0.5, 2.0, BearingTarget(0, "stiffness_factor")),),
    "a pedestal": (
        unknown("support_kxx", 3e7, 9e7, PedestalTarget(0, "kxx")),
        unknown("support_mass", 2.0, 20.0, PedestalTarget(0, "mass")),
    ),
    "unbalance alone": (unknown("u", 1e-5, 5e-4, UnbalanceTarget(0)),),
    "directions and the origin": (
        unknown("u_x", -5e-4, 5e-4, UnbalanceTarget(0, "x")),
        unknown("u_y", -5e-4, 5e-4, UnbalanceTarget(0, "y")),
        unknown("phase", 0.0, 6.0, UnbalanceTarget(1, "phase")),
        unknown("origin", 0.0, 6.0, OriginTarget()),
        unknown("kyy", 1e7, 9e7, BearingTarget(1, "kyy")),
    ),
}


def drawn(problem, n=20):
    own = problem.parameters
    return own.lower + np.random.default_rng(0).random((n, len(own))) * own.width


def near(values, size=ROUNDING):
    return pytest.approx(values, rel=0, abs=size * np.max(np.abs(values)))


@pytest.mark.parametrize("unknowns", CASES.values(), ids=CASES)
def test_every_kind_of_unknown_by_the_dense_route(unknowns):
    problem = machine(unknowns)
    x = drawn(problem)
    assert problem.physics._polynomial is not None
    # 1e-9: the dense matrices of 44 degrees of freedom lose that
    assert problem.response(x) == near(problem.dense_response(x), 1e-9)


@pytest.mark.parametrize("unknowns", CASES.values(), ids=CASES)
def test_derivatives_of_every_kind_of_unknown(unknowns):
    """By the unknowns' own rank-one route, and by central differences of the dense one."""
    problem = machine(unknowns)
    for x in drawn(problem, 3):
        response, sensitivity = problem.linearised(x)
        columns, change = problem.linearised_per_load(x, ())
        assert response == near(columns[:, :, 0])
        assert sensitivity == near(change[:, :, 0])
        for index, width in enumerate(problem.parameters.width):
            step = 1e-5 * width * np.eye(len(x))[index]  # its error of second order is 1e-8 here
            ahead, behind = problem.dense_response(np.array([x + step, x - step]))
            assert sensitivity[:, :, index] * width == near((ahead - behind) / 2e-5, 1e-5)


@pytest.mark.parametrize("family", [*KINDS, "three_disk"])
def test_drawn_machines_by_rank_one_updates(family):
    problem = Drawn(family=family, instance=3).build()
    x = drawn(problem)
    assert problem.physics._polynomial is not None
    assert problem.response(x) == near(problem.physics._by_updates(x))


def test_monomials_of_two_equal_bearings():
    """Of degree 2 at most in kxx and cxx, which share an impedance at both bearings, times the like of y: 6 · 6."""
    assert ThreeDisk().build().physics._polynomial.factors.shape == (4, 36)


def test_small_coefficients_lose_no_digits():
    """Limits over five decades; at the lower ones a polynomial about the middle would be a difference of equal numbers."""
    limits = {"kxx": [1e-3, 100.0], "kyy": [1e-3, 100.0], "cxx": [1e-5, 1.0], "cyy": [1e-5, 1.0]}
    problem = ThreeDisk(limits=limits).build()
    x = problem.parameters.lower[None] * np.linspace(1, 50, 12)[:, None]
    assert problem.response(x) == pytest.approx(problem.physics._by_updates(x), rel=1e-8)


def test_many_monomials_are_left_to_the_updates():
    every = [
        unknown(f"{name}{bearing}", 1.0, 1e7, BearingTarget(bearing, name))
        for bearing in (0, 1)
        for name in COEFFICIENTS[:8]
    ]
    problem = machine(())
    flexible = dataclasses.replace(problem.rotor, bearings=(Bearing(0.0), Bearing(1.0)))
    crossed = RotorProblem(flexible, tuple(every), SPEED, problem.channels)
    x = drawn(crossed)
    assert crossed.physics._polynomial is None
    assert crossed.response(x) == near(crossed.dense_response(x), 1e-9)


@pytest.mark.parametrize("family", ["two_overhangs", "three_disk"])
def test_a_response_does_not_depend_on_the_sets_beside_it(family):
    """To the last digit: an interrupted run goes on with parts of its batches."""
    problem = Drawn(family=family, instance=1).build()
    x = drawn(problem, 1000)  # more than one part
    whole = problem.response(x)
    for first, last in ((0, 1), (1, 3), (7, 20), (500, 999)):
        assert np.array_equal(problem.response(x[first:last]), whole[first:last])
    assert np.array_equal(problem.linearised(x[4])[0], whole[4])
    assert problem.response(x[:0]).shape == (0, *whole.shape[1:])


@pytest.mark.parametrize("others", [0, 3])  # one set, and a batch
def test_a_singular_rotor_is_nan_and_no_warning(others):
    """Q = t and N = 1 of one unknown t, at one speed, channel and plane."""
    is_one, is_unknown = [1], [0]
    coefficients = np.array([[0, 1], [1, 0]], dtype=complex).view(float)
    polynomial = ResponsePolynomial(np.ones(1), np.array([is_one + is_unknown]), coefficients, (1, 1, 1))
    x, unbalance = np.array([[0.0]] + [[2.0]] * others), np.full((1 + others, 1), 3.0 + 4.0j)
    with warnings.catch_warnings(action="error"):
        found = polynomial.response(x, unbalance)[:, 0, 0]
    assert np.isnan(found[0])
    np.testing.assert_array_equal(found[1:], 1.5 + 2.0j)


def test_large_values_are_finite_though_their_squares_are_not():
    values = np.array([[1e200 + 0j, 0.0]])
    assert finite(values) is values
    for bad in (np.nan, np.inf):
        with pytest.raises(np.linalg.LinAlgError, match="not finite"):
            finite(np.array([[1.0 + bad * 1j, 0.0]]))
