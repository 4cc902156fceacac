"""Properties of a plugin in a sweep: independence of clocks, and a single process that returns."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from itertools import count
from unittest import mock

import numpy as np

from ksmea.numerics.parallel import CAN_FORK
from ksmea.testing.exam import ExamFailed, require
from ksmea.testing.repeat import Drawn

CLOCKS = ("time", "monotonic", "perf_counter", "process_time")
STEP = 3600.0  # s that pass between two looks at a clock: no time limit is longer
RETURNED = b"r"


def one_process_returns(case: Drawn) -> None:
    """A fork of its own ends by itself: one process alone returns what was found."""
    if not CAN_FORK:
        return
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        _return_once(lambda: case.outcome(1), writing)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        returned = pipe.read()
    with suppress(ChildProcessError):
        os.waitpid(child, 0)
    require(
        len(returned) <= 1,
        "one process that returns",
        f"{len(returned)}",
        "end a fork by os._exit in the child, or use multiprocessing, joblib or concurrent.futures",
    )


def _return_once(function: Callable[[], object], writing: int) -> None:
    """The life of a fork in which a plugin runs.

    Each process that returns, also one that the plugin has forked, says so and ends.
    """
    try:
        with suppress(BaseException):
            function()
        os.write(writing, RETURNED)
    finally:
        os._exit(0)


def clock_plays_no_part(case: Drawn) -> None:
    """With the same budget it finds the same, however fast the objective and the processor are."""
    first = case.outcome(1)
    with fast_clocks():
        try:
            again = case.outcome(1)
        except Exception as error:
            raise ExamFailed(
                f"expected the same however much time passes, got {type(error).__name__}: {error}; end by the budget, not by a clock"
            ) from error
    same = first.shape == again.shape and np.array_equal(first, again, equal_nan=True)
    got = f"{first.size} and {again.size} numbers, or others"
    require(same, "the same numbers however much time passes", got, "end by the budget, not by a clock")


@contextmanager
def fast_clocks() -> Iterator[None]:
    """Make each look at a clock of the module `time` an hour after the last one.

    This is as in a run that is that slow.
    """
    steps = count(1)
    with ExitStack() as patched:
        for name in CLOCKS:
            begin = getattr(time, name)()
            patched.enter_context(mock.patch.object(time, name, lambda begin=begin: begin + STEP * next(steps)))
        yield


IN_A_SWEEP = (one_process_returns, clock_plays_no_part)
