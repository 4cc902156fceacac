# Shorter than 40 lines: sources of data draw numbers, models know none that is drawn.
"""Numbers of a model that are known to a tolerance, drawn from their priors.

The machine as it was built, not as it was drawn.
"""

from __future__ import annotations

import numpy as np

from ksmea.arrays import Array
from ksmea.problem.parameters import Parameter
from ksmea.problem.problem import Problem, joint_values

NUMBERS = ("stated", "drawn")
MAX_DRAWS = 1000  # of one number, until it lies within its limits, six standard deviations off or at a physical end


def with_drawn_numbers(problem: Problem, x: Array, rng: np.random.Generator) -> tuple[Problem, Array]:
    """The joint problem, and values (d,) SI of its unknowns.

    x of the problem's own, all numbers with a tolerance drawn.
    """
    joint, own = problem.joint, problem.parameters.names
    numbers = {item.name: _drawn(item, rng) for item in joint.parameters if item.name not in own}
    return joint, joint_values(problem, joint, x, numbers)


def _drawn(parameter: Parameter, rng: np.random.Generator) -> float:
    assert parameter.prior is not None, "an unknown of the problem itself"
    for _ in range(MAX_DRAWS):
        value = float(rng.normal(parameter.prior.value, parameter.prior.sd))
        if parameter.lower <= value <= parameter.upper:
            return value
    raise AssertionError(f"{parameter.name}: no value within its limits in {MAX_DRAWS} draws")
