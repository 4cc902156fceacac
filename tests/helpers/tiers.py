"""Parameters of tests of which most are a further draw or variant: those are in the slow tier (CONTRIBUTING.md)."""
# Shorter than 40 lines: one function, which tests of all folders share.

import pytest


def mostly_slow(values, *, but):
    """The values of a parameter (or tuples of several), each marked slow unless it is in `but` or its first is."""
    return [each if each in but or _first(each) in but else _slow(each) for each in values]


def _first(each):
    return each[0] if isinstance(each, tuple) else each


def _slow(each):
    return pytest.param(*(each if isinstance(each, tuple) else (each,)), marks=pytest.mark.slow)
