"""Exams for plugins of one's own.

In a test file, one test for each property:

    from ksmea.testing import check_optimizer
    from my_package.mine import Mine

    test_mine = check_optimizer.tests(Mine())

In a script, `check_optimizer(Mine())` raises `ExamFailed` with all that Mine does not keep. What a plugin is tried with, and
what its author may state of it, is in the docstring of its case; docs/plugins.md has the whole way.
"""

from ksmea.testing.effect import check_effect
from ksmea.testing.exam import ExamFailed
from ksmea.testing.measurement import check_measurement
from ksmea.testing.method import check_method
from ksmea.testing.optimizer import check_optimizer
from ksmea.testing.problem import check_problem
from ksmea.testing.surrogate import check_surrogate

__all__ = [
    "ExamFailed",
    "check_effect",
    "check_measurement",
    "check_method",
    "check_optimizer",
    "check_problem",
    "check_surrogate",
]
