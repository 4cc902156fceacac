"""Reproducibility: a seed gives equal numbers again, also in another process.

The state of shared generators makes no difference.
"""

from __future__ import annotations

import dataclasses
import multiprocessing
import pickle
import random
from abc import abstractmethod
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

from ksmea.arrays import Array
from ksmea.numerics.isolation import global_generators
from ksmea.testing.exam import Case, ExamFailed, require

DRAW = "draw from the generator that is handed over, and from nothing else"


@dataclass(frozen=True)
class Drawn(Case):
    """A case whose plugin draws random numbers."""

    @abstractmethod
    def outcome(self, seed: int) -> Array:
        """Numbers that the plugin finds with generators of a seed, made anew."""


def same_seed_same_result(case: Drawn) -> None:
    """A seed gives one result, whatever has run before in the process."""
    first = case.outcome(1)
    case.outcome(2)
    _require_same(first, case.outcome(1), "in a second run", f"keep nothing from run to run, and {DRAW}")


def workers_give_the_same(case: Drawn) -> None:
    """Another process gives the same result."""
    found = in_fresh_process(dataclasses.replace(case).outcome, 1)  # without what this one keeps
    do = f"depend on no order of sets, no process number and no time, and {DRAW}"
    _require_same(case.outcome(1), found, "in another process", do)


def shared_generators_play_no_part(case: Drawn) -> None:
    """The generators of `random` and `numpy.random` neither change the result nor are changed."""
    found = []
    for seed in (1, 2):
        with global_generators(np.random.default_rng(seed)):
            before = _shared_state()
            found.append(case.outcome(1))
            after = _shared_state()
        library = "a library that draws from them goes inside ksmea.numerics.isolation.global_generators(rng)"
        require(before == after, "random and numpy.random left as they were", "another state", library)
    _require_same(found[0], found[1], "with other states of random and numpy.random", f"{DRAW}; {library}")


def _shared_state() -> bytes:
    return pickle.dumps((random.getstate(), np.random.get_state()))


def in_fresh_process(function: Callable[[int], Array], seed: int) -> Array:
    """Result of a function in a new process, which imports all that it needs and hashes differently."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        try:
            return pool.submit(function, seed).result()
        except BrokenExecutor as error:
            raise ExamFailed(
                "expected a plugin that another process can import, got a process that ended; define it at the top of a module"
                " on Python's path, and put what a script does under if __name__ == '__main__'"
            ) from error


def _require_same(first: Array, again: Array, where: str, do: str) -> None:
    apart = "another count" if first.shape != again.shape else f"{np.count_nonzero(first != again)} that differ"
    require(np.array_equal(first, again, equal_nan=True), f"the same {first.size} numbers {where}", apart, do)


OF_DRAWS = (same_seed_same_result, workers_give_the_same, shared_generators_play_no_part)
