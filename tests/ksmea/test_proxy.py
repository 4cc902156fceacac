"""A proxy hands on all members it does not override, and nothing that its own unknowns change."""

import numpy as np
import pytest

from campaigns import TRIAL, TRUTH, layout_of
from ksmea.plugins.registry import create
from ksmea.problem.alignment import aligned
from ksmea.problem.counted import CountedProblem
from problems.three_disk import ThreeDisk

PROBLEM = ThreeDisk().build()
LAYOUT = layout_of(PROBLEM, [PROBLEM.speed[:9]] * 2, [("bare", ()), ("trial", (TRIAL,))], own=("kxx",))
RUNS = aligned(PROBLEM, LAYOUT)
X = np.array([TRUTH[name.partition("@")[0]] for name in RUNS.parameters.names])
BOWED = create("effect", "residual_bow", {}).added_to(PROBLEM)


@pytest.mark.parametrize("problem", [RUNS, BOWED, CountedProblem(RUNS), CountedProblem(BOWED)])
def test_the_shaft_and_what_it_takes_are_those_behind(problem):
    assert problem.landmarks == PROBLEM.landmarks and np.array_equal(problem.sites, PROBLEM.sites)
    assert problem.channels == PROBLEM.channels and problem.takes_loads and problem.takes_unbalance
    assert problem.has_sensitivity and problem.has_dense_route and problem.knows_stability


def test_stability_is_asked_of_each_with_its_own_unknowns():
    assert RUNS.is_stable(X) and CountedProblem(RUNS).is_stable(X)
    assert RUNS.stability_threshold(X, 1500.0) == np.inf
    x = np.append(np.array([ThreeDisk().reference()[name] for name in PROBLEM.parameters.names]), [0.0, 0.0])
    assert BOWED.is_stable(x[: len(BOWED.parameters)])


def test_the_modes_of_a_rotor_with_effects_come_through_a_proxy():
    """A bow is a load: it leaves critical speeds where they are, within the 1e-5 of the reduced space they are found in."""
    x = np.zeros(len(BOWED.parameters))
    x[: len(BOWED.plain.parameters)] = BOWED.plain.parameters.lower
    plain = BOWED.plain.critical_speeds(x[: len(BOWED.plain.parameters)])
    assert BOWED.critical_speeds(x) == pytest.approx(plain, rel=1e-5)


def test_what_is_counted_stays_counted_through_every_change():
    counted = CountedProblem(RUNS)
    for problem in (
        counted.at(PROBLEM.speed[:3], PROBLEM.channels),
        counted.with_unbalance(0.2, 1e-5, 0.0),
        counted.machine,
    ):
        before = counted.meter.evaluations
        problem.response(X[None, : len(problem.parameters)])
        assert counted.meter.evaluations == before + 1
