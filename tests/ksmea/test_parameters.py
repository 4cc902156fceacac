"""Parameters: SI, the unit cube and the units people read."""

import math

import numpy as np
import pytest

from ksmea.errors import SettingError
from ksmea.problem.parameters import Parameter, Parameters
from ksmea.units import GRAM_MILLIMETRE, KILONEWTON_SECOND_PER_METRE, MEGANEWTON_PER_METRE

PARAMETERS = Parameters(
    (
        Parameter("kxx", "MN/m", MEGANEWTON_PER_METRE, 10e6, 100e6),
        Parameter("cxx", "kN s/m", KILONEWTON_SECOND_PER_METRE, 10.0, 1000.0),
        Parameter("u", "g mm", GRAM_MILLIMETRE, 50e-6, 500e-6),
    )
)


def test_the_corners_of_the_cube_are_the_limits():
    assert np.array_equal(PARAMETERS.to_si(np.zeros(3)), [10e6, 10.0, 50e-6])
    assert np.allclose(PARAMETERS.to_si(np.ones(3)), [100e6, 1000.0, 500e-6], rtol=1e-15)
    assert np.array_equal(PARAMETERS.to_cube(PARAMETERS.lower), np.zeros(3))
    assert np.array_equal(PARAMETERS.to_cube(PARAMETERS.upper), np.ones(3))


def test_the_middle_of_the_cube_is_the_mean_of_the_limits():
    assert np.allclose(PARAMETERS.to_si(np.full(3, 0.5)), [55e6, 505.0, 275e-6], rtol=1e-15)


@pytest.mark.parametrize("shape", [(3,), (7, 3), (2, 5, 3)])
def test_to_si_and_back_is_the_same_point(shape):
    u = np.random.default_rng(1).random(shape)
    # rounding: lower / width of 0.11 at most, so that a few units of the last place remain
    assert np.allclose(PARAMETERS.to_cube(PARAMETERS.to_si(u)), u, rtol=0, atol=4 * np.finfo(float).eps)


def test_points_outside_the_limits_lie_outside_the_cube():
    assert np.allclose(PARAMETERS.to_cube([190e6, 505.0, 275e-6]), [2.0, 0.5, 0.5])


def test_values_are_read_in_their_units():
    # one MN/m is 1e6 N/m, one kN s/m 1e3 N s/m, one g mm 1e-6 kg m
    assert np.allclose(PARAMETERS.in_units([50e6, 500.0, 2e-4]), [50.0, 0.5, 200.0], rtol=1e-15)


def test_the_order_is_kept():
    assert PARAMETERS.names == ("kxx", "cxx", "u") == tuple(parameter.name for parameter in PARAMETERS)
    assert len(PARAMETERS) == 3
    assert np.array_equal(PARAMETERS.width, PARAMETERS.upper - PARAMETERS.lower)


@pytest.mark.parametrize(
    "lower, upper",
    [(100e6, 10e6), (10e6, 10e6), (math.nan, 1e6), (1e6, math.nan), (-math.inf, 1e6), (1e6, math.inf)],
)
def test_limits_that_hold_nothing_are_refused(lower, upper):
    with pytest.raises(SettingError, match="limits of kxx: expected lower < upper"):
        Parameter("kxx", "MN/m", MEGANEWTON_PER_METRE, lower, upper)


def test_reversed_limits_are_told_in_the_units_they_were_given_in():
    with pytest.raises(SettingError) as caught:
        Parameter("kxx", "MN/m", MEGANEWTON_PER_METRE, 100e6, 10e6)
    assert str(caught.value) == "limits of kxx: expected lower < upper, got [100, 10] MN/m; swap or widen them"


def test_decades_are_spread_evenly_where_limits_lie_one_or_more_apart():
    offset = Parameter("offset", "", 1.0, -1.0, 1.0)
    parameters = Parameters((PARAMETERS.items[0], PARAMETERS.items[1], offset))
    middle = parameters.to_si(parameters.from_decades(np.full((1, 3), 0.5)))[0]
    # between 10 and 100 MN/m, between 10 and 1000 N s/m, and halfway where there is no logarithm
    assert middle == pytest.approx([np.sqrt(1e15), 100.0, 0.0], rel=1e-12, abs=1e-12)
    points = np.random.default_rng(1).random((20, 3))
    assert parameters.to_decades(parameters.from_decades(points)) == pytest.approx(points)


def test_an_angle_that_is_free_to_turn_has_a_period():
    angles = [Parameter("phase", "deg", np.pi / 180, -reach, reach) for reach in (1.5 * np.pi, 0.5 * np.pi)]
    assert Parameters(tuple(angles)).period == pytest.approx([2 / 3, np.inf])
