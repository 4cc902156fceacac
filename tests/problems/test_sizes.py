"""Unknowns of effects from their lines: limits, units and drawn sizes."""

import numpy as np
import pytest

from ksmea.errors import SettingError
from problems.effects.skewed_disk import SkewedDisk
from problems.effects.unbalance import FurtherUnbalance
from problems.rk4_two_disk import RK4TwoDisk
from problems.rotor.extension.effect import PlacedEffect, RotorEffect, rotor_mass, stiffness_scale
from problems.rotor.extension.sizes import Size, VectorSize
from problems.three_disk import ThreeDisk

PLAIN = ThreeDisk().build()


def draws(size, n=200):
    rng = np.random.default_rng(1)
    return np.array([size.draw(PLAIN, rng) for _ in range(n)])


def test_limits_are_parts_of_a_size_of_the_rotor_or_multiples_of_one_per_such():
    [mass] = Size("m", "kg", 0.1, drawn=(0.01, 0.05), of=rotor_mass).parameters(PLAIN)
    [compliance] = Size("a", "µm/kN", (0.0, 2.0), drawn=(0.2, 1.0), per=stiffness_scale).parameters(PLAIN)
    assert (mass.lower, mass.upper) == (-0.1 * rotor_mass(PLAIN), 0.1 * rotor_mass(PLAIN)) and mass.si_per_unit == 1
    assert (compliance.lower, compliance.upper) == (0.0, 2 / stiffness_scale(PLAIN)) and compliance.unit == "µm/kN"


@pytest.mark.parametrize(
    ("size", "signs"),
    [
        (Size("a", "%", 0.2, drawn=(0.01, 0.1)), {-1, 1}),
        (Size("a", "%", (-0.5, 0.2), drawn=(0.01, 0.1)), {-1, 1}),
        (Size("a", "%", (-0.5, 0.2), drawn=(0.01, 0.1), rises=True), {1}),
        (Size("a", "%", (0.0, 0.2), drawn=(0.01, 0.1)), {1}),
    ],
)
def test_a_size_is_drawn_of_either_sign_where_its_limits_hold_both(size, signs):
    values = draws(size)[:, 0]
    assert set(np.sign(values)) == signs
    assert 0.01 <= np.abs(values).min() < 0.012 and 0.09 < np.abs(values).max() <= 0.1


def test_a_vector_has_two_components_and_is_drawn_by_its_length():
    size = VectorSize("bow", "µm", 100e-6, drawn=(1e-6, 30e-6))
    assert [(item.name, item.upper, item.unit) for item in size.parameters(PLAIN)] == [
        ("bow_x", 100e-6, "µm"),
        ("bow_y", 100e-6, "µm"),
    ]
    length = np.linalg.norm(draws(size), axis=1)
    assert 1e-6 <= length.min() < 1.2e-6 and 25e-6 < length.max() <= 30e-6


def test_an_effect_without_a_line_for_its_unknowns_says_what_it_lacks():
    with pytest.raises(NotImplementedError, match="RotorEffect: expected `sizes`, or `parameters` and `draw`"):
        RotorEffect().parameters(PLAIN)


def test_an_effect_sits_on_its_first_seat_and_says_what_it_needs_where_there_is_none():
    assert SkewedDisk().placed_on(PLAIN).position == 0.2
    full = RK4TwoDisk().build()  # each of its disks carries unbalance
    with pytest.raises(
        SettingError, match="expected a disk without unbalance in the model, got none; give its position"
    ):
        FurtherUnbalance().placed_on(full)
    with pytest.raises(SettingError, match="expected the place of the disk, got none; add the effect to a problem"):
        SkewedDisk().loads(PLAIN.rotor, PLAIN.speed)


def test_a_placed_effect_from_outside_may_leave_the_check_of_its_position_out():
    class Elsewhere(PlacedEffect):
        position = 99.0

    assert Elsewhere().placed_on(PLAIN).places(PLAIN) == (99.0,)


def test_an_effect_changes_what_it_overrides_unless_it_says_otherwise():
    class Heavier(RotorEffect):
        def rotor(self, rotor, theta):
            return rotor

    class Stated(Heavier):
        changes_rotor = False
        has_loads = True

    flags = [(effect.changes_rotor, effect.has_loads, effect.turns) for effect in (RotorEffect(), Heavier(), Stated())]
    assert flags == [(False, False, False), (True, False, False), (False, True, False)]
