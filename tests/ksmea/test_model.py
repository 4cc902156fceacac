"""The counted true model: nothing that a problem can be asked for a response gets past the count."""

import numpy as np
import pytest

from ksmea.problem.counted import CountedProblem
from ksmea.problem.forwarding import HANDED_ON
from ksmea.problem.problem import Problem
from problems.three_disk import ThreeDisk


def test_every_member_of_the_contract_that_responds_or_makes_a_problem_is_counted():
    """By what the contract says it returns: a response, or a problem that could be asked for one."""
    gives = {
        name
        for name, member in vars(Problem).items()
        if not name.startswith("_") and any(word in str(_returned(member)) for word in ("ComplexArray", "Problem"))
    }
    assert {"response", "sensitivity", "linearised", "at", "with_unbalance"} <= gives
    assert gives.isdisjoint(set(HANDED_ON) - set(vars(CountedProblem)))


def _returned(member):
    return getattr(getattr(member, "fget", member), "__annotations__", {}).get("return")


def test_all_else_is_that_of_the_problem_behind():
    problem = ThreeDisk().build()
    counted = CountedProblem(problem)
    for name in ("parameters", "speed", "channels", "sites", "costly", "has_free_phase", "can_leave_phase_open"):
        assert np.all(getattr(counted, name) == getattr(problem, name))
    assert counted.has_sensitivity and counted.takes_unbalance and counted.has_dense_route
    x = problem.parameters.to_si(np.full(5, 0.5))
    assert np.array_equal(counted.critical_speeds(x), problem.critical_speeds(x))
    assert np.array_equal(counted.response(x[None]), problem.response(x[None]))
    response, sensitivity = counted.linearised(x)
    assert np.array_equal(response, problem.response(x[None])[0])
    assert np.array_equal(sensitivity, problem.sensitivity(x))
    assert (counted.meter.evaluations, counted.meter.jacobians) == (1, 1) and counted.meter.seconds > 0


def test_what_raises_is_no_evaluation():
    counted = CountedProblem(ThreeDisk().build())
    with pytest.raises(ValueError, match="expected an array"):
        counted.response(np.zeros((1, 2)))
    assert counted.meter.evaluations == 0
