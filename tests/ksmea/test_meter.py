"""The meter: what counts, what it costs, and where a budget ends."""

import numpy as np
import pytest

from ksmea.errors import BudgetSpent
from ksmea.numerics.meter import Meter

POINTS = np.arange(10.0).reshape(5, 2)


def test_a_batch_counts_by_its_rows_and_is_cut_at_the_budget():
    meter, seen = Meter(7), []

    def keep(points, values, first):
        seen.append((len(points), first, meter.evaluations))
        assert np.array_equal(values, 2 * points)

    meter.ask(POINTS, lambda points: 2 * points, keep)
    with pytest.raises(BudgetSpent, match="the budget of 7 evaluations is spent"):
        meter.ask(POINTS, lambda points: 2 * points, keep)
    assert seen == [(5, 1, 5), (2, 6, 7)]
    assert (meter.evaluations, meter.left, meter.was_refused) == (7, 0, True)


def test_jacobians_and_free_motions_have_their_price():
    meter = Meter(5, jacobian_cost=3)
    assert meter.ask_jacobian(lambda: "J") == "J" and meter.ask_other(lambda: "modes") == "modes"
    assert (meter.jacobians, meter.others, meter.evaluations, meter.left) == (1, 1, 0, 1)
    with pytest.raises(BudgetSpent):
        meter.ask_jacobian(lambda: pytest.fail("is not evaluated"))
    assert meter.left == 1


def test_a_jacobian_without_a_price_is_never_refused():
    meter = Meter(0)
    meter.ask_jacobian(lambda: None)
    assert (meter.jacobians, meter.left, meter.was_refused) == (1, 0, False)


def test_what_raises_does_not_count():
    meter = Meter(5)
    for ask in (lambda: meter.ask(POINTS, lambda points: 1 / 0), lambda: meter.ask_jacobian(lambda: 1 / 0)):
        with pytest.raises(ZeroDivisionError):
            ask()
    assert meter.spent == 0


def test_without_a_budget_nothing_is_refused():
    meter = Meter()
    meter.ask(POINTS, np.square)
    meter.ask(POINTS[:0], np.square)
    assert (meter.evaluations, meter.left) == (5, None)
