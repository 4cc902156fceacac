"""One thread of BLAS inside a call, whatever the process uses elsewhere.

Matrices of a rotor are small: further threads gain nothing, wait for each other by spinning, which on a busy machine multiplies the
processor time, and add sums in another order, so that last digits differ.
"""
# Shorter than 40 lines: every function of the public door that computes shares it.

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

P = ParamSpec("P")
R = TypeVar("R")


def one_blas_thread(function: Callable[P, R]) -> Callable[P, R]:
    """The function, with BLAS at one thread until it returns or raises.

    The former number of threads comes back then.

    Libraries are looked for at each call, so that one loaded in the meantime is found.
    """

    @functools.wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        with threadpool_limits(1, user_api="blas"):
            return function(*args, **kwargs)

    return limited
