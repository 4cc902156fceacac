"""Instances drawn from ranges: the same everywhere, within their ranges, sound, and other ones where they are held back."""

import json
import subprocess
import sys

import numpy as np
import pytest

from ksmea.errors import SettingError
from measurements.drawn import RELATIVE
from measurements.drawn import Drawn as DrawnNoise
from problems.drawn import (
    CROSS_COUPLING,
    CROSS_LIMITS,
    FAMILIES,
    MAX_DRAWS,
    N_SPEED,
    OVERHANG,
    YOUNG_MODULUS,
    Drawn,
    drawn,
    is_sound,
)
from problems.drawn_numbers import LIMIT_PLACE, LIMIT_RATIOS

NUMBERS = (0, 1, 2)
DIMENSIONS = {"isotropic": 3, "one_disk": 5, "three_disk": 5, "cross_coupled": 6, "two_disk": 7}
EVERY = [(family, number) for family in FAMILIES for number in NUMBERS]
HALF_A_DIGIT = 1e-3  # rounding to four digits moves a ratio by less


def limits_and_values(family, number):
    settings = Drawn(family=family, instance=number)
    true = settings.reference()
    return {item.name: (item.lower, true[item.name], item.upper) for item in settings.build().parameters}


def within(value, ends):
    return ends[0] * (1 - HALF_A_DIGIT) <= value <= ends[1] * (1 + HALF_A_DIGIT)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_has_its_unknowns(family):
    assert len(Drawn(family=family).build().parameters) == DIMENSIONS[family]


@pytest.mark.parametrize("family, number", EVERY)
def test_every_instance_is_sound_and_within_its_ranges(family, number):
    instance, machine = drawn(family, False, number), FAMILIES[family].machine
    rotor = instance.problem.rotor
    assert instance.problem.is_stable(instance.x) and is_sound(instance)
    segment, (first, second) = rotor.segments[0], (bearing.position for bearing in rotor.bearings)
    assert within(segment.outer_radius, machine.shaft_radius) and within(segment.material.young_modulus, YOUNG_MODULUS)
    assert within(second - first, machine.span) and within(first / (second - first), OVERHANG)
    assert all(first < disk.position < second for disk in rotor.disks) and len(rotor.disks) == FAMILIES[family].n_disk
    assert N_SPEED[0] <= len(instance.problem.speed) <= N_SPEED[1]
    for name, value in instance.true.items():
        if name in ("k", "kxx"):
            assert within(value, machine.stiffness)
        if name in ("c", "cxx"):
            assert within(value, machine.damping)
        if name.startswith("u"):
            assert within(value, machine.unbalance)


@pytest.mark.parametrize("family, number", EVERY)
def test_limits_lie_about_the_truth_as_stated(family, number):
    quantities = {"k": "stiffness", "c": "damping", "u": "unbalance"}
    limits = limits_and_values(family, number)
    for name, (lower, true, upper) in limits.items():
        if name.startswith("phase"):
            assert upper - lower == pytest.approx(2 * np.pi)
        elif name == "kxy":
            mean = np.sqrt(np.prod([drawn(family, False, number).true[each] for each in ("kxx", "kyy")]))
            assert CROSS_COUPLING[0] * 1.001 <= true / mean <= CROSS_COUPLING[1] * 1.001
            told = np.sqrt(limits["kxx"][2] * limits["kyy"][2])  # by other limits already: these tell nothing more
            assert within(-lower / told, CROSS_LIMITS) and within(upper / told, CROSS_LIMITS)
        else:
            assert within(upper / lower, LIMIT_RATIOS[quantities[name[0]]])
            assert within(np.log(true / lower) / np.log(upper / lower), LIMIT_PLACE)


def test_the_middle_of_the_limits_tells_nothing():
    """On the logarithmic scale three of eight true values lie on either side of it by a tenth of the width; 0.2 of 72 values is
    three standard deviations less."""
    places = [
        np.log(true / lower) / np.log(upper / lower)
        for family, number in EVERY
        for name, (lower, true, upper) in limits_and_values(family, number).items()
        if name != "kxy" and not name.startswith("phase")
    ]
    assert np.mean(np.array(places) < 0.4) > 0.2 and np.mean(np.array(places) > 0.6) > 0.2


