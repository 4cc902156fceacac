"""Statements of an identification on itself."""

import numpy as np
import pytest

from ksmea.plugins.identification import Identification, at_limit


def test_a_thousandth_of_the_range_is_on_the_bound():
    u = np.array([0.0, 0.0009, 0.0011, 0.5, 0.9989, 0.9991, 1.0])
    assert at_limit(u) == (True, True, False, False, False, True, True)


@pytest.mark.parametrize(
    "stop, cut_short",
    [("smc", False), ("sdf", False), ("repeated", False), ("optimizer", False), ("updates", True), ("budget", True)],
)
def test_running_out_is_told_from_converging(stop, cut_short):
    found = Identification(np.zeros(1), (True,), 0.0, stop, 1, 1, 0, 1, {})
    assert found.was_cut_short == cut_short
