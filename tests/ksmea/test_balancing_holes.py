"""Correction weights in holes: closed forms, limits, and given sizes beside an exhaustive search."""

import itertools

import numpy as np
import pytest

from ksmea.balancing.holes import split
from ksmea.measurement.campaign import Holes

TWELVE = tuple(np.radians(np.arange(0, 360, 30)))


def sums(found, holes):
    return sum(size * np.exp(1j * holes.angles[hole - 1]) for hole, size in zip(found.holes, found.sizes))


def at(size, degrees):
    return size * np.exp(1j * np.radians(degrees))


def test_two_neighbouring_holes_by_the_law_of_sines():
    """10 at 40° between holes 2 (30°) and 3 (60°): 10 sin 20° / sin 30° and 10 sin 10° / sin 30°."""
    found = split(at(10, 40), Holes(TWELVE))
    assert found.holes == (2, 3) and abs(found.left) < 1e-12
    np.testing.assert_allclose(found.sizes, [20 * np.sin(np.radians(20)), 20 * np.sin(np.radians(10))], rtol=1e-12)


def test_a_weight_at_a_hole_takes_that_hole_alone():
    for number, angle in enumerate(TWELVE, start=1):
        found = split(7 * np.exp(1j * angle), Holes(TWELVE))
        assert found.holes == (number,) and found.sizes == pytest.approx((7,))


def test_an_occupied_hole_is_passed_over_exactly():
    found = split(at(10, 65), Holes(TWELVE, occupied=(3,)))  # between 30° and 90°
    assert found.holes == (2, 4) and abs(found.left) < 1e-12
    np.testing.assert_allclose(
        found.sizes, at(10, 0).real * np.sin(np.radians([25, 35])) / np.sin(np.radians(60)), rtol=1e-12
    )


def test_no_hole_takes_more_than_its_most_and_the_sum_stays_exact():
    rng = np.random.default_rng(1)
    for _ in range(50):
        holes, weight = Holes(TWELVE, occupied=(5,), most=4.0), at(10, 360 * rng.random())
        found = split(weight, holes)
        assert max(found.sizes) <= 4 * (1 + 1e-9) and not {5} & set(found.holes)
        assert abs(sums(found, holes) - weight) < 1e-8 and abs(found.left) < 1e-8
        assert sum(size < 4 * (1 - 1e-6) for size in found.sizes) <= 2  # a vertex


def test_what_the_holes_cannot_carry_is_left():
    """One hole alone: the part across it is left; two of most 1 for a weight of 10 between them: 10 - 2 cos 15°."""
    assert split(at(10, 30), Holes((0.0,))).left == pytest.approx(at(10, 30) - 10 * np.cos(np.radians(30)))
    full = split(at(10, 15), Holes(TWELVE[:2], most=1.0))
    assert full.sizes == pytest.approx((1, 1)) and abs(full.left) == pytest.approx(10 - 2 * np.cos(np.radians(15)))
    assert split(at(10, 180), Holes(TWELVE[:2])).holes == ()


@pytest.mark.parametrize("given", [{"step": 0.5}, {"sizes": (1.0, 2.5, 4.0, 6.5)}, {"step": 0.5, "most": 6.0}])
def test_given_sizes_come_as_near_as_any_two_of_them(given):
    rng = np.random.default_rng(2)
    for _ in range(10):
        holes, weight = Holes(TWELVE, occupied=(1, 7), **given), at(4 + 3 * rng.random(), 360 * rng.random())
        there = [*given.get("sizes", np.arange(0, 30) * 0.5), 0.0]
        there = [size for size in there if size <= given.get("most", np.inf)]
        found = split(weight, holes)
        free = [angle for number, angle in enumerate(TWELVE, start=1) if number not in (1, 7)]
        free = sorted(free, key=lambda angle: abs(np.angle(weight * np.exp(-1j * angle))))[
            :4
        ]  # two, and two beside them
        best = min(
            abs(weight - a * np.exp(1j * i) - b * np.exp(1j * j))
            for i, j in itertools.combinations(free, 2)
            for a, b in itertools.product(there, there)
        )
        assert abs(found.left) <= best + 1e-8 and abs(weight - sums(found, holes) - found.left) < 1e-12
        assert all(min(abs(np.array(there) - size)) < 1e-9 for size in found.sizes)


def test_more_holes_than_two_where_one_takes_little():
    """12 g in holes of at most 5: three or more, and off by no more than half a diagonal of the steps."""
    holes, weight = Holes(TWELVE, most=5.0, step=1.0), at(12, 47)
    found = split(weight, holes)
    assert len(found.holes) > 2 and max(found.sizes) <= 5 and abs(found.left) < 0.5
    fine = split(weight, Holes(TWELVE, step=1e-4))
    assert abs(fine.left) < 1e-4