def test_most_bands_hold_a_critical_speed():
    """One in twelve ends below the first by its ranges; of 15, more than five would be a chance in ten thousand."""
    without = 0
    for family, number in EVERY:
        instance = drawn(family, False, number)
        speed = instance.problem.speed
        without += not np.any(instance.problem.critical_speeds(instance.x) > speed[0])
    assert without <= 5


@pytest.mark.parametrize("family", FAMILIES)
def test_the_held_back_set_is_another_one(family):
    """No instance of one set is one of the other, though both are of the same ranges."""
    sets = [{tuple(drawn(family, held_back, number).x) for number in NUMBERS} for held_back in (False, True)]
    assert len(sets[0] | sets[1]) == 2 * len(NUMBERS)


def test_another_process_draws_the_same():
    words = [("two_disk", True, 3), ("isotropic", False, 0)]
    here = [[*map(float, drawn(*each).x), float(drawn(*each).problem.speed[-1])] for each in words]
    code = (
        "import json; from problems.drawn import drawn;"
        f" print(json.dumps([[*map(float, drawn(*e).x), float(drawn(*e).problem.speed[-1])] for e in {words}]))"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(told.stdout) == here


def test_what_is_drawn_does_not_depend_on_what_was_drawn_before():
    first = drawn("isotropic", False, 1)
    drawn.cache_clear()
    drawn("isotropic", False, 2)
    assert drawn("isotropic", False, 1).true == first.true


def test_ranges_without_a_sound_draw_are_told(monkeypatch):
    monkeypatch.setattr("problems.drawn.is_sound", lambda instance: False)
    monkeypatch.setattr("problems.drawn.MAX_DRAWS", 2)
    with pytest.raises(ArithmeticError, match="isotropic 7: expected a sound draw, got none in 2"):
        drawn("isotropic", False, 7)
    assert MAX_DRAWS > 2


def test_an_unknown_family_is_refused():
    with pytest.raises(SettingError, match="unknown value for family: 'two_disks'; did you mean 'two_disk'"):
        Drawn(family="two_disks")


def test_noise_is_drawn_by_instance_and_told():
    drawn_noise = [
        DrawnNoise(family=family, instance=number, held_back=held_back)
        for family in FAMILIES
        for number in NUMBERS
        for held_back in (False, True)
    ]
    levels = [each.noise.relative for each in drawn_noise]
    assert all(RELATIVE[0] <= level <= RELATIVE[1] for level in levels)
    assert len(set(levels)) > 0.9 * len(levels)  # rounded to 0.01 %, a few may be alike
    assert {each.kind for each in drawn_noise} == {"amplitude", "complex"} and drawn_noise[0].noise_known


def test_the_measurement_is_of_the_instance_with_its_noise():
    settings, source = Drawn(family="isotropic"), DrawnNoise(family="isotropic")
    truth = source.true_values(settings)
    repeats = [
        source.measure(settings, truth, np.random.default_rng(seed), np.random.default_rng(0)) for seed in range(40)
    ]
    clean = source.response(settings, truth, np.random.default_rng(0))
    expected = clean if source.kind == "complex" else np.abs(clean)
    relative = np.sqrt(np.mean([np.abs(each.values / expected - 1) ** 2 for each in repeats]))
    n_value = len(repeats) * expected.size
    assert relative == pytest.approx(source.noise.relative, rel=4 / np.sqrt(2 * n_value))  # four σ of a sample's spread
    assert repeats[0].noise == source.noise


def test_the_noise_of_another_instance_is_refused():
    with pytest.raises(SettingError, match=r"measurement\.instance: expected 7 as in the problem, got 0"):
        DrawnNoise(family="isotropic").layout(Drawn(family="isotropic", instance=7))
