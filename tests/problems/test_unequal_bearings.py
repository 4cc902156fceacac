"""Unequal bearings: each form is a rotor whose bearings have unknowns of their own; which bearing is named, and when none is."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from tests.problems.test_effects import PLAIN, REFERENCE, effect, response, with_bearing_unknowns


def test_unequal_bearings_are_two_bearings():
    kxx, kyy, *others = REFERENCE
    values = np.array([[*others, kxx, 1.2 * kxx, kyy, 0.7 * kyy]])
    expected = with_bearing_unknowns("kxx 0", "kxx 1", "kyy 0", "kyy 1").response(values)[0]
    assert response(effect("unequal_bearings", bearing=2), [0.2, -0.3]) == pytest.approx(expected, rel=1e-8)
    softer = np.array([[1.2 * kxx, 0.7 * kyy, *others, 1 / 1.2 - 1, 1 / 0.7 - 1]])
    assert effect("unequal_bearings").added_to(PLAIN).response(softer)[0] == pytest.approx(expected, rel=1e-8)


def test_a_bearing_may_damp_otherwise():
    kxx, kyy, cxx, cyy, *others = REFERENCE
    apart = with_bearing_unknowns("kxx 0", "kxx 1", "cxx 0", "cxx 1", "kyy 0", "kyy 1", "cyy 0", "cyy 1")
    values = [*others, 0.6 * kxx, kxx, 1.5 * cxx, cxx, 0.6 * kyy, kyy, 1.5 * cyy, cyy]
    found = response(effect("unequal_bearings", changes="stiffness and damping"), [-0.4, -0.4, 0.5, 0.5])
    assert found == pytest.approx(apart.response(np.array([values]))[0], rel=1e-8)


def test_two_bearings_that_share_their_unknowns_are_one_place():
    """The first with 1.25 times the stiffness is the second with 0.8 times, and kxx is of the other one."""
    found = effect("unequal_bearings").locations(PLAIN)
    assert [str(each) for each in found] == ["stiffness of bearing 2", "stiffness and damping of bearing 2"]
    kxx, kyy, *others = REFERENCE
    stiffer = response(effect("unequal_bearings", bearing=1), [0.25, 0.25])
    softer = effect("unequal_bearings", bearing=2).added_to(PLAIN)
    values = np.array([[1.25 * kxx, 1.25 * kyy, *others, -0.2, -0.2]])
    assert softer.response(values)[0] == pytest.approx(stiffer, rel=1e-8)


def test_a_bearing_with_unknowns_of_its_own_cannot_differ_from_itself():
    one_apart = with_bearing_unknowns("kxx 0", "kxx 1", "kyy 0", "kyy 1")
    found = effect("unequal_bearings").locations(one_apart)
    assert [str(each) for each in found] == ["damping of bearing 2"]
    all_apart = with_bearing_unknowns("kxx 0", "kxx 1", "cxx 0", "cxx 1")
    assert effect("unequal_bearings").locations(all_apart) == []
    with pytest.raises(SettingError, match="bearing: expected one from 1 to 2, got 3"):
        effect("unequal_bearings", bearing=3).added_to(PLAIN)
