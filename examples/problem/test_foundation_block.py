import numpy as np
import pytest
from foundation_block import FoundationBlock

import ksmea
from ksmea.testing import check_problem

BLOCK = FoundationBlock()
PROBLEM = BLOCK.build()
X = np.array([*BLOCK.reference().values()])

test_exam = check_problem.tests(FoundationBlock())


def test_far_above_resonance_the_block_moves_as_its_mass_alone_asks():
    fast = PROBLEM.at(np.array([1e5]), PROBLEM.channels)
    assert fast.response(X[None])[0, 0, 0] == pytest.approx(-BLOCK.exciter / BLOCK.mass, rel=1e-4)


def test_sensitivity_is_the_slope_of_the_response():
    for index, step in enumerate((10.0, 0.1)):
        shift = step * np.eye(2)[index]
        above, below = PROBLEM.response(np.stack([X + shift, X - shift]))
        # the error of a central difference is of the second order in the step, 1e-6 of the unknown
        assert PROBLEM.sensitivity(X)[..., index] == pytest.approx((above - below) / (2 * step), rel=1e-5)


def test_stiffness_and_damping_are_found_again():
    block = ksmea.LoadedProblem("foundation_block", BLOCK, PROBLEM)
    found = ksmea.identify(block, ksmea.synthetic_measurement(block, relative=0.05))
    for name, truth in block.reference.items():
        assert found[name].low < truth < found[name].high
