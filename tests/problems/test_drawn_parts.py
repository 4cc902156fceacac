"""Drawn rotors with parts of real machines: draws without parts stay, each part is within its ranges, and identification finds them."""

import hashlib

import numpy as np
import pytest

import ksmea
from ksmea.errors import SettingError
from ksmea.testing import check_problem
from optimizers.lm import LM
from problems.drawn import FAMILIES, Drawn, drawn, is_sound
from problems.drawn_parts import (
    FACTOR,
    LAYER_RADIUS,
    PARTS,
    SEAL_DAMPING,
    SEAL_STIFFNESS,
    SUPPORT_LOSS,
    SUPPORT_MASS,
    SUPPORT_STIFFNESS,
    SWIRL,
)
from tiers import mostly_slow

ALL = tuple(PARTS)
NUMBERS = (0, 1, 2)
HALF_A_DIGIT = 1e-3  # rounding to four digits moves a ratio by less


def within(value, ends):
    return ends[0] * (1 - HALF_A_DIGIT) <= value <= ends[1] * (1 + HALF_A_DIGIT)


def test_draws_without_parts_stay_as_they_were():
    """Values and limits of the first draws, taken before there were parts: four digits are the same on every machine."""
    told = [
        [
            *dict(instance.true).values(),
            *(end for item in instance.problem.parameters for end in (item.lower, item.upper)),
        ]
        for instance in (drawn(family, held_back, 0) for family in FAMILIES for held_back in (False, True))
    ]
    assert hashlib.sha256(repr(told).encode()).hexdigest()[:16] == "634d4e90503871c4"


# each part and each family at least once
PAIRS = [(family, part, (n + m) % len(ALL) == 0) for n, family in enumerate(FAMILIES) for m, part in enumerate(ALL)]


@pytest.mark.parametrize(
    ("family", "part"),
    [pytest.param(family, part, marks=[] if is_tried else pytest.mark.slow) for family, part, is_tried in PAIRS],
)
def test_every_part_gives_a_sound_instance(family, part):
    for number in NUMBERS:
        instance = drawn(family, False, number, (part,))
        lower, upper = (
            np.array([getattr(each, end) for each in instance.problem.parameters]) for end in ("lower", "upper")
        )
        assert is_sound(instance) and instance.problem.is_stable(instance.x)
        assert np.all((lower < instance.x) & (instance.x < upper))
        assert not instance.problem.remarks_at(instance.problem.speed)  # tables reach all speeds


@pytest.mark.parametrize("number", NUMBERS)
def test_a_table_times_its_factor_is_the_bearing(number):
    instance = drawn("cross_coupled", False, number, ("tables",))
    names = instance.problem.parameters.names
    assert names == ("kxx_factor", "kyy_factor", "cxx_factor", "cyy_factor", "kxy", "u")
    assert all(within(instance.true[name], FACTOR) for name in names[:4])
    assert [item.unit for item in instance.problem.parameters][:4] == ["times table"] * 4
    bearing = instance.problem.rotor_at(instance.x).bearings[0]
    speed = np.array([bearing.table.speed[4]])
    stiffness = bearing.matrices_at(speed)[0][0]
    calculated = bearing.table.at(speed)[0]
    factors = [instance.true["kxx_factor"], instance.true["kyy_factor"]]
    assert np.diag(stiffness) == pytest.approx(factors * calculated[[0, 3]], rel=1e-12)
    assert stiffness[0, 1] == stiffness[1, 0] == instance.true["kxy"]


@pytest.mark.parametrize("number", NUMBERS)
def test_a_seal_is_known_and_within_its_ranges(number):
    instance = drawn("three_disk", False, number, ("seals",))
    [seal] = instance.problem.rotor.seals
    stiffness, damping, _ = seal.matrices_at(np.array(seal.table.speed[3:4]))
    bearing = {letter: np.sqrt(instance.true[f"{letter}xx"] * instance.true[f"{letter}yy"]) for letter in "kc"}
    assert within(stiffness[0, 0, 0] / bearing["k"], SEAL_STIFFNESS)
    assert within(damping[0, 0, 0] / bearing["c"], SEAL_DAMPING)
    assert stiffness[0, 0, 1] == -stiffness[0, 1, 0]
    assert within(stiffness[0, 0, 1] / damping[0, 0, 0] / seal.table.speed[3], SWIRL)
    assert seal.position in [disk.position for disk in instance.problem.rotor.disks]


@pytest.mark.slow
def test_a_support_is_known_or_one_more_unknown():
    known = set()
    for number in range(6):
        instance = drawn("three_disk", False, number, ("supports",))
        rotor = instance.problem.rotor_at(instance.x)
        bearing = np.sqrt(instance.true["kxx"] * instance.true["kyy"])
        for each in rotor.bearings:
            assert within(each.pedestal.kxx / bearing, SUPPORT_STIFFNESS)
            assert within(each.pedestal.mxx / rotor.mass, SUPPORT_MASS)
            assert within(each.pedestal.loss_factor, SUPPORT_LOSS)
            assert each.pedestal.kxx == instance.true.get("support", each.pedestal.kxx)
        known.add("support" not in instance.true)
    assert known == {True, False}


@pytest.mark.parametrize("number", NUMBERS)
def test_a_sleeve_lies_between_the_bearings(number):
    segments = drawn("two_disk", False, number, ("layers",)).problem.rotor.segments
    [(place, layer)] = [(place, each.layers[0]) for place, each in enumerate(segments) if each.layers]
    assert 0 < place < len(segments) - 1
    assert within(layer.outer_radius / segments[place].outer_radius, LAYER_RADIUS)
    assert layer.inner_radius == segments[place].outer_radius


@pytest.mark.slow
def test_the_order_of_parts_changes_nothing():
    one, other = (Drawn(family="isotropic", machine_parts=list(order)) for order in (ALL, ALL[::-1]))
    assert one.build() is other.build()
    assert one.reference() != Drawn(family="isotropic").reference()


def test_an_unknown_part_is_refused():
    with pytest.raises(SettingError, match="unknown value for machine_parts: 'seal'; did you mean 'seals'"):
        Drawn(machine_parts=["seal"])


@pytest.mark.parametrize("family", mostly_slow(FAMILIES, but=["two_disk"]))
def test_the_exam_of_problems_passes(family):
    check_problem(Drawn(family=family, machine_parts=list(ALL)))


@pytest.mark.slow
@pytest.mark.parametrize("family, number", [("isotropic", 0), ("three_disk", 3)])
def test_identification_finds_what_was_drawn(family, number):
    """All intervals of 99.9 % hold the truth; of the 10 of two instances one fails in 100 noises."""
    instance = drawn(family, False, number, ALL)
    problem = ksmea.load_problem("drawn", family=family, instance=number, machine_parts=list(ALL))
    data = ksmea.synthetic_measurement(problem, relative=0.03, rng=1)
    result = ksmea.identify(problem, data, level=0.999, optimizer=LM(screening=1000, starts=3))
    assert {name for name in instance.true if name.endswith("_factor")}
    for item in result.record.parameters:
        true = instance.true[item.name]
        assert (item.low is None or item.low <= true) and (item.high is None or true <= item.high), item
