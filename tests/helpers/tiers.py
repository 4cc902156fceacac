"""Values of parameters of which most are in the slow tier of tests (CONTRIBUTING.md)."""
# Shorter than 40 lines: one function, which tests of all folders share.

import pytest


def mostly_slow(values, *, but):
    """Values of a parameter, or tuples of several, each marked slow.

    Not marked are those in `but`, and tuples whose first value is.
    """
    return [each if each in but or _first(each) in but else _slow(each) for each in values]


def _first(each):
    return each[0] if isinstance(each, tuple) else each


def _slow(each):
    return pytest.param(*(each if isinstance(each, tuple) else (each,)), marks=pytest.mark.slow)
