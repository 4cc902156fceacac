"""When left-out data support an extension: blocks made up, exact p-values by hand."""

import numpy as np
import pytest

from ksmea.records.extension import ElpdDifference


def blocks(*values):
    return ElpdDifference(np.array(values, dtype=float))


def test_all_blocks_better_by_very_different_amounts_is_supported():
    """One block dominates the sum and its standard error, so that two standard errors would prove nothing."""
    found = blocks(1.5e6, 90, 40, 35, 12, 7)
    assert found.total < 2 * found.standard_error
    assert found.n_better == 6 and found.p_sign == found.p_wilcoxon == pytest.approx(2**-6)
    assert found.median == 37.5 and found.is_supported


def test_half_of_the_blocks_better_is_not_supported():
    found = blocks(1.5e6, 90, 40, -35, -12, -7)
    assert found.total > 0 and found.n_better == 3 and found.p_sign == pytest.approx(42 / 64)
    # signed ranks 6 + 5 + 4 = 15 of 21: 14 of the 64 sign patterns give at least that
    assert found.p_wilcoxon == pytest.approx(14 / 64) and not found.is_supported


def test_one_worse_block_is_judged_by_its_rank():
    """The smallest difference may be negative (signed ranks 20 of 21: 2 patterns of 64), a large one may not."""
    small, large = blocks(50, 40, 30, 20, 10, -1), blocks(50, 40, 30, 20, 10, -45)
    assert small.p_sign == large.p_sign == pytest.approx(7 / 64)
    assert small.p_wilcoxon == pytest.approx(2 / 64) and small.is_supported
    assert large.p_wilcoxon == pytest.approx(10 / 64) and not large.is_supported


def test_a_lower_elpd_is_never_supported_whatever_the_ranks():
    """One block that is predicted far worse outweighs fourteen better ones."""
    found = blocks(*range(1, 15), -1e4)
    assert found.p_wilcoxon < 0.05 and found.total < 0 and not found.is_supported


@pytest.mark.parametrize(("n_block", "is_supported"), [(2, False), (4, False), (5, True)])
def test_fewer_than_five_blocks_cannot_support(n_block, is_supported):
    assert blocks(*range(1, n_block + 1)).is_supported == is_supported


def test_equal_predictions_are_no_support():
    found = blocks(0, 0, 0, 0, 0, 0)
    assert found.p_sign == found.p_wilcoxon == 1 and found.standard_error == 0 and not found.is_supported
